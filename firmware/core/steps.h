/* The uploaded schedule: velocity segments, and steps that run sequences of them. The fields of
 * both are described in dictionary.py. */
#ifndef HB_STEPS_H
#define HB_STEPS_H

#include "config.h"
#include "dictionary.h"
#include "payloads.h"
#include "settings.h"

typedef struct {
    hb_segment segment[HB_MAX_SEGMENTS];
    hb_u16 segments;
    hb_step step[HB_MAX_STEPS];
    hb_u16 count;
} hb_steps;

void hb_steps_init(hb_steps *steps);

/* Every value is within the range that a run can use; the bench's limits are not considered. */
bool hb_segment_valid(const hb_segment *segment);
bool hb_step_valid(const hb_step *step);

/* Append at index, which must equal the present count. Segment 0 starts a new schedule, step 0 a
 * new list of steps. An identical repetition of the last one is accepted without effect. False,
 * and nothing changed, in all other cases. */
bool hb_segments_write(hb_steps *steps, hb_u16 index, const hb_segment *segment);
bool hb_steps_write(hb_steps *steps, hb_u16 index, const hb_step *step);

/* The segments of every step exist; positions, pressures and velocities are within the limits in
 * the settings. */
bool hb_steps_valid(const hb_steps *steps, const hb_settings *settings);

/* CRC-16 over the fields of all segments, then of all steps, as they are sent but without index. */
hb_u16 hb_steps_crc(const hb_steps *steps);

#endif
