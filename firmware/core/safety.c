#include "safety.h"

#include "numeric.h"

hb_safety_config hb_safety_design(const hb_settings *settings)
{
    const float *value = settings->value;
    hb_safety_config config;

    config.travel_min_m = value[HB_SETTING_TRAVEL_MIN_M];
    config.travel_max_m = value[HB_SETTING_TRAVEL_MAX_M];
    config.stopping_time_s = value[HB_SETTING_STOPPING_TIME_S];
    config.pressure_max_pa = value[HB_SETTING_PRESSURE_MAX_PA];
    config.speed_max_m_s = value[HB_SETTING_SPEED_MAX_M_S];
    config.speed_error_max_m_s = value[HB_SETTING_SPEED_ERROR_MAX_M_S];
    config.speed_error_ticks = hb_ticks(value[HB_SETTING_SPEED_ERROR_TIME_S]);
    config.heartbeat_ticks = hb_ticks(value[HB_SETTING_HEARTBEAT_S]);
    return config;
}

void hb_safety_init(hb_safety_state *state)
{
    state->silence_ticks = 0;
    state->error_ticks = 0;
}

/* The piston is within its travel, and would stop within it if the valves closed now. */
static bool within_travel(const hb_safety_config *config, const hb_sensors_state *sensors)
{
    const float x = sensors->value[HB_SENSOR_X];
    const float stop = x + sensors->velocity.v * config->stopping_time_s;

    return hb_min(x, stop) >= config->travel_min_m && hb_max(x, stop) <= config->travel_max_m;
}

static bool pressures_are_low(const hb_safety_config *config, const hb_sensors_state *sensors)
{
    for (hb_u16 i = HB_SENSOR_P_TP; i <= HB_SENSOR_P_S; i++) {
        if (!(sensors->value[i] <= config->pressure_max_pa)) {
            return false;
        }
    }
    return true;
}

hb_u16 hb_safety_step(const hb_safety_config *config, hb_safety_state *state,
                      const hb_sensors_state *sensors, float v_ref_m_s)
{
    const float v = sensors->velocity.v;
    const bool excessive = !(hb_abs(v_ref_m_s - v) <= config->speed_error_max_m_s);

    state->silence_ticks++;
    state->error_ticks = excessive ? state->error_ticks + 1u : 0u;

    if (sensors->impossible) { /* first, because the checks below rely on the sensors */
        return HB_FAULT_SENSOR;
    }
    if (!within_travel(config, sensors)) {
        return HB_FAULT_TRAVEL;
    }
    if (!pressures_are_low(config, sensors)) {
        return HB_FAULT_PRESSURE;
    }
    if (!(hb_abs(v) <= config->speed_max_m_s)) {
        return HB_FAULT_SPEED;
    }
    if (state->error_ticks > config->speed_error_ticks) {
        return HB_FAULT_SPEED_ERROR;
    }
    return state->silence_ticks > config->heartbeat_ticks ? HB_FAULT_HEARTBEAT : HB_FAULT_NONE;
}
