#include "core.h"

#include "commands.h"
#include "octets.h"

void hb_core_init(hb_core *core, const hb_hal *hal, hb_log_ring ring, hb_u16 boots)
{
    core->hal = *hal;
    core->boots = boots;
    hb_settings_init(&core->settings);
    hb_steps_init(&core->steps);
    core->state = HB_STATE_IDLE;
    core->fault = HB_FAULT_NONE;
    core->tick = 0;
    hb_safety_init(&core->safety);
    hb_sensors_init(&core->sensors);
    hb_control_init(&core->control);
    hb_schedule_init(&core->schedule);
    hb_log_init(&core->log, ring);
    hb_core_configure(core);
    core->started = false;
    core->receiver.count = 0;
    core->receiver.too_long = false;
    core->out_count = 0;
    core->out_sent = 0;
}

void hb_core_configure(hb_core *core)
{
    core->sensors_config = hb_sensors_design(&core->settings);
    core->control_config = hb_control_design(&core->settings);
    core->sensors.primed = false;
    /* Divides by settings and turns them into integers, so only where they are sound. Without
     * that nothing starts. */
    if (hb_settings_in_range(&core->settings)) {
        core->schedule_config = hb_schedule_design(&core->settings);
        core->safety_config = hb_safety_design(&core->settings);
    }
}

void hb_core_start(hb_core *core)
{
    hb_control_init(&core->control);
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

/* The schedule's next tick, and the run's log begun and ended with it. */
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

static void log_tick(hb_core *core, const hb_u16 adc[HB_SENSORS])
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

void hb_core_tick(hb_core *core, const hb_u16 adc[HB_SENSORS], hb_i16 dac[HB_VALVES])
{
    core->tick++;
    hb_sensors_step(&core->sensors_config, &core->sensors, adc);

    if (core->state == HB_STATE_RUNNING) {
        const hb_u16 fault = hb_safety_step(&core->safety_config, &core->safety, &core->sensors,
                                            core->schedule.references.v_m_s);
        if (fault != HB_FAULT_NONE) {
            hb_core_halt(core, HB_STATE_FAULT, fault);
        } else if (hb_schedule_overdue(&core->schedule_config, &core->schedule)) {
            hb_core_halt(core, HB_STATE_FAULT, HB_FAULT_RETURN);
        } else {
            advance(core);
        }
    }
    if (core->state == HB_STATE_RUNNING && core->schedule.phase != HB_PHASE_CLOSED) {
        hb_control_step(&core->control_config, &core->control, &core->schedule.references,
                        &core->sensors);
    } else {
        hb_control_init(&core->control); /* neutral */
    }
    for (hb_u16 i = 0; i < HB_VALVES; i++) {
        dac[i] = hb_dac_code(core->control.u[i]);
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

/* Hands the waiting reply to the UART; true when all of it has gone. */
static bool flush(hb_core *core)
{
    if (core->out_sent < core->out_count) {
        const hb_u16 accepted =
            core->hal.uart_write(core->hal.context, &core->out[core->out_sent],
                                 (hb_u16)(core->out_count - core->out_sent));
        core->out_sent = (hb_u16)(core->out_sent + accepted);
    }
    return core->out_sent == core->out_count;
}

static void answer(hb_core *core, const hb_frame *frame)
{
    hb_writer reply = {&core->reply[2], HB_MAX_PAYLOAD, true};
    hb_octet type = (hb_octet)(frame->type | HB_REPLY);

    const bool masked = frame->type != HB_MESSAGE_READ_LOG; /* which masks record by record */

    core->hal.mask_control(core->hal.context);
    core->safety.silence_ticks = 0;
    if (!masked) {
        core->hal.unmask_control(core->hal.context);
    }
    const hb_u16 refusal = hb_command(core, frame, &reply);
    if (masked) {
        core->hal.unmask_control(core->hal.context);
    }

    if (refusal != HB_REFUSAL_NONE) {
        const hb_writer empty = {&core->reply[2], HB_MAX_PAYLOAD, true};
        reply = empty;
        type = HB_ERROR;
        hb_put_u16(&reply, frame->type);
        hb_put_u16(&reply, refusal);
    }
    core->out_count = hb_encode_frame(frame->sequence, type, core->reply,
                                      (hb_u16)(HB_MAX_PAYLOAD - reply.room), core->out);
    core->out_sent = 0;
}

static void put_text(hb_writer *writer, const char *text)
{
    while (*text != '\0') {
        hb_put_octet(writer, (hb_octet)*text++);
    }
}

/* One line for a person at a terminal. Its zero octet lets a host drop it as an unsound frame. */
static void answer_person(hb_core *core)
{
    static const char state[][HB_NAME_SIZE] = HB_STATE_NAMES;
    static const char fault[][HB_NAME_SIZE] = HB_FAULT_NAMES;
    hb_writer line = {core->out, HB_MAX_ON_WIRE, true};

    put_text(&line, HB_FIRMWARE " on ");
    put_text(&line, core->hal.board);
    put_text(&line, ", " HB_VERSION_TEXT ", state ");
    put_text(&line, state[core->state]);
    put_text(&line, ", fault ");
    put_text(&line, fault[core->fault]);
    put_text(&line, "\r\n");
    hb_put_octet(&line, 0u);
    core->out_count = (hb_u16)(HB_MAX_ON_WIRE - line.room);
    core->out_sent = 0;
}

void hb_core_poll(hb_core *core)
{
    hb_octet octet;
    hb_frame frame;

    while (flush(core) && core->hal.uart_read(core->hal.context, &octet)) {
        if (hb_receive_question(&core->receiver, octet)) {
            answer_person(core); /* who is no host: no sign of life */
        } else if (hb_receive(&core->receiver, octet, &frame)) {
            answer(core, &frame);
        }
    }
}
