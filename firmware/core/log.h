/* The log: a ring of records of 16-bit words. Records are numbered from 0 since the board's
 * start, so that the host can request a missed record again. The newest record of a run is
 * withheld until it is known whether it is the run's last. A record that is incomplete at the
 * run's end is dropped. */
#ifndef HB_LOG_H
#define HB_LOG_H

#include "hal.h"

/* One tick of a run. */
typedef struct {
    const hb_u16 *adc; /* HB_INPUTS words */
    const float *u;    /* HB_VALVES commands [V] */
    float v_m_s;
    float v_ref_m_s;
    hb_u16 flags; /* of this tick */
} hb_sample;

typedef struct {
    hb_log_record *ring;
    hb_u16 records; /* of the ring, a power of two: a record's slot is its number's low bits */
    hb_u32 next;    /* number of the next record */
    hb_u16 divider; /* ticks per record */

    hb_u16 run;
    hb_u16 index;         /* of the next record in its run */
    hb_log_record newest; /* withheld */
    bool withheld;        /* newest holds a record */

    hb_u16 ticks; /* summed since the last record */
    hb_u32 word_sum[HB_INPUTS];
    float u_sum[HB_VALVES];
    float v_sum;
    hb_u16 any_flags;
    hb_u16 all_flags;
} hb_log;

void hb_log_init(hb_log *log, hb_log_record *ring, hb_u16 records);
void hb_log_begin(hb_log *log, hb_u16 run, hb_u16 divider);
void hb_log_add(hb_log *log, const hb_sample *sample);
/* flags: added to the run's last record; HB_FLAG_LAST if the run was completed. */
void hb_log_end(hb_log *log, hb_u16 flags);

/* The numbers suffice for another schedule. Half of them are used up after at least two and a half
 * days of motion (one record a tick), 248 days at 100 Hz. */
bool hb_log_has_numbers(const hb_log *log);
/* Number of the oldest record in the ring; log->next if the ring is empty. */
hb_u32 hb_log_first(const hb_log *log);
/* The words of a record between hb_log_first and log->next. */
const hb_u16 *hb_log_words(const hb_log *log, hb_u32 number);

#endif
