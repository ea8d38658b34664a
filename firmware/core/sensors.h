/* Converter words to SI values: gain and offset, then the filters of appendix D. */
#ifndef HB_SENSORS_H
#define HB_SENSORS_H

#include "filters.h"
#include "hal.h"
#include "settings.h"

typedef struct {
    hb_adc_scale adc;
    float gain[HB_SENSORS]; /* SI per 1/16 count */
    float offset[HB_SENSORS];
    float acceleration_gain; /* m/s^2 per 1/16 count; 0: there is no accelerometer */
    float acceleration_offset;
    bool force_controls; /* a loop uses the load cell */
    float area_piston_m2; /* of the test cylinder */
    float area_rod_m2;
    hb_velocity_config velocity;
    hb_lowpass_config pressure;
} hb_sensors_config;

typedef struct {
    float value[HB_SENSORS];    /* SI; the five pressures are filtered (D.29) */
    float f_applied_filtered_n; /* of the load cell, filtered as the pressures */
    float f_test_n;             /* pressure force of the test cylinder, P_Tp A_p - P_Tr A_r */
    hb_velocity_state velocity; /* velocity.v is the filtered velocity [m/s] (D.11) */
    bool saturated;             /* a word of this tick was at 0 or full scale */
    bool impossible;            /* a sensor of the loops or limits is broken, or its wire */
    bool primed;                /* false: the filters start from the next words */
} hb_sensors_state;

hb_sensors_config hb_sensors_design(const hb_settings *settings, const hb_adc_scale *adc);
void hb_sensors_init(hb_sensors_state *state);
void hb_sensors_step(const hb_sensors_config *config, hb_sensors_state *state,
                     const hb_u16 adc[HB_INPUTS]);

#endif
