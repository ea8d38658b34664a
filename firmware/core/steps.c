#include "steps.h"

#include "crc.h"
#include "numeric.h"

void hb_steps_init(hb_steps *steps)
{
    steps->segments = 0;
    steps->count = 0;
    steps->step[0].run = 0; /* in the status without a schedule */
}

static bool is_duration(float seconds)
{
    return seconds >= 0.0f && seconds <= HB_MAX_TIME_S;
}

bool hb_segment_valid(const hb_segment *segment)
{
    return segment->valves < HB_VALVES_STATES
        && hb_finite(segment->v_m_s)
        && hb_finite(segment->a_m_s2) && segment->a_m_s2 > 0.0f
        && is_duration(segment->duration_s) && segment->duration_s > 0.0f
        && hb_abs(segment->force_rate_n_s) <= HB_MAX_FORCE_RATE_N_S
        && hb_finite(segment->displacement_m) && segment->displacement_m >= 0.0f;
}

bool hb_step_valid(const hb_step *step)
{
    return step->trials >= 1u
        && (hb_u32)step->run + step->trials <= 65536u
        && step->segments >= 1u
        && step->cycles >= 1u
        && step->until < HB_CONDITIONS
        && hb_finite(step->within) && step->within >= 0.0f
        && hb_finite(step->p_lr_ref_pa) && step->p_lr_ref_pa >= 0.0f
        && hb_finite(step->p_lp_ref_pa) && step->p_lp_ref_pa >= 0.0f
        && hb_finite(step->x_start_m)
        && hb_finite(step->x_min_m)
        && hb_finite(step->x_max_m)
        && is_duration(step->hold_s);
}

/* Index of the last of count items. */
static bool is_last(hb_u16 index, hb_u16 count)
{
    return count > 0u && index == (hb_u16)(count - 1u);
}

bool hb_segments_write(hb_steps *steps, hb_u16 index, const hb_segment *segment)
{
    if (index == 0u) {
        steps->segments = 0;
        steps->count = 0;
    }
    if (index < HB_MAX_SEGMENTS && index == steps->segments) {
        steps->segment[index] = *segment;
        steps->segments++;
        return true;
    }
    return is_last(index, steps->segments) && hb_segment_equal(&steps->segment[index], segment);
}

bool hb_steps_write(hb_steps *steps, hb_u16 index, const hb_step *step)
{
    if (index == 0u) {
        steps->count = 0;
    }
    if (index < HB_MAX_STEPS && index == steps->count) {
        steps->step[index] = *step;
        steps->count++;
        return true;
    }
    return is_last(index, steps->count) && hb_step_equal(&steps->step[index], step);
}

static bool between(float x, float low, float high)
{
    return x >= low && x <= high;
}

bool hb_steps_valid(const hb_steps *steps, const hb_settings *settings)
{
    const float x_min_m = settings->value[HB_SETTING_TRAVEL_MIN_M];
    const float x_max_m = settings->value[HB_SETTING_TRAVEL_MAX_M];
    const float p_max_pa = settings->value[HB_SETTING_PRESSURE_MAX_PA];
    const float v_max_m_s = settings->value[HB_SETTING_SPEED_MAX_M_S];

    for (hb_u16 i = 0; i < steps->count; i++) {
        const hb_step *step = &steps->step[i];
        if ((hb_u32)step->segment + step->segments > steps->segments
            || !between(step->x_start_m, x_min_m, x_max_m)
            || !between(step->x_min_m, x_min_m, x_max_m)
            || !between(step->x_max_m, x_min_m, x_max_m)
            || !between(step->p_lr_ref_pa, 0.0f, p_max_pa)
            || !between(step->p_lp_ref_pa, 0.0f, p_max_pa)) {
            return false;
        }
    }
    for (hb_u16 i = 0; i < steps->segments; i++) {
        if (!between(steps->segment[i].v_m_s, -v_max_m_s, v_max_m_s)) {
            return false;
        }
    }
    return true;
}

hb_u16 hb_steps_crc(const hb_steps *steps)
{
    hb_u16 crc = HB_CRC_START;

    for (hb_u16 i = 0; i < steps->segments; i++) {
        crc = hb_segment_crc(crc, &steps->segment[i]);
    }
    for (hb_u16 i = 0; i < steps->count; i++) {
        crc = hb_step_crc(crc, &steps->step[i]);
    }
    return crc;
}
