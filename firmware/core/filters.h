/* Filters of appendix D. */
#ifndef HB_FILTERS_H
#define HB_FILTERS_H

#include "types.h"

/* Velocity from position, equation D.11 (dot restored), with the integral of the acceleration,
 * equation D.23, above the filter's bandwidth where there is an accelerometer:
 *
 *   v_k = (x_k - x_{k-1} + (v_{k-1} + a_k T) tau) / (tau + T),   a_k = 0 without one.
 *
 * Then the filter has no lag, and the accelerometer's offset adds a tau only. */
typedef struct {
    float gain;     /* 1 / (tau + T) [1/s] */
    float decay;    /* tau / (tau + T) */
    float period_s; /* T */
} hb_velocity_config;

typedef struct {
    float x; /* x_{k-1} [m] */
    float v; /* v_{k-1} [m/s] */
} hb_velocity_state;

hb_velocity_config hb_velocity_design(float tau_s, float period_s);
void hb_velocity_step(const hb_velocity_config *config, hb_velocity_state *state, float x,
                      float a_m_s2);

/* First-order low pass, equation D.29 with K = 1:
 * y_k = (x_k T + y_{k-1} tau) / (tau + T), computed as y_{k-1} + gain (x_k - y_{k-1}). */
typedef struct {
    float gain; /* T / (tau + T) */
} hb_lowpass_config;

hb_lowpass_config hb_lowpass_design(float tau_s, float period_s);
void hb_lowpass_step(const hb_lowpass_config *config, float *y, float x);

/* Mean of n words from their sum, rounded to the nearest integer: the FIR filter D.1 in exact
 * integers, sampled every n ticks. */
hb_u16 hb_mean_word(hb_u32 sum, hb_u16 n);

#endif
