#include "safety.h"

#include "numeric.h"

hb_safety_config hb_safety_design(const hb_settings *settings)
{
    const float *value = settings->value;
    hb_safety_config config;

    config.travel_min_m = value[HB_SETTING_TRAVEL_MIN_M];
    config.travel_max_m = value[HB_SETTING_TRAVEL_MAX_M];
    config.pressure_max_pa = value[HB_SETTING_PRESSURE_MAX_PA];
    config.speed_max_m_s = value[HB_SETTING_SPEED_MAX_M_S];
    config.heartbeat_ticks = hb_ticks(value[HB_SETTING_HEARTBEAT_S], (float)HB_RATE_HZ);
    return config;
}

hb_u16 hb_safety_check(const hb_safety_config *config, const hb_sensors_state *sensors,
                       hb_u32 silence_ticks)
{
    const float x = sensors->value[HB_SENSOR_X];

    if (!(x >= config->travel_min_m && x <= config->travel_max_m)) {
        return HB_FAULT_TRAVEL;
    }
    for (hb_u16 i = HB_SENSOR_P_TP; i <= HB_SENSOR_P_S; i++) {
        if (!(sensors->value[i] <= config->pressure_max_pa)) {
            return HB_FAULT_PRESSURE;
        }
    }
    if (!(hb_abs(sensors->velocity.v) <= config->speed_max_m_s)) {
        return HB_FAULT_SPEED;
    }
    return silence_ticks > config->heartbeat_ticks ? HB_FAULT_HEARTBEAT : HB_FAULT_NONE;
}
