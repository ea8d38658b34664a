/* The port contract: all that a board provides to the core, and all the calls that it makes.
 *
 * A port
 *   - allocates an hb_core, an hb_link and the log's ring, fills an hb_hal, and after a reset calls
 *     hb_core_init and hb_link_init once;
 *   - calls hb_core_tick from the control interrupt, HB_RATE_HZ times a second, with the converter
 *     words of the tick, and writes the three codes to the DAC at once;
 *   - calls hb_core_overrun from there if that tick began late, or did not end before the next
 *     tick was due; from then on the valves are neutral;
 *   - calls hb_link_poll from the idle loop, at least once a millisecond or so. All octets from and
 *     to the host pass through this call;
 *   - buffers at least 64 octets from the host until the core reads them, also while a reply is
 *     being sent: a host has several requests in flight.
 *
 * hb_core_tick may interrupt hb_link_poll, never the other way round. While the core executes a
 * request it masks the control interrupt: for some microseconds while a schedule runs ("read_log",
 * the longest request, masks record by record), for up to a millisecond at rest (valves neutral),
 * where "start" checks the uploaded schedule.
 */
#ifndef HB_HAL_H
#define HB_HAL_H

#include "dictionary.h"
#include "types.h"

#define HB_RATE_HZ 10000u
#define HB_PERIOD_S 1e-4f

/* Valves in the order of a tick's DAC codes. The order of its converter words is that of enum
 * hb_sensor in dictionary.h, then the auxiliary input: oil temperature, which is only logged, or
 * acceleration; 0 where nothing is connected. */
enum hb_valve { HB_VALVE_T = 0, HB_VALVE_L1 = 1, HB_VALVE_L2 = 2, HB_VALVES = 3 };

/* A converter word: the mean of a tick's conversions in 1/65536 of the ADC's range. */
typedef struct {
    hb_u16 full_scale; /* word of the highest code; 12 bits: 16 x 4095 */
    hb_u16 margin;     /* a word this close to either end may come from an open input */
} hb_adc_scale;

/* DAC codes are signed; code 0 gives 0 V, a valve's neutral. */
typedef struct {
    float range_v; /* outputs within +-range_v */
    float codes_per_v;
    hb_i16 code_min;
    hb_i16 code_max;
} hb_dac_scale;

/* A slot of the log's ring. */
typedef hb_u16 hb_log_record[HB_RECORD_WORDS];

typedef struct {
    const char *board; /* name, at most 16 characters */
    hb_u16 boots;      /* a number that differs after each reset */
    hb_adc_scale adc;
    hb_dac_scale dac;
    hb_log_record *ring;
    hb_u16 ring_records; /* a power of two; assert it with HB_RING_SIZE_IS_VALID */

    void *context; /* first argument of the functions below */

    /* Takes the next octet from the host; false if none has arrived. Bits above the eighth are
     * ignored. */
    bool (*uart_read)(void *context, hb_octet *octet);

    /* Accepts up to count octets for the host and returns their number. Never waits. */
    hb_u16 (*uart_write)(void *context, const hb_octet *octets, hb_u16 count);

    /* Disable and enable the control interrupt. Never nested. */
    void (*mask_control)(void *context);
    void (*unmask_control)(void *context);
} hb_hal;

#define HB_RING_SIZE_IS_VALID(records) ((records) > 0u && ((records) & ((records) - 1u)) == 0u)

typedef struct hb_core hb_core; /* defined in core.h */
typedef struct hb_link hb_link; /* defined in link.h */

void hb_core_init(hb_core *core, const hb_hal *hal);
void hb_core_tick(hb_core *core, const hb_u16 adc[HB_INPUTS], hb_i16 dac[HB_VALVES]);
void hb_core_overrun(hb_core *core);
void hb_link_init(hb_link *link, hb_core *core);
void hb_link_poll(hb_link *link);

#endif
