/* Venting of the chambers for a zero check: all valves open to either side in turn, with the supply
 * off. */
#ifndef HB_VENT_H
#define HB_VENT_H

#include "types.h"

typedef struct {
    hb_u32 ticks;        /* since venting began */
    hb_u32 supply_ticks; /* since the supply's pressure was low */
} hb_vent;

void hb_vent_init(hb_vent *vent);
/* One tick, with the supply's pressure. */
void hb_vent_step(hb_vent *vent, float p_s_pa);

/* Command of all valves [V]. */
float hb_vent_command_v(const hb_vent *vent);

/* The supply is on. The chambers' oil may raise its pressure for a second. */
bool hb_vent_under_pressure(const hb_vent *vent);

#endif
