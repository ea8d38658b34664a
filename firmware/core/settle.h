/* Whether something that each cycle of a run repeats has stopped changing: the friction while the
 * oil warms up, the piston's lag behind its reference while trapped air leaves. */
#ifndef HB_SETTLE_H
#define HB_SETTLE_H

#include "types.h"

#define HB_CALM_CYCLES 2u /* in a row */

typedef struct {
    float sum; /* over the present cycle ... */
    float rest; /* ... and what its last digit could not take (Kahan) */
    hb_u32 ticks;
    float mean;   /* of the cycle before */
    hb_u16 calm;  /* cycles in a row that changed little */
    bool compare; /* there is a cycle before */
} hb_settle;

void hb_settle_init(hb_settle *settle);
void hb_settle_add(hb_settle *settle, float value);

/* The cycle is over. True when the means of HB_CALM_CYCLES cycles in a row differed from the one
 * before each by at most within times their own size. */
bool hb_settle_cycle(hb_settle *settle, float within);

#endif
