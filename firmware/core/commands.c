#include "commands.h"

#include "numeric.h"

#define RECORD_OCTETS (2u * HB_RECORD_WORDS)

/* All fields were there, and nothing after them. */
static bool whole(const hb_reader *request)
{
    return request->ok && request->left == 0u;
}

static hb_u16 identify(const hb_core *core, const hb_reader *request, hb_writer *reply)
{
    if (!whole(request)) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    hb_put_u16(reply, HB_PROTOCOL);
    hb_put_u32(reply, HB_DICTIONARY_HASH);
    hb_put_text16(reply, HB_FIRMWARE);
    hb_put_text16(reply, core->hal.board);
    hb_put_u16(reply, core->boots);
    hb_put_u16(reply, HB_RATE_HZ);
    hb_put_u16(reply, HB_LOG_RECORDS);
    hb_put_u16(reply, HB_MAX_STEPS);
    hb_put_u16(reply, HB_MAX_SEGMENTS);
    return HB_REFUSAL_NONE;
}

static hb_u16 write_settings(hb_core *core, hb_reader *request)
{
    const hb_u16 first = hb_get_u16(request);
    const hb_u16 count = request->left / 4u;

    if (!request->ok || request->left % 4u != 0u) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    if (core->state == HB_STATE_RUNNING) {
        return HB_REFUSAL_BUSY;
    }
    if ((hb_u32)first + count > HB_SETTINGS) {
        return HB_REFUSAL_OUT_OF_RANGE;
    }
    hb_reader check = *request;
    for (hb_u16 i = 0; i < count; i++) {
        if (!hb_finite(hb_get_f32(&check))) {
            return HB_REFUSAL_OUT_OF_RANGE;
        }
    }
    for (hb_u16 i = 0; i < count; i++) {
        hb_settings_write(&core->settings, (hb_u16)(first + i), hb_get_f32(request));
    }
    core->started = false;
    hb_core_configure(core);
    return HB_REFUSAL_NONE;
}

static hb_u16 write_segment(hb_core *core, hb_reader *request)
{
    const hb_u16 index = hb_get_u16(request);
    hb_segment segment;

    segment.valves = hb_get_u16(request);
    segment.v_m_s = hb_get_f32(request);
    segment.a_m_s2 = hb_get_f32(request);
    segment.duration_s = hb_get_f32(request);
    if (!whole(request)) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    if (core->state == HB_STATE_RUNNING) {
        return HB_REFUSAL_BUSY;
    }
    if (!hb_segment_in_range(&segment) || !hb_segments_write(&core->steps, index, &segment)) {
        return HB_REFUSAL_OUT_OF_RANGE;
    }
    core->started = false;
    return HB_REFUSAL_NONE;
}

static hb_u16 write_step(hb_core *core, hb_reader *request)
{
    const hb_u16 index = hb_get_u16(request);
    hb_step step;

    step.run = hb_get_u16(request);
    step.trials = hb_get_u16(request);
    step.segment = hb_get_u16(request);
    step.segments = hb_get_u16(request);
    step.cycles = hb_get_u16(request);
    step.until = hb_get_u16(request);
    step.within = hb_get_f32(request);
    step.p_lr_ref_pa = hb_get_f32(request);
    step.p_lp_ref_pa = hb_get_f32(request);
    step.x_start_m = hb_get_f32(request);
    step.x_min_m = hb_get_f32(request);
    step.x_max_m = hb_get_f32(request);
    step.hold_s = hb_get_f32(request);
    if (!whole(request)) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    if (core->state == HB_STATE_RUNNING) {
        return HB_REFUSAL_BUSY;
    }
    if (!hb_step_in_range(&step) || !hb_steps_write(&core->steps, index, &step)) {
        return HB_REFUSAL_OUT_OF_RANGE;
    }
    core->started = false;
    return HB_REFUSAL_NONE;
}

static hb_u16 start(hb_core *core, hb_octet sequence, hb_reader *request)
{
    const hb_u16 settings_crc = hb_get_u16(request);
    const hb_u16 steps_crc = hb_get_u16(request);
    const float *value = core->settings.value;

    if (!whole(request)) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    const bool again = core->started && sequence == core->start_sequence
                    && settings_crc == core->start_settings_crc
                    && steps_crc == core->start_steps_crc;

    if (core->state == HB_STATE_FAULT) {
        return HB_REFUSAL_FAULT_LATCHED;
    }
    if (again) { /* it may be over by now, or stopped: nothing moves a second time */
        return HB_REFUSAL_NONE;
    }
    if (core->state == HB_STATE_RUNNING) {
        return HB_REFUSAL_BUSY;
    }
    if (!hb_settings_complete(&core->settings) || core->steps.count == 0u) {
        return HB_REFUSAL_NOT_READY;
    }
    if (settings_crc != hb_settings_crc(&core->settings)) {
        return HB_REFUSAL_SETTINGS_DIFFER;
    }
    if (steps_crc != hb_steps_crc(&core->steps)) {
        return HB_REFUSAL_STEPS_DIFFER;
    }
    if (!hb_settings_in_range(&core->settings)
        || !hb_steps_sound(&core->steps, value[HB_SETTING_TRAVEL_MIN_M],
                           value[HB_SETTING_TRAVEL_MAX_M])) {
        return HB_REFUSAL_OUT_OF_RANGE;
    }
    core->started = true;
    core->start_sequence = sequence;
    core->start_settings_crc = settings_crc;
    core->start_steps_crc = steps_crc;
    hb_core_start(core);
    return HB_REFUSAL_NONE;
}

