#include "settings.h"

#include "crc.h"

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

bool hb_settings_valid(const hb_settings *settings, float voltage_range_v)
{
    static const struct {
        float low;
        float high;
    } range[HB_SETTINGS] = HB_SETTING_RANGES;
    const float *value = settings->value;

    for (hb_u16 i = 0; i < HB_SETTINGS; i++) {
        if (!(value[i] >= range[i].low && value[i] <= range[i].high)) {
            return false;
        }
    }
    return value[HB_SETTING_VOLTAGE_LIMIT_V] <= voltage_range_v
        && value[HB_SETTING_TRAVEL_MIN_M] < value[HB_SETTING_TRAVEL_MAX_M];
}

hb_u16 hb_settings_crc(const hb_settings *settings)
{
    hb_u16 crc = HB_CRC_START;

    for (hb_u16 i = 0; i < HB_SETTINGS; i++) {
        crc = hb_crc_f32(crc, settings->value[i]);
    }
    return crc;
}
