/* From the converter's words to SI: gain and offset, then the filters of appendix D. */
#ifndef HB_SENSORS_H
#define HB_SENSORS_H

#include "config.h"
#include "filters.h"
#include "settings.h"

typedef struct {
    float gain[HB_SENSORS]; /* SI per 1/16 count */
    float offset[HB_SENSORS];
    hb_velocity_config velocity;
    hb_lowpass_config pressure;
} hb_sensors_config;

typedef struct {
    float value[HB_SENSORS];    /* SI; the five pressures are filtered (D.29) */
    hb_velocity_state velocity; /* velocity.v is the filtered velocity [m/s] (D.11) */
    bool saturated;             /* a word of this tick was at 0 or full scale */
    bool impossible;            /* one that the loops or limits need was, and can't be */
    bool primed;                /* false: the next words are where the filters start */
} hb_sensors_state;

hb_sensors_config hb_sensors_design(const hb_settings *settings);
void hb_sensors_init(hb_sensors_state *state);
void hb_sensors_step(const hb_sensors_config *config, hb_sensors_state *state,
                     const hb_u16 adc[HB_SENSORS]);

#endif
