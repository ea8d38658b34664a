#include "vent.h"

#include "numeric.h"

/* Small openings, so that the piston moves slowly should the supply come on. */
#define HB_VENT_V 0.5f
#define HB_VENT_SIDE_S 0.25f
/* The supply is on: at the begin, above a tank's pressure and a transducer's zero error; later,
 * above what the chambers' oil can raise it to. */
#define HB_VENT_BEGIN_PA 10e5f
#define HB_VENT_SUPPLY_PA 40e5f
#define HB_VENT_SUPPLY_S 1.0f

void hb_vent_init(hb_vent *vent)
{
    vent->ticks = 0;
    vent->supply_ticks = 0;
}

void hb_vent_step(hb_vent *vent, float p_s_pa)
{
    vent->ticks++;
    const float limit = vent->ticks <= 1u ? HB_VENT_BEGIN_PA : HB_VENT_SUPPLY_PA;
    const bool low = p_s_pa <= limit; /* NaN is high */
    vent->supply_ticks = low ? 0u : vent->supply_ticks + 1u;
}

float hb_vent_command_v(const hb_vent *vent)
{
    const hb_u32 side = vent->ticks / hb_ticks(HB_VENT_SIDE_S);
    return side % 2u == 0u ? HB_VENT_V : -HB_VENT_V;
}

bool hb_vent_under_pressure(const hb_vent *vent)
{
    const hb_u32 limit = vent->ticks <= 1u ? 0u : hb_ticks(HB_VENT_SUPPLY_S);
    return vent->supply_ticks > limit;
}
