/* SCI-A on GPIO28 and GPIO29, 8N1, with its FIFOs. Never compiled by TI's compiler. */
#ifndef HB_UART_H
#define HB_UART_H

#include "types.h"

#ifndef HB_BAUD
#define HB_BAUD 115200UL /* 0.8 % off; 468750 and 937500 are exact */
#endif

void hb_uart_start(void);

/* From the receive interrupt. */
void hb_uart_receive(void);

/* Functions of the hb_hal; context is not used. */
bool hb_uart_read(void *context, hb_octet *octet);
hb_u16 hb_uart_write(void *context, const hb_octet *octets, hb_u16 count);

/* From the idle loop: restarts the receiver after a break of the line or a FIFO overrun. The host
 * repeats requests that were lost. */
void hb_uart_recover(void);

#endif
