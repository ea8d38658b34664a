/* The schedule as uploaded: segments of velocity, and steps that play rows of them. */
#ifndef HB_STEPS_H
#define HB_STEPS_H

#include "config.h"

/* A piece of a run: v_ref goes to a velocity at a slope and stays there. */
typedef struct {
    hb_u16 valves; /* HB_VALVES_CLOSED: all in neutral, nothing is controlled */
    float v_m_s;   /* signed; positive extends */
    float a_m_s2;
    float duration_s; /* at most */
} hb_segment;

/* One reference, run several times: its trials have the run numbers run, run + 1, ... */
typedef struct {
    hb_u16 run;
    hb_u16 trials;
    hb_u16 segment;  /* the first of its row ... */
    hb_u16 segments; /* ... and how many; the row is one cycle */
    hb_u16 cycles;   /* at most */
    hb_u16 until;    /* the condition that ends the run earlier */
    float within;    /* relative change from cycle to cycle that counts as settled */
    float p_lr_ref_pa;
    float p_lp_ref_pa;
    float x_start_m;
    float x_min_m; /* a segment also ends below x_min on its way down, */
    float x_max_m; /* above x_max on its way up */
    float hold_s; /* at rest at x_start, load on */
} hb_step;

typedef struct {
    hb_segment segment[HB_MAX_SEGMENTS];
    hb_u16 segments;
    hb_step step[HB_MAX_STEPS];
    hb_u16 count;
} hb_steps;

void hb_steps_init(hb_steps *steps);

/* Values that a run can be made with, wherever the bench's limits lie. */
bool hb_segment_in_range(const hb_segment *segment);
bool hb_step_in_range(const hb_step *step);

/* Append where index is the present count; a segment with index 0 starts a new schedule, a step
 * with index 0 a new list of steps. The last one sent once more is taken without effect. False,
 * and nothing changed, for any other index. */
bool hb_segments_write(hb_steps *steps, hb_u16 index, const hb_segment *segment);
bool hb_steps_write(hb_steps *steps, hb_u16 index, const hb_step *step);

/* Every step's segments are there, and its positions lie between the two. */
bool hb_steps_sound(const hb_steps *steps, float x_min_m, float x_max_m);

/* CRC-16 of all segments' and then all steps' fields as they are sent, without their index. */
hb_u16 hb_steps_crc(const hb_steps *steps);

#endif
