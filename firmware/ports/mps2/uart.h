/* UART0 of the board (Arm CMSDK): received by interrupt into a queue, sent from another one. The
 * emulated UART has no baud rate: a burst of the host comes as fast as the interrupt takes it. */
#ifndef MPS2_UART_H
#define MPS2_UART_H

#include <stdbool.h>
#include <stdint.h>

void uart_init(void);
void uart_receive_interrupt(void);

/* Sleeps until so many octets have come in since reset (modulo 2^32). */
void uart_await(uint32_t received);

bool uart_take(uint8_t *octet);

/* Queues an octet; false if there is no room. */
bool uart_put(uint8_t octet);
/* Waits until all that is queued has gone. */
void uart_flush(void);

#endif
