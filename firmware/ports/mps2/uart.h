/* UART0 of the board (Arm CMSDK) with a queue for each direction; reception by interrupt. The
 * emulated UART has no baud rate: octets arrive as fast as the interrupt reads them. */
#ifndef MPS2_UART_H
#define MPS2_UART_H

#include <stdbool.h>
#include <stdint.h>

void uart_init(void);
void uart_receive_interrupt(void);

/* Sleeps until this number of octets has been received since reset (modulo 2^32). */
void uart_await(uint32_t received);

bool uart_take(uint8_t *octet);

/* Queues an octet; false if the queue is full. */
bool uart_put(uint8_t octet);
/* Sends all queued octets. */
void uart_flush(void);

#endif
