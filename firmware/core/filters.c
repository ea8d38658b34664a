#include "filters.h"

hb_velocity_config hb_velocity_design(float tau_s, float period_s)
{
    const hb_velocity_config config = {1.0f / (tau_s + period_s), tau_s / (tau_s + period_s),
                                       period_s};
    return config;
}

void hb_velocity_step(const hb_velocity_config *config, hb_velocity_state *state, float x,
                      float a_m_s2)
{
    const float integral = state->v + a_m_s2 * config->period_s;

    state->v = (x - state->x) * config->gain + integral * config->decay;
    state->x = x;
}

hb_lowpass_config hb_lowpass_design(float tau_s, float period_s)
{
    const hb_lowpass_config config = {period_s / (tau_s + period_s)};
    return config;
}

void hb_lowpass_step(const hb_lowpass_config *config, float *y, float x)
{
    *y += config->gain * (x - *y);
}

hb_u16 hb_mean_word(hb_u32 sum, hb_u16 n)
{
    return (hb_u16)((sum + n / 2u) / n);
}