static hb_u16 stop(hb_core *core, const hb_reader *request)
{
    if (!whole(request)) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    if (core->state == HB_STATE_RUNNING) {
        hb_core_halt(core, HB_STATE_IDLE, HB_FAULT_STOPPED);
    }
    return HB_REFUSAL_NONE;
}

static hb_u16 clear_fault(hb_core *core, const hb_reader *request)
{
    if (!whole(request)) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    if (core->state == HB_STATE_RUNNING) {
        return HB_REFUSAL_BUSY;
    }
    if (core->state == HB_STATE_FAULT) {
        hb_core_halt(core, HB_STATE_IDLE, HB_FAULT_NONE);
    }
    return HB_REFUSAL_NONE;
}

static hb_u16 status(const hb_core *core, const hb_reader *request, hb_writer *reply)
{
    if (!whole(request)) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    hb_put_u16(reply, core->state);
    hb_put_u16(reply, core->schedule.phase);
    hb_put_u16(reply, core->fault);
    hb_put_u16(reply, core->schedule.step);
    hb_put_u16(reply, core->schedule.cycle);
    hb_put_u16(reply, hb_schedule_run(&core->steps, &core->schedule));
    hb_put_u16(reply, core->schedule.runs_done);
    hb_put_u32(reply, core->tick);
    hb_put_u32(reply, hb_log_first(&core->log));
    hb_put_u32(reply, core->log.next);
    hb_put_f32(reply, core->sensors.value[HB_SENSOR_X]);
    hb_put_f32(reply, core->sensors.velocity.v);
    hb_put_f32(reply, core->schedule.references.v_m_s);
    hb_put_f32(reply, core->sensors.value[HB_SENSOR_F_APPLIED]);
    for (hb_u16 i = HB_SENSOR_P_TP; i <= HB_SENSOR_P_S; i++) {
        hb_put_f32(reply, core->sensors.value[i]);
    }
    return HB_REFUSAL_NONE;
}

/* Copies a record while no tick can overwrite it; false if one has. */
static bool copy_record(const hb_core *core, hb_u32 number, hb_log_record record)
{
    core->hal.mask_control(core->hal.context);
    const bool there = number >= hb_log_first(&core->log);
    const hb_u16 *words = hb_log_words(&core->log, number);
    for (hb_u16 i = 0; i < HB_RECORD_WORDS; i++) {
        record[i] = words[i];
    }
    core->hal.unmask_control(core->hal.context);
    return there;
}

/* The one request that is answered with ticks going on: its reply is long. Where they overwrite a
 * record of it, it begins anew. */
static hb_u16 read_log(const hb_core *core, hb_reader *request, hb_writer *reply)
{
    const hb_u32 asked = hb_get_u32(request);
    const hb_u16 count = hb_get_u16(request);
    const hb_writer empty = *reply;
    hb_log_record record;
    bool whole_reply = false;

    if (!whole(request)) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    while (!whole_reply) {
        core->hal.mask_control(core->hal.context);
        const hb_u32 oldest = hb_log_first(&core->log);
        const hb_u32 next = core->log.next;
        core->hal.unmask_control(core->hal.context);
        const hb_u32 first = asked < oldest ? oldest : asked;

        *reply = empty;
        whole_reply = true;
        hb_put_u32(reply, first);
        hb_put_u32(reply, next);
        for (hb_u32 number = first; number < next && number - first < count; number++) {
            if (reply->room < RECORD_OCTETS) {
                break;
            }
            if (!copy_record(core, number, record)) {
                whole_reply = false;
                break;
            }
            for (hb_u16 i = 0; i < HB_RECORD_WORDS; i++) {
                hb_put_u16(reply, record[i]);
            }
        }
    }
    return HB_REFUSAL_NONE;
}

hb_u16 hb_command(hb_core *core, const hb_frame *frame, hb_writer *reply)
{
    hb_reader request = {frame->payload, frame->count, true};

    switch (frame->type) {
    case HB_MESSAGE_IDENTIFY:
        return identify(core, &request, reply);
    case HB_MESSAGE_WRITE_SETTINGS:
        return write_settings(core, &request);
    case HB_MESSAGE_WRITE_SEGMENT:
        return write_segment(core, &request);
    case HB_MESSAGE_WRITE_STEP:
        return write_step(core, &request);
    case HB_MESSAGE_START:
        return start(core, frame->sequence, &request);
    case HB_MESSAGE_STOP:
        return stop(core, &request);
    case HB_MESSAGE_CLEAR_FAULT:
        return clear_fault(core, &request);
    case HB_MESSAGE_STATUS:
        return status(core, &request, reply);
    case HB_MESSAGE_READ_LOG:
        return read_log(core, &request, reply);
    default:
        return HB_REFUSAL_UNKNOWN_MESSAGE;
    }
}
