/* Limits at which the board stops the schedule. */
#ifndef HB_SAFETY_H
#define HB_SAFETY_H

#include "sensors.h"
#include "settings.h"

typedef struct {
    float travel_min_m;
    float travel_max_m;
    float stopping_time_s; /* stopping distance after the valves close: v times this */
    float pressure_max_pa;
    float speed_max_m_s;
    float speed_error_max_m_s;
    hb_u32 speed_error_ticks;
    hb_u32 heartbeat_ticks;
} hb_safety_config;

typedef struct {
    hb_u32 silence_ticks; /* since the host's last request that the board knows */
    hb_u32 error_ticks;   /* since the speed error exceeds its limit */
} hb_safety_state;

hb_safety_config hb_safety_design(const hb_settings *settings);
void hb_safety_init(hb_safety_state *state);

/* Checks one tick of a schedule; returns the fault, HB_FAULT_NONE without one. NaN is a fault. */
hb_u16 hb_safety_step(const hb_safety_config *config, hb_safety_state *state,
                      const hb_sensors_state *sensors, float v_ref_m_s);

#endif
