#include "schedule.h"

#include "numeric.h"

#define HB_RETURN_GAIN_1_S 5.0f
/* Margin of the time in which the load's references are reached. */
#define HB_LOAD_MARGIN_S 0.1f
/* The return ends after this time within this distance of the start: mean speed <= 20 mm/s. */
#define HB_NEAR_M 1e-3f
#define HB_NEAR_S 0.1f

hb_schedule_config hb_schedule_design(const hb_settings *settings)
{
    const float *value = settings->value;
    const float speed = value[HB_SETTING_RETURN_SPEED_M_S];
    const float acceleration = value[HB_SETTING_ACCELERATION_M_S2];
    hb_schedule_config config;

    /* v_ref = K (x_start - x) with a slope limited to a overshoots for K > 2 a / v, where the
     * braking distance from v, v^2 / 2a, exceeds the distance over which v_ref falls, v / K. */
    config.return_gain_1_s = hb_min(HB_RETURN_GAIN_1_S, 1.5f * acceleration / speed);
    config.return_speed_m_s = speed;
    config.velocity_step_m_s = acceleration * HB_PERIOD_S;
    /* Three times the whole travel at return speed, and time for the final approach. */
    config.return_ticks = hb_ticks(
        hb_min(3.0f * (value[HB_SETTING_TRAVEL_MAX_M] - value[HB_SETTING_TRAVEL_MIN_M]) / speed
                   + 10.0f + 8.0f / config.return_gain_1_s,
               HB_MAX_TIME_S));
    /* Twice the ramps of the pressures over their whole range and of the velocity to 0. */
    config.load_ticks = hb_ticks(
        hb_min(2.0f * (value[HB_SETTING_PRESSURE_MAX_PA] / value[HB_SETTING_PRESSURE_SLEW_PA_S]
                       + speed / acceleration)
                   + HB_LOAD_MARGIN_S,
               HB_MAX_TIME_S));
    config.pressure_step_pa = value[HB_SETTING_PRESSURE_SLEW_PA_S] * HB_PERIOD_S;
    return config;
}

static void enter(hb_schedule_state *state, hb_u16 phase)
{
    state->phase = phase;
    state->ticks = 0;
    state->ready_ticks = 0;
}

void hb_schedule_init(hb_schedule_state *state)
{
    state->step = 0;
    state->trial = 0;
    state->cycle = 0;
    state->segment = 0;
    state->runs_done = 0;
    hb_settle_init(&state->settle);
    state->settled = false;
    hb_vent_init(&state->vent);
    state->begin_x_m = 0.0f;
    state->begin_f_test_n = 0.0f;
    state->references.v_m_s = 0.0f;
    state->references.p_lr_pa = 0.0f;
    state->references.p_lp_pa = 0.0f;
    state->references.pushing = false;
    state->references.f_test_n = 0.0f;
    enter(state, HB_PHASE_NONE);
}

static void load_as_measured(hb_schedule_state *state, const hb_sensors_state *sensors)
{
    state->references.p_lr_pa = sensors->value[HB_SENSOR_P_LR];
    state->references.p_lp_pa = sensors->value[HB_SENSOR_P_LP];
}

void hb_schedule_start(hb_schedule_state *state, const hb_sensors_state *sensors)
{
    hb_schedule_init(state);
    load_as_measured(state, sensors);
    enter(state, HB_PHASE_RETURN);
}

static const hb_segment *present_segment(const hb_steps *steps, const hb_schedule_state *state)
{
    return &steps->segment[steps->step[state->step].segment + state->segment];
}

static bool segment_is_over(const hb_schedule_state *state, const hb_step *step,
                            const hb_segment *segment, float x_m)
{
    const float v = state->references.v_m_s;
    const bool left = (segment->v_m_s > 0.0f && v > 0.0f && x_m >= step->x_max_m)
                   || (segment->v_m_s < 0.0f && v < 0.0f && x_m <= step->x_min_m);
    const bool moved = state->phase == HB_PHASE_PUSH
                    && hb_abs(x_m - state->begin_x_m) >= segment->displacement_m;
    return left || moved || state->ticks >= hb_ticks(segment->duration_s);
}

