#include "core.h"

#include "numeric.h"

void hb_core_init(hb_core *core, const hb_hal *hal)
{
    core->hal = *hal;
    hb_settings_init(&core->settings);
    hb_steps_init(&core->steps);
    core->state = HB_STATE_IDLE;
    core->fault = HB_FAULT_NONE;
    core->tick = 0;
    hb_safety_init(&core->safety);
    hb_sensors_init(&core->sensors);
    hb_control_hold(&core->control, 0.0f);
    hb_schedule_init(&core->schedule);
    hb_log_init(&core->log, hal->ring, hal->ring_records);
    hb_core_configure(core);
    core->started = false;
}

void hb_core_configure(hb_core *core)
{
    core->sensors_config = hb_sensors_design(&core->settings, &core->hal.adc);
    core->control_config = hb_control_design(&core->settings);
    core->sensors.primed = false;
    /* These divide by settings and convert them to integers, which is defined within their range
     * only. Outside of it "start" is refused. */
    if (hb_settings_valid(&core->settings, core->hal.dac.range_v)) {
        core->schedule_config = hb_schedule_design(&core->settings);
        core->safety_config = hb_safety_design(&core->settings);
    }
}

void hb_core_start(hb_core *core)
{
    hb_control_hold(&core->control, 0.0f);
    hb_safety_init(&core->safety);
    core->fault = HB_FAULT_NONE;
    hb_schedule_start(&core->schedule, &core->sensors);
    core->state = HB_STATE_RUNNING;
}

void hb_core_halt(hb_core *core, hb_u16 state, hb_u16 fault)
{
    if (hb_schedule_moving(&core->schedule)) {
        hb_log_end(&core->log, 0);
    }
    core->schedule.phase = HB_PHASE_NONE;
    core->schedule.references.v_m_s = 0.0f;
    core->state = state;
    core->fault = fault;
}

/* One tick of the schedule; begins and ends the run's log. */
static void advance(hb_core *core)
{
    const bool moved = hb_schedule_moving(&core->schedule);
    hb_schedule_step(&core->schedule_config, &core->steps, &core->schedule, &core->sensors);
    const bool moves = hb_schedule_moving(&core->schedule);

    if (moves && !moved) {
        hb_log_begin(&core->log, hb_schedule_run(&core->steps, &core->schedule),
                     (hb_u16)core->settings.value[HB_SETTING_LOG_DIVIDER]);
    } else if (moved && !moves) {
        hb_log_end(&core->log, (hb_u16)(core->schedule.settled ? HB_FLAG_LAST | HB_FLAG_SETTLED
                                                               : HB_FLAG_LAST));
    }
    if (core->schedule.phase == HB_PHASE_NONE) {
        hb_core_halt(core, HB_STATE_DONE, HB_FAULT_NONE);
    }
}

static void log_tick(hb_core *core, const hb_u16 adc[HB_INPUTS])
{
    hb_sample sample;

    sample.adc = adc;
    sample.u = core->control.u;
    sample.v_m_s = core->sensors.velocity.v;
    sample.v_ref_m_s = core->schedule.references.v_m_s;
    sample.flags =
        (hb_u16)((core->schedule.phase == HB_PHASE_STEADY ? HB_FLAG_AT_REFERENCE : 0)
                 | (core->sensors.saturated ? HB_FLAG_SENSOR_SATURATED : 0)
                 | (core->control.saturated ? HB_FLAG_VALVE_SATURATED : 0));
    hb_log_add(&core->log, &sample);
}

void hb_core_tick(hb_core *core, const hb_u16 adc[HB_INPUTS], hb_i16 dac[HB_VALVES])
{
    core->tick++;
    hb_sensors_step(&core->sensors_config, &core->sensors, adc);

    if (core->state == HB_STATE_RUNNING) {
        const hb_references *references = &core->schedule.references;
        /* A piston that breaks away jumps; no speed was asked of it. */
        const float v_ref_m_s =
            references->pushing ? core->sensors.velocity.v : references->v_m_s;
        const hb_u16 fault =
            hb_safety_step(&core->safety_config, &core->safety, &core->sensors, v_ref_m_s);
        const hb_u16 overdue = hb_schedule_overdue(&core->schedule_config, &core->schedule);
        if (fault != HB_FAULT_NONE || overdue != HB_FAULT_NONE) {
            hb_core_halt(core, HB_STATE_FAULT, fault != HB_FAULT_NONE ? fault : overdue);
        } else {
            advance(core);
        }
    }
    if (core->state == HB_STATE_RUNNING && core->schedule.phase == HB_PHASE_VENT
        && hb_vent_under_pressure(&core->schedule.vent)) {
        hb_core_halt(core, HB_STATE_FAULT, HB_FAULT_SUPPLY);
    }
    if (core->state != HB_STATE_RUNNING || core->schedule.phase == HB_PHASE_CLOSED) {
        hb_control_hold(&core->control, 0.0f);
    } else if (core->schedule.phase == HB_PHASE_VENT) {
        const float limit = core->control_config.limit_v;
        hb_control_hold(&core->control,
                        hb_clamp(hb_vent_command_v(&core->schedule.vent), -limit, limit));
    } else {
        hb_control_step(&core->control_config, &core->control, &core->schedule.references,
                        &core->sensors);
    }
    for (hb_u16 i = 0; i < HB_VALVES; i++) {
        dac[i] = hb_dac_code(&core->hal.dac, core->control.u[i]);
    }
    if (hb_schedule_moving(&core->schedule)) {
        log_tick(core, adc);
    }
}

void hb_core_overrun(hb_core *core)
{
    if (core->state == HB_STATE_RUNNING) {
        hb_core_halt(core, HB_STATE_FAULT, HB_FAULT_OVERRUN);
    }
}

void hb_core_heartbeat(hb_core *core)
{
    core->safety.silence_ticks = 0;
}
