#include "settings.h"

#include "config.h"
#include "crc.h"

/* The step per tick of a slower ramp would be lost in rounding, and the ramp would never end. */
#define MIN_PRESSURE_SLEW_PA_S 1e5f
#define MIN_ACCELERATION_M_S2 0.01f

void hb_settings_init(hb_settings *settings)
{
    for (hb_u16 i = 0; i < HB_SETTINGS; i++) {
        settings->value[i] = 0.0f;
        settings->known[i] = false;
    }
}

void hb_settings_write(hb_settings *settings, hb_u16 index, float value)
{
    settings->value[index] = value;
    settings->known[index] = true;
}

bool hb_settings_complete(const hb_settings *settings)
{
    for (hb_u16 i = 0; i < HB_SETTINGS; i++) {
        if (!settings->known[i]) {
            return false;
        }
    }
    return true;
}

bool hb_settings_in_range(const hb_settings *settings, float voltage_range_v)
{
    const float *value = settings->value;

    return value[HB_SETTING_VELOCITY_GAIN_V_M] > 0.0f
        && value[HB_SETTING_VELOCITY_TIME_CONSTANT_S] >= 0.0f
        && value[HB_SETTING_FORCE_GAIN_V_N] > 0.0f
        && value[HB_SETTING_ROD_GAIN_V_PA_S] > 0.0f
        && value[HB_SETTING_ROD_TIME_CONSTANT_S] >= 0.0f
        && value[HB_SETTING_PISTON_GAIN_V_PA_S] > 0.0f
        && value[HB_SETTING_PISTON_TIME_CONSTANT_S] >= 0.0f
        && value[HB_SETTING_VELOCITY_FILTER_S] >= 0.0f
        && value[HB_SETTING_PRESSURE_FILTER_S] >= 0.0f
        && value[HB_SETTING_VOLTAGE_LIMIT_V] > 0.0f
        && value[HB_SETTING_VOLTAGE_LIMIT_V] <= voltage_range_v
        && value[HB_SETTING_PRESSURE_SLEW_PA_S] >= MIN_PRESSURE_SLEW_PA_S
        && value[HB_SETTING_RETURN_SPEED_M_S] > 0.0f
        && value[HB_SETTING_ACCELERATION_M_S2] >= MIN_ACCELERATION_M_S2
        && value[HB_SETTING_TRAVEL_MIN_M] < value[HB_SETTING_TRAVEL_MAX_M]
        && value[HB_SETTING_PRESSURE_MAX_PA] > 0.0f
        && value[HB_SETTING_SPEED_MAX_M_S] > 0.0f
        && value[HB_SETTING_STOPPING_TIME_S] >= 0.0f
        && value[HB_SETTING_SPEED_ERROR_MAX_M_S] > 0.0f
        && value[HB_SETTING_SPEED_ERROR_TIME_S] >= 0.0f
        && value[HB_SETTING_SPEED_ERROR_TIME_S] <= HB_MAX_TIME_S
        && value[HB_SETTING_AREA_PISTON_M2] > 0.0f
        && value[HB_SETTING_AREA_ROD_M2] > 0.0f
        && value[HB_SETTING_HEARTBEAT_S] > 0.0f
        && value[HB_SETTING_HEARTBEAT_S] <= HB_MAX_TIME_S
        && value[HB_SETTING_LOG_DIVIDER] >= 1.0f
        && value[HB_SETTING_LOG_DIVIDER] <= 65535.0f;
}

hb_u16 hb_settings_crc(const hb_settings *settings)
{
    hb_u16 crc = HB_CRC_START;

    for (hb_u16 i = 0; i < HB_SETTINGS; i++) {
        crc = hb_crc_f32(crc, settings->value[i]);
    }
    return crc;
}