static hb_u16 phase_of(const hb_segment *segment)
{
    switch (segment->valves) {
    case HB_VALVES_CLOSED:
        return HB_PHASE_CLOSED;
    case HB_VALVES_PUSHING:
        return HB_PHASE_PUSH;
    case HB_VALVES_VENTING:
        return HB_PHASE_VENT;
    default:
        return HB_PHASE_ACCELERATE;
    }
}

static void enter_segment(const hb_steps *steps, hb_schedule_state *state,
                          const hb_sensors_state *sensors)
{
    enter(state, phase_of(present_segment(steps, state)));
    hb_vent_init(&state->vent);
    state->begin_x_m = sensors->value[HB_SENSOR_X];
    state->begin_f_test_n = sensors->f_test_n;
}

static void begin_run(const hb_steps *steps, hb_schedule_state *state,
                      const hb_sensors_state *sensors)
{
    state->cycle = 0;
    state->segment = 0;
    state->settled = false;
    hb_settle_init(&state->settle);
    enter_segment(steps, state, sensors);
}

static void next_segment(const hb_steps *steps, hb_schedule_state *state,
                         const hb_sensors_state *sensors)
{
    const hb_step *step = &steps->step[state->step];

    if (state->phase == HB_PHASE_PUSH) { /* the velocity loop goes on from the speed that it finds */
        state->references.v_m_s = sensors->velocity.v;
    }
    if (state->segment + 1u < step->segments) {
        state->segment++;
        enter_segment(steps, state, sensors);
        return;
    }
    state->settled = hb_settle_cycle(&state->settle, step->within)
                  && step->until != HB_CONDITION_CYCLES;
    if (!state->settled && state->cycle + 1u < step->cycles) {
        state->cycle++;
        state->segment = 0;
        enter_segment(steps, state, sensors);
        return;
    }
    state->runs_done++;
    enter(state, HB_PHASE_BRAKE);
}

static void next_trial(const hb_steps *steps, hb_schedule_state *state)
{
    if (state->trial + 1u < steps->step[state->step].trials) {
        state->trial++;
    } else if (state->step + 1u < steps->count) {
        state->step++;
        state->trial = 0;
    } else {
        enter(state, HB_PHASE_NONE);
        return;
    }
    state->segment = 0;
    state->cycle = 0;
    enter(state, HB_PHASE_RETURN);
}

/* Ends the segment, or its acceleration. */
static void continue_segment(const hb_steps *steps, hb_schedule_state *state,
                             const hb_sensors_state *sensors)
{
    const hb_step *step = &steps->step[state->step];
    const hb_segment *segment = present_segment(steps, state);

    if (segment_is_over(state, step, segment, sensors->value[HB_SENSOR_X])) {
        next_segment(steps, state, sensors);
    } else if (state->phase == HB_PHASE_ACCELERATE && state->references.v_m_s == segment->v_m_s) {
        state->phase = HB_PHASE_STEADY; /* its ticks continue from the segment's start */
    }
}

/* Enters the next phase if the present phase is over. */
static void change_phase(const hb_steps *steps, hb_schedule_state *state,
                         const hb_sensors_state *sensors)
{
    const hb_step *step = &steps->step[state->step];

    switch (state->phase) {
    case HB_PHASE_RETURN:
        if (present_segment(steps, state)->valves == HB_VALVES_VENTING) {
            begin_run(steps, state, sensors);
        } else if (state->ready_ticks >= hb_ticks(HB_NEAR_S)) {
            enter(state, HB_PHASE_HOLD);
        }
        break;
    case HB_PHASE_HOLD:
        if (state->ready_ticks > 0u && state->ready_ticks >= hb_ticks(step->hold_s)) {
            begin_run(steps, state, sensors);
        }
        break;
    case HB_PHASE_BRAKE:
        if (state->references.v_m_s == 0.0f) {
            next_trial(steps, state);
        }
        break;
    default:
        if (hb_schedule_moving(state)) {
            continue_segment(steps, state, sensors);
        }
        break;
    }
}

/* The quantity of the step's condition: friction (equation 5.1; inertia cancels over a cycle) or
 * speed error. */
static float condition_value(const hb_step *step, const hb_schedule_state *state,
                             const hb_sensors_state *sensors)
{
    const float v_ref = state->references.v_m_s;

    if (step->until == HB_CONDITION_FRICTION) {
        const float friction = sensors->f_test_n - sensors->value[HB_SENSOR_F_APPLIED];
        return v_ref < 0.0f ? -friction : friction;
    }
    return hb_abs(v_ref - sensors->velocity.v);
}

