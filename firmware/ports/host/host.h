/* The firmware on a desktop: the core between two queues of octets, stepped by its caller. */
#ifndef HB_HOST_H
#define HB_HOST_H

#include "link.h"

typedef struct hb_host hb_host;

/* Returns NULL without memory. boots: the number of starts that the board reports. baud: rate of
 * the line in both directions (10 bits per octet, timed by the ticks), 0: octets take no time.
 * With a baud rate hb_host_poll must be called after each tick. */
hb_host *hb_host_create(uint16_t boots, uint32_t baud);
void hb_host_destroy(hb_host *host);

/* One control tick: HB_INPUTS converter words in, HB_VALVES DAC codes out. */
void hb_host_tick(hb_host *host, const uint16_t *adc, int16_t *dac);

/* Reports a late control interrupt. */
void hb_host_overrun(hb_host *host);

/* One iteration of the idle loop. Returns the number of octets for the host, 0 unless they contain
 * the end of a frame. */
uint32_t hb_host_poll(hb_host *host);

/* Receives octets from the host; returns the number accepted. The rest is lost, as on a UART. */
uint32_t hb_host_receive(hb_host *host, const unsigned char *octets, uint32_t count);

/* Copies up to capacity octets for the host; returns their number. */
uint32_t hb_host_transmit(hb_host *host, unsigned char *octets, uint32_t capacity);

/* The uploaded schedule begins by venting: its operator has switched the supply off. */
uint32_t hb_host_needs_supply_off(const hb_host *host);

/* The state of the core, for tests. */
const hb_core *hb_host_core(const hb_host *host);

#endif
