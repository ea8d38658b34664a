/* The firmware on a desktop: the core behind two queues of octets, stepped by its caller. */
#ifndef HB_HOST_H
#define HB_HOST_H

#include "link.h"

typedef struct hb_host hb_host;

/* NULL if there is no memory. boots: what the board reports as its number of starts. baud: of the
 * line in both directions, where an octet takes 10 bits and the ticks are its clock; 0: octets take
 * no time. With a baud rate the idle loop must come round each tick. */
hb_host *hb_host_create(uint16_t boots, uint32_t baud);
void hb_host_destroy(hb_host *host);

/* One control tick: seven converter words in, three DAC codes out. */
void hb_host_tick(hb_host *host, const uint16_t *adc, int16_t *dac);

/* The control interrupt came late. */
void hb_host_overrun(hb_host *host);

/* One round of the idle loop. Returns the number of octets that wait for the host, 0 until a frame
 * has ended among them. */
uint32_t hb_host_poll(hb_host *host);

/* Octets from the host; returns how many found room, the rest is lost as on an overrun UART. */
uint32_t hb_host_receive(hb_host *host, const unsigned char *octets, uint32_t count);

/* Octets for the host, at most capacity; returns how many. */
uint32_t hb_host_transmit(hb_host *host, unsigned char *octets, uint32_t capacity);

/* The core, for tests to look into. */
const hb_core *hb_host_core(const hb_host *host);

#endif
