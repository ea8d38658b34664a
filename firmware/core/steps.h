/* The schedule as uploaded: a list of steps. */
#ifndef HB_STEPS_H
#define HB_STEPS_H

#include "config.h"

/* One reference, run several times: its trials have the run numbers run, run + 1, ... */
typedef struct {
    hb_u16 run;
    hb_u16 kind;
    hb_u16 trials;
    float v_ref_m_s; /* signed; positive extends */
    float a_ref_m_s2;
    float p_lr_ref_pa;
    float p_lp_ref_pa;
    float x_start_m;
    float x_end_m;
    float hold_s;     /* at rest at x_start, load on */
    float duration_s; /* at most, from the start of motion */
} hb_step;

typedef struct {
    hb_step step[HB_MAX_STEPS];
    hb_u16 count;
} hb_steps;

/* Values that a run can be made with, wherever the bench's limits lie. */
bool hb_step_in_range(const hb_step *step);

/* Appends a step where index is the present count; index 0 starts a new list. The last step sent
 * once more is taken without effect. False, and nothing changed, for any other index. */
bool hb_steps_write(hb_steps *steps, hb_u16 index, const hb_step *step);

/* Starts and ends of all steps lie between two positions. */
bool hb_steps_within(const hb_steps *steps, float x_min_m, float x_max_m);

/* CRC-16 of all steps' fields as they are sent, without their index. */
hb_u16 hb_steps_crc(const hb_steps *steps);

#endif
