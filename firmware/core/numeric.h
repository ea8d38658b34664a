/* Float functions that freestanding C99 has no library for. */
#ifndef HB_NUMERIC_H
#define HB_NUMERIC_H

#include "hal.h"

static inline float hb_abs(float x)
{
    return x < 0.0f ? -x : x;
}

static inline float hb_min(float a, float b)
{
    return a < b ? a : b;
}

static inline float hb_max(float a, float b)
{
    return a > b ? a : b;
}

static inline float hb_clamp(float x, float low, float high)
{
    return x < low ? low : (x > high ? high : x);
}

/* x moved towards target by at most step (not negative). */
static inline float hb_slew(float x, float target, float step)
{
    return hb_abs(target - x) <= step ? target : x + (target > x ? step : -step);
}

/* exp(-x) for x >= 0, with an error below 0.02 % of 1: (1 + x/64 + (x/64)^2 / 2)^-64. */
static inline float hb_exp_minus(float x)
{
    const float part = x / 64.0f;
    float power = 1.0f + part + 0.5f * part * part;

    for (hb_u16 i = 0; i < 6u; i++) {
        power *= power;
    }
    return 1.0f / power;
}

/* Neither infinite nor NaN. */
static inline bool hb_finite(float x)
{
    return x >= -3.4e38f && x <= 3.4e38f;
}

/* The nearest integer, halves away from zero, within low..high. NaN, whose conversion is undefined
 * in C, gives 0: a valve's neutral. */
static inline hb_i16 hb_round_i16(float x, hb_i16 low, hb_i16 high)
{
    if (x != x) {
        return 0;
    }
    const float clamped = hb_clamp(x, (float)low, (float)high);
    return (hb_i16)(clamped + (clamped < 0.0f ? -0.5f : 0.5f));
}

/* Number of ticks in a time, rounded to the nearest integer. */
static inline hb_u32 hb_ticks(float seconds)
{
    const float ticks = seconds * (float)HB_RATE_HZ + 0.5f;
    return (hb_u32)ticks;
}

#endif
