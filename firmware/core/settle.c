#include "settle.h"

#include "numeric.h"

void hb_settle_init(hb_settle *settle)
{
    settle->sum = 0.0f;
    settle->compensation = 0.0f;
    settle->ticks = 0;
    settle->mean = 0.0f;
    settle->settled_cycles = 0;
    settle->compare = false;
}

void hb_settle_add(hb_settle *settle, float value)
{
    const float term = value - settle->compensation;
    const float sum = settle->sum + term;

    settle->compensation = (sum - settle->sum) - term;
    settle->sum = sum;
    settle->ticks++;
}

bool hb_settle_cycle(hb_settle *settle, float within)
{
    const float mean = settle->ticks > 0u ? settle->sum / (float)settle->ticks : 0.0f;
    const bool small = settle->compare && hb_abs(mean - settle->mean) <= within * hb_abs(mean);

    settle->settled_cycles = small ? (hb_u16)(settle->settled_cycles + 1u) : 0u;
    settle->mean = mean;
    settle->compare = true;
    settle->sum = 0.0f;
    settle->compensation = 0.0f;
    settle->ticks = 0;
    return settle->settled_cycles >= HB_SETTLED_CYCLES;
}
