#include "sensors.h"

hb_sensors_config hb_sensors_design(const hb_settings *settings, const hb_adc_scale *adc)
{
    const float *value = settings->value;
    hb_sensors_config config;

    config.adc = *adc;
    for (hb_u16 i = 0; i < HB_SENSORS; i++) {
        config.gain[i] = value[HB_SETTING_GAIN_X + i];
        config.offset[i] = value[HB_SETTING_OFFSET_X + i];
    }
    config.acceleration_gain = value[HB_SETTING_ACCELERATION_GAIN_M_S2];
    config.acceleration_offset = value[HB_SETTING_ACCELERATION_OFFSET_M_S2];
    config.force_controls = value[HB_SETTING_LOAD_CONTROL] == (float)HB_LOAD_CONTROL_LOAD_CELL;
    config.area_piston_m2 = value[HB_SETTING_AREA_PISTON_M2];
    config.area_rod_m2 = value[HB_SETTING_AREA_ROD_M2];
    config.velocity = hb_velocity_design(value[HB_SETTING_VELOCITY_FILTER_S], HB_PERIOD_S);
    config.pressure = hb_lowpass_design(value[HB_SETTING_PRESSURE_FILTER_S], HB_PERIOD_S);
    return config;
}

void hb_sensors_init(hb_sensors_state *state)
{
    for (hb_u16 i = 0; i < HB_SENSORS; i++) {
        state->value[i] = 0.0f;
    }
    state->f_applied_filtered_n = 0.0f;
    state->f_test_n = 0.0f;
    state->velocity.x = 0.0f;
    state->velocity.v = 0.0f;
    state->saturated = false;
    state->impossible = false;
    state->primed = false;
}

static bool at_end(const hb_adc_scale *adc, hb_u16 word)
{
    return word <= adc->margin || word >= adc->full_scale - adc->margin;
}

/* True for a word of a broken sensor or wire: the position at either end of the converter's range,
 * a pressure at the upper end (at the lower end it may be zero), the load cell at either end if a
 * loop uses it; else a saturated force only marks the record. The margin allows for the converter's
 * offset and the mean of its noise, which an open input gives. */
static bool impossible(const hb_sensors_config *config, hb_u16 sensor, hb_u16 word)
{
    switch (sensor) {
    case HB_SENSOR_F_APPLIED:
        return config->force_controls && at_end(&config->adc, word);
    case HB_SENSOR_X:
        return at_end(&config->adc, word);
    default:
        return word >= config->adc.full_scale - config->adc.margin;
    }
}

/* The acceleration; 0 without an accelerometer. */
static float accelerated(const hb_sensors_config *config, hb_sensors_state *state, hb_u16 word)
{
    if (config->acceleration_gain == 0.0f) {
        return 0.0f;
    }
    if (at_end(&config->adc, word)) {
        state->impossible = true;
    }
    return config->acceleration_offset + config->acceleration_gain * (float)word;
}

void hb_sensors_step(const hb_sensors_config *config, hb_sensors_state *state,
                     const hb_u16 adc[HB_INPUTS])
{
    float si[HB_SENSORS];

    state->saturated = false;
    state->impossible = false;
    for (hb_u16 i = 0; i < HB_SENSORS; i++) {
        si[i] = config->offset[i] + config->gain[i] * (float)adc[i];
        if (adc[i] == 0u || adc[i] >= config->adc.full_scale) {
            state->saturated = true;
        }
        if (impossible(config, i, adc[i])) {
            state->impossible = true;
        }
    }
    const float a = accelerated(config, state, adc[HB_INPUT_AUXILIARY]);
    if (!state->primed) {
        state->f_applied_filtered_n = si[HB_SENSOR_F_APPLIED];
        state->velocity.x = si[HB_SENSOR_X];
        state->velocity.v = 0.0f;
        for (hb_u16 i = HB_SENSOR_P_TP; i <= HB_SENSOR_P_S; i++) {
            state->value[i] = si[i];
        }
        state->primed = true;
    }
    state->value[HB_SENSOR_X] = si[HB_SENSOR_X];
    state->value[HB_SENSOR_F_APPLIED] = si[HB_SENSOR_F_APPLIED];
    for (hb_u16 i = HB_SENSOR_P_TP; i <= HB_SENSOR_P_S; i++) {
        hb_lowpass_step(&config->pressure, &state->value[i], si[i]);
    }
    hb_lowpass_step(&config->pressure, &state->f_applied_filtered_n, si[HB_SENSOR_F_APPLIED]);
    hb_velocity_step(&config->velocity, &state->velocity, si[HB_SENSOR_X], a);
    state->f_test_n = config->area_piston_m2 * state->value[HB_SENSOR_P_TP]
                    - config->area_rod_m2 * state->value[HB_SENSOR_P_TR];
}
