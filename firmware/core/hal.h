/* The whole port contract: what the core asks of a board, and what a board calls.
 *
 * A port
 *   - allocates an hb_core and an hb_log_ring (the ring apart, so that a linker can place it),
 *     fills an hb_hal and calls hb_core_init once;
 *   - calls hb_core_tick from the control interrupt, 10 000 times a second, with the converter's
 *     words in the order of the dictionary's sensors (each the mean of the tick's conversions, in
 *     1/16 of a count: 0..65520), and hands the three codes to the DAC at once;
 *   - calls hb_core_overrun from there when that tick came late or was not over before the next
 *     one was due; from then on the valves are neutral;
 *   - calls hb_core_poll from the idle loop, at least once a millisecond or so. It is the one
 *     place where octets come and go;
 *   - keeps at least 64 octets from the host until it reads them, while a reply is on its way: a
 *     host has several requests in flight.
 *
 * hb_core_tick may interrupt hb_core_poll, never the other way round. While a request is carried
 * out the core masks the control interrupt: for some microseconds while a schedule runs ("read_log",
 * the long one, masks record by record), up to a millisecond at rest (valves in neutral), where
 * "start" checks what was uploaded.
 */
#ifndef HB_HAL_H
#define HB_HAL_H

#include "types.h"

typedef struct {
    void *context;     /* handed back in every call */
    const char *board; /* at most 16 characters */

    /* The next octet from the host, if one has come. Bits above the eighth don't matter. */
    bool (*uart_read)(void *context, hb_octet *octet);

    /* Takes up to count octets for the host; returns how many. Never waits. */
    hb_u16 (*uart_write)(void *context, const hb_octet *octets, hb_u16 count);

    /* Hold back and let through the control interrupt. Never nested. */
    void (*mask_control)(void *context);
    void (*unmask_control)(void *context);
} hb_hal;

#endif
