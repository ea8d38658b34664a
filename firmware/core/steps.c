#include "steps.h"

#include "crc.h"
#include "numeric.h"

bool hb_step_in_range(const hb_step *step)
{
    return step->kind < HB_KINDS
        && step->trials >= 1u
        && (hb_u32)step->run + step->trials <= 65536u
        && hb_finite(step->v_ref_m_s) && step->v_ref_m_s != 0.0f
        && hb_finite(step->a_ref_m_s2) && step->a_ref_m_s2 > 0.0f
        && hb_finite(step->p_lr_ref_pa) && step->p_lr_ref_pa >= 0.0f
        && hb_finite(step->p_lp_ref_pa) && step->p_lp_ref_pa >= 0.0f
        && hb_finite(step->x_start_m)
        && hb_finite(step->x_end_m)
        && step->hold_s >= 0.0f && step->hold_s <= HB_MAX_TIME_S
        && step->duration_s > 0.0f && step->duration_s <= HB_MAX_TIME_S;
}

static bool same(const hb_step *a, const hb_step *b)
{
    return a->run == b->run
        && a->kind == b->kind
        && a->trials == b->trials
        && a->v_ref_m_s == b->v_ref_m_s
        && a->a_ref_m_s2 == b->a_ref_m_s2
        && a->p_lr_ref_pa == b->p_lr_ref_pa
        && a->p_lp_ref_pa == b->p_lp_ref_pa
        && a->x_start_m == b->x_start_m
        && a->x_end_m == b->x_end_m
        && a->hold_s == b->hold_s
        && a->duration_s == b->duration_s;
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
    return steps->count > 0u && index == (hb_u16)(steps->count - 1u)
        && same(&steps->step[index], step);
}

bool hb_steps_within(const hb_steps *steps, float x_min_m, float x_max_m)
{
    for (hb_u16 i = 0; i < steps->count; i++) {
        const hb_step *step = &steps->step[i];
        if (hb_clamp(step->x_start_m, x_min_m, x_max_m) != step->x_start_m
            || hb_clamp(step->x_end_m, x_min_m, x_max_m) != step->x_end_m) {
            return false;
        }
    }
    return true;
}

hb_u16 hb_steps_crc(const hb_steps *steps)
{
    hb_u16 crc = HB_CRC_START;

    for (hb_u16 i = 0; i < steps->count; i++) {
        const hb_step *step = &steps->step[i];
        crc = hb_crc_u16(crc, step->run);
        crc = hb_crc_u16(crc, step->kind);
        crc = hb_crc_u16(crc, step->trials);
        crc = hb_crc_f32(crc, step->v_ref_m_s);
        crc = hb_crc_f32(crc, step->a_ref_m_s2);
        crc = hb_crc_f32(crc, step->p_lr_ref_pa);
        crc = hb_crc_f32(crc, step->p_lp_ref_pa);
        crc = hb_crc_f32(crc, step->x_start_m);
        crc = hb_crc_f32(crc, step->x_end_m);
        crc = hb_crc_f32(crc, step->hold_s);
        crc = hb_crc_f32(crc, step->duration_s);
    }
    return crc;
}
