/* Executes the uploaded steps: each trial returns to its start position, holds, runs its segments
 * and brakes. It provides the references of the three loops. A run that begins by venting neither
 * returns nor holds, since the supply is off. */
#ifndef HB_SCHEDULE_H
#define HB_SCHEDULE_H

#include "control.h"
#include "sensors.h"
#include "settings.h"
#include "settle.h"
#include "steps.h"
#include "vent.h"

typedef struct {
    float return_gain_1_s;   /* K of v_ref = K (x_start - x) */
    float return_speed_m_s;  /* upper limit during the return */
    float velocity_step_m_s; /* per tick, while returning and braking */
    float pressure_step_pa;  /* per tick */
    hb_u32 return_ticks;     /* upper limit for a return */
    hb_u32 load_ticks;       /* upper limit until the load is applied while holding */
} hb_schedule_config;

typedef struct {
    hb_u16 phase; /* HB_PHASE_NONE: no schedule */
    hb_u16 step;
    hb_u16 trial;   /* from 0 */
    hb_u16 cycle;   /* from 0 */
    hb_u16 segment; /* of the step, from 0 */
    hb_u16 runs_done;
    hb_u32 ticks;       /* since the phase or segment began */
    hb_u32 ready_ticks; /* returning: near the start; holding: at rest under load */
    hb_settle settle;
    bool settled; /* the last run ended by its condition */
    hb_vent vent;
    float begin_x_m;     /* at the segment's begin */
    float begin_f_test_n;
    hb_references references;
} hb_schedule_state;

hb_schedule_config hb_schedule_design(const hb_settings *settings);

void hb_schedule_init(hb_schedule_state *state);
/* Begins with the first step; the load's references start from the measured pressures. */
void hb_schedule_start(hb_schedule_state *state, const hb_sensors_state *sensors);

/* One tick, before the controllers. */
void hb_schedule_step(const hb_schedule_config *config, const hb_steps *steps,
                      hb_schedule_state *state, const hb_sensors_state *sensors);

/* The fault of a wait that takes longer than its limit: the return (the piston is blocked, or the
 * pump is off), or the load's references while holding. HB_FAULT_NONE without one. */
hb_u16 hb_schedule_overdue(const hb_schedule_config *config, const hb_schedule_state *state);

/* A run's segments are being executed. */
bool hb_schedule_moving(const hb_schedule_state *state);

/* Number of the present run. */
hb_u16 hb_schedule_run(const hb_steps *steps, const hb_schedule_state *state);

#endif
