/* When the board stops by itself. */
#ifndef HB_SAFETY_H
#define HB_SAFETY_H

#include "config.h"
#include "sensors.h"
#include "settings.h"

typedef struct {
    float travel_min_m;
    float travel_max_m;
    float pressure_max_pa;
    float speed_max_m_s;
    hb_u32 heartbeat_ticks;
} hb_safety_config;

hb_safety_config hb_safety_design(const hb_settings *settings);

/* The fault to stop for, HB_FAULT_NONE if all is well. A value that is not a number is a fault.
 * silence_ticks: since the host's last sound frame. */
hb_u16 hb_safety_check(const hb_safety_config *config, const hb_sensors_state *sensors,
                       hb_u32 silence_ticks);

#endif
