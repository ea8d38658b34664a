#include "steps.h"

#include "crc.h"
#include "numeric.h"

void hb_steps_init(hb_steps *steps)
{
    steps->segments = 0;
    steps->count = 0;
    steps->step[0].run = 0; /* what the status shows before there is a schedule */
}

static bool is_duration(float seconds)
{
    return seconds >= 0.0f && seconds <= HB_MAX_TIME_S;
}

bool hb_segment_in_range(const hb_segment *segment)
{
    return segment->valves < HB_VALVES_STATES
        && hb_finite(segment->v_m_s)
        && hb_finite(segment->a_m_s2) && segment->a_m_s2 > 0.0f
        && is_duration(segment->duration_s) && segment->duration_s > 0.0f;
}

bool hb_step_in_range(const hb_step *step)
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

static hb_u16 segment_crc(hb_u16 crc, const hb_segment *segment)
{
    crc = hb_crc_u16(crc, segment->valves);
    crc = hb_crc_f32(crc, segment->v_m_s);
    crc = hb_crc_f32(crc, segment->a_m_s2);
    return hb_crc_f32(crc, segment->duration_s);
}

static hb_u16 step_crc(hb_u16 crc, const hb_step *step)
{
    crc = hb_crc_u16(crc, step->run);
    crc = hb_crc_u16(crc, step->trials);
    crc = hb_crc_u16(crc, step->segment);
    crc = hb_crc_u16(crc, step->segments);
    crc = hb_crc_u16(crc, step->cycles);
    crc = hb_crc_u16(crc, step->until);
    crc = hb_crc_f32(crc, step->within);
    crc = hb_crc_f32(crc, step->p_lr_ref_pa);
    crc = hb_crc_f32(crc, step->p_lp_ref_pa);
    crc = hb_crc_f32(crc, step->x_start_m);
    crc = hb_crc_f32(crc, step->x_min_m);
    crc = hb_crc_f32(crc, step->x_max_m);
    return hb_crc_f32(crc, step->hold_s);
}

/* Not by their CRCs: two that differ must not be taken for one another. */
static bool same_segment(const hb_segment *a, const hb_segment *b)
{
    return a->valves == b->valves
        && a->v_m_s == b->v_m_s
        && a->a_m_s2 == b->a_m_s2
        && a->duration_s == b->duration_s;
}

static bool same_step(const hb_step *a, const hb_step *b)
{
    return a->run == b->run
        && a->trials == b->trials
        && a->segment == b->segment
        && a->segments == b->segments
        && a->cycles == b->cycles
        && a->until == b->until
        && a->within == b->within
        && a->p_lr_ref_pa == b->p_lr_ref_pa
        && a->p_lp_ref_pa == b->p_lp_ref_pa
        && a->x_start_m == b->x_start_m
        && a->x_min_m == b->x_min_m
        && a->x_max_m == b->x_max_m
        && a->hold_s == b->hold_s;
}

/* The last of count items, sent once more. */
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
    return is_last(index, steps->segments) && same_segment(&steps->segment[index], segment);
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
    return is_last(index, steps->count) && same_step(&steps->step[index], step);
}

static bool between(float x, float low, float high)
{
    return x >= low && x <= high;
}

bool hb_steps_sound(const hb_steps *steps, float x_min_m, float x_max_m)
{
    for (hb_u16 i = 0; i < steps->count; i++) {
        const hb_step *step = &steps->step[i];
        if ((hb_u32)step->segment + step->segments > steps->segments
            || !between(step->x_start_m, x_min_m, x_max_m)
            || !between(step->x_min_m, x_min_m, x_max_m)
            || !between(step->x_max_m, x_min_m, x_max_m)) {
            return false;
        }
    }
    return true;
}

hb_u16 hb_steps_crc(const hb_steps *steps)
{
    hb_u16 crc = HB_CRC_START;

    for (hb_u16 i = 0; i < steps->segments; i++) {
        crc = segment_crc(crc, &steps->segment[i]);
    }
    for (hb_u16 i = 0; i < steps->count; i++) {
        crc = step_crc(crc, &steps->step[i]);
    }
    return crc;
}
