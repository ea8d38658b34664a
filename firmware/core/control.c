#include "control.h"

#include "numeric.h"

#define HB_SIGN_M_S 1e-3f
#define HB_TRIM_SHARE 0.25f /* of the highest pressure: more is not friction */

hb_control_config hb_control_design(const hb_settings *settings)
{
    const float *value = settings->value;
    const bool on = value[HB_SETTING_FEEDFORWARD_ON] != 0.0f;
    hb_control_config config;

    config.loop[HB_VALVE_T] =
        hb_pi_design(value[HB_SETTING_VELOCITY_GAIN_V_M],
                     value[HB_SETTING_VELOCITY_TIME_CONSTANT_S], HB_PERIOD_S);
    config.loop[HB_VALVE_L1] = hb_pi_design(value[HB_SETTING_ROD_GAIN_V_PA_S],
                                            value[HB_SETTING_ROD_TIME_CONSTANT_S], HB_PERIOD_S);
    config.loop[HB_VALVE_L2] =
        hb_pi_design(value[HB_SETTING_PISTON_GAIN_V_PA_S],
                     value[HB_SETTING_PISTON_TIME_CONSTANT_S], HB_PERIOD_S);
    config.feedforward[HB_VALVE_T] = 0.0f;
    config.feedforward[HB_VALVE_L1] = on ? value[HB_SETTING_FEEDFORWARD_ROD_V_S_M] : 0.0f;
    config.feedforward[HB_VALVE_L2] = on ? -value[HB_SETTING_FEEDFORWARD_PISTON_V_S_M] : 0.0f;
    config.force_gain_v_n = value[HB_SETTING_FORCE_GAIN_V_N];
    config.limit_v = value[HB_SETTING_VOLTAGE_LIMIT_V];
    config.load_control =
        (hb_u16)hb_clamp(value[HB_SETTING_LOAD_CONTROL], 0.0f, (float)HB_LOAD_CONTROLS - 1.0f);
    config.load_integral = HB_PERIOD_S / value[HB_SETTING_LOAD_TIME_CONSTANT_S];
    config.load_trim_max_pa = HB_TRIM_SHARE * value[HB_SETTING_PRESSURE_MAX_PA];
    config.load_piston_m2 = value[HB_SETTING_LOAD_AREA_PISTON_M2];
    config.load_rod_m2 = value[HB_SETTING_LOAD_AREA_ROD_M2];
    config.coulomb_n = value[HB_SETTING_LOAD_COULOMB_N];
    config.stiction_n = value[HB_SETTING_LOAD_STICTION_N];
    config.stribeck_m_s = value[HB_SETTING_LOAD_STRIBECK_M_S];
    config.viscous_n_s_m = value[HB_SETTING_LOAD_VISCOUS_N_S_M];
    return config;
}

void hb_control_hold(hb_control_state *state, float u_v)
{
    for (hb_u16 i = 0; i < HB_VALVES; i++) {
        state->loop[i].u = 0.0f;
        state->loop[i].e = 0.0f;
        state->u[i] = u_v;
    }
    state->load_trim_pa = 0.0f;
    state->saturated = false;
}

/* The test valve during a push; the velocity loop will go on from there. */
static void push(const hb_control_config *config, hb_control_state *state,
                 const hb_references *references, const hb_sensors_state *sensors)
{
    const float u = config->force_gain_v_n * (references->f_test_n - sensors->f_test_n);

    state->u[HB_VALVE_T] = hb_clamp(u, -config->limit_v, config->limit_v);
    state->loop[HB_VALVE_T].u = state->u[HB_VALVE_T];
    state->loop[HB_VALVE_T].e = 0.0f;
    if (state->u[HB_VALVE_T] != u) {
        state->saturated = true;
    }
}

/* Friction of the load cylinder. Up to HB_SIGN_M_S the sign is replaced by a straight line, so that
 * the reference does not jump at a reversal. */
static float load_friction(const hb_control_config *config, float v_m_s)
{
    const float falling = config->stiction_n - config->coulomb_n;
    const float dry =
        config->coulomb_n + falling * hb_exp_minus(hb_abs(v_m_s) / config->stribeck_m_s);

    return dry * hb_clamp(v_m_s / HB_SIGN_M_S, -1.0f, 1.0f) + config->viscous_n_s_m * v_m_s;
}

/* The error of the load piston's loop [Pa]. */
static float load_error(const hb_control_config *config, hb_control_state *state,
                        const hb_references *references, const hb_sensors_state *sensors)
{
    const float f_ref_n = config->load_piston_m2 * references->p_lp_pa
                        - config->load_rod_m2 * references->p_lr_pa;
    const float error = references->p_lp_pa - sensors->value[HB_SENSOR_P_LP];

    switch (config->load_control) {
    case HB_LOAD_CONTROL_LOAD_CELL:
        state->load_trim_pa =
            hb_clamp(state->load_trim_pa
                         + config->load_integral * (f_ref_n - sensors->f_applied_filtered_n)
                               / config->load_piston_m2,
                     -config->load_trim_max_pa, config->load_trim_max_pa);
        return error + state->load_trim_pa;
    case HB_LOAD_CONTROL_FRICTION_LAW:
        return error - load_friction(config, references->v_m_s) / config->load_piston_m2;
    default:
        return error;
    }
}

void hb_control_step(const hb_control_config *config, hb_control_state *state,
                     const hb_references *references, const hb_sensors_state *sensors)
{
    const float v = sensors->velocity.v;
    const float limit = config->limit_v;
    float error[HB_VALVES];

    error[HB_VALVE_T] = references->v_m_s - v;
    error[HB_VALVE_L1] = references->p_lr_pa - sensors->value[HB_SENSOR_P_LR];
    error[HB_VALVE_L2] = load_error(config, state, references, sensors);

    state->saturated = false;
    for (hb_u16 i = 0; i < HB_VALVES; i++) {
        if (i == HB_VALVE_T && references->pushing) {
            push(config, state, references, sensors);
            continue;
        }
        /* The PI is limited to the part of the valve's range that the feedforward leaves, so that
         * the sum stays within the limit without wind-up. Zero is always allowed: a feedforward
         * beyond the limit must not wind up the PI. */
        const float forward = config->feedforward[i] * v;
        const float low = hb_min(-limit - forward, 0.0f);
        const float high = hb_max(limit - forward, 0.0f);
        const float u = hb_pi_step(&config->loop[i], &state->loop[i], error[i], low, high);
        state->u[i] = hb_clamp(u + forward, -limit, limit);
        if (u <= low || u >= high || state->u[i] != u + forward) {
            state->saturated = true;
        }
    }
}

hb_i16 hb_dac_code(const hb_dac_scale *dac, float volts)
{
    return hb_round_i16(volts * dac->codes_per_v, dac->code_min, dac->code_max);
}