/* Moves the velocity reference according to the phase. loaded: the load's references are
 * reached. */
static void follow_phase(const hb_schedule_config *config, const hb_steps *steps,
                         hb_schedule_state *state, float x_m, bool loaded)
{
    float *v = &state->references.v_m_s;
    const float distance = steps->step[state->step].x_start_m - x_m;
    const hb_segment *segment = present_segment(steps, state);

    state->ticks++;
    switch (state->phase) {
    case HB_PHASE_RETURN:
        *v = hb_slew(*v,
                     hb_clamp(config->return_gain_1_s * distance, -config->return_speed_m_s,
                              config->return_speed_m_s),
                     config->velocity_step_m_s);
        state->ready_ticks = hb_abs(distance) <= HB_NEAR_M ? state->ready_ticks + 1u : 0u;
        break;
    case HB_PHASE_HOLD:
        *v = hb_slew(*v, 0.0f, config->velocity_step_m_s);
        if (loaded && *v == 0.0f) {
            state->ready_ticks++;
        }
        break;
    case HB_PHASE_ACCELERATE:
    case HB_PHASE_STEADY:
        *v = hb_slew(*v, segment->v_m_s, segment->a_m_s2 * HB_PERIOD_S);
        break;
    case HB_PHASE_CLOSED:
    case HB_PHASE_PUSH:
    case HB_PHASE_VENT:
        *v = 0.0f;
        break;
    default:
        *v = hb_slew(*v, 0.0f, config->velocity_step_m_s);
        break;
    }
}

void hb_schedule_step(const hb_schedule_config *config, const hb_steps *steps,
                      hb_schedule_state *state, const hb_sensors_state *sensors)
{
    const float x_m = sensors->value[HB_SENSOR_X];
    hb_references *references = &state->references;

    change_phase(steps, state, sensors);

    const hb_step *step = &steps->step[state->step];
    if (state->phase == HB_PHASE_CLOSED || state->phase == HB_PHASE_VENT) {
        load_as_measured(state, sensors); /* control resumes from here */
    } else {
        references->p_lr_pa =
            hb_slew(references->p_lr_pa, step->p_lr_ref_pa, config->pressure_step_pa);
        references->p_lp_pa =
            hb_slew(references->p_lp_pa, step->p_lp_ref_pa, config->pressure_step_pa);
    }
    const bool loaded =
        references->p_lr_pa == step->p_lr_ref_pa && references->p_lp_pa == step->p_lp_ref_pa;
    follow_phase(config, steps, state, x_m, loaded);
    references->pushing = state->phase == HB_PHASE_PUSH;
    if (references->pushing) { /* from the time, since small increments would be lost in rounding */
        references->f_test_n = state->begin_f_test_n
                             + present_segment(steps, state)->force_rate_n_s
                                   * ((float)state->ticks * HB_PERIOD_S);
    }
    if (state->phase == HB_PHASE_VENT) {
        hb_vent_step(&state->vent, sensors->value[HB_SENSOR_P_S]);
    }
    if (state->phase == HB_PHASE_ACCELERATE || state->phase == HB_PHASE_STEADY) {
        hb_settle_add(&state->settle, condition_value(step, state, sensors));
    }
}

hb_u16 hb_schedule_overdue(const hb_schedule_config *config, const hb_schedule_state *state)
{
    if (state->phase == HB_PHASE_RETURN && state->ticks > config->return_ticks) {
        return HB_FAULT_RETURN;
    }
    if (state->phase == HB_PHASE_HOLD
        && state->ticks - state->ready_ticks > config->load_ticks) {
        return HB_FAULT_LOAD;
    }
    return HB_FAULT_NONE;
}

bool hb_schedule_moving(const hb_schedule_state *state)
{
    return state->phase == HB_PHASE_ACCELERATE || state->phase == HB_PHASE_STEADY
        || state->phase == HB_PHASE_CLOSED || state->phase == HB_PHASE_PUSH
        || state->phase == HB_PHASE_VENT;
}

hb_u16 hb_schedule_run(const hb_steps *steps, const hb_schedule_state *state)
{
    return (hb_u16)(steps->step[state->step].run + state->trial);
}
