/* USART2, 8N1, on PA2 and PA3: the USB serial port of a Nucleo's ST-Link. Reception by interrupt
 * into a queue; transmission by the idle loop. Never run on hardware. */
#ifndef STM32F4_UART_H
#define STM32F4_UART_H

#include "types.h"

#ifndef HB_BAUD
#define HB_BAUD 115200u
#endif

void uart_start(void);
void uart_receive_interrupt(void);

/* Functions of the hb_hal; context is not used. */
bool uart_read(void *context, hb_octet *octet);
hb_u16 uart_write(void *context, const hb_octet *octets, hb_u16 count);

/* The last uart_write did not accept all octets. */
bool uart_is_sending(void);

#endif
