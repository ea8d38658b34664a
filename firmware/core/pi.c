#include "pi.h"

#include "numeric.h"

hb_pi_config hb_pi_design(float gain, float time_constant_s, float period_s)
{
    const hb_pi_config config = {gain * time_constant_s, gain * period_s};
    return config;
}

float hb_pi_step(const hb_pi_config *config, hb_pi_state *state, float e, float low, float high)
{
    const float increment = config->proportional * (e - state->e) + config->integral * e;

    state->u = hb_clamp(state->u + increment, low, high);
    state->e = e;
    return state->u;
}
