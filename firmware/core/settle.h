/* Test whether the mean of a quantity over a cycle has settled: the friction while the oil warms
 * up, or the speed error while trapped air leaves. */
#ifndef HB_SETTLE_H
#define HB_SETTLE_H

#include "types.h"

#define HB_SETTLED_CYCLES 2u /* consecutive */

typedef struct {
    float sum;             /* over the present cycle, compensated (Kahan) */
    float compensation;    /* rounding error of the sum */
    hb_u32 ticks;
    float mean;            /* of the previous cycle */
    hb_u16 settled_cycles; /* consecutive cycles with a small change */
    bool compare;          /* a previous cycle exists */
} hb_settle;

void hb_settle_init(hb_settle *settle);
void hb_settle_add(hb_settle *settle, float value);

/* Ends a cycle. True when each of the last HB_SETTLED_CYCLES means differed from the mean before it
 * by at most within times its own magnitude. */
bool hb_settle_cycle(hb_settle *settle, float within);

#endif
