#include "commands.h"

#include "config.h"
#include "numeric.h"
#include "payloads.h"

#define RECORD_OCTETS (2u * HB_RECORD_WORDS)

static hb_u16 identify(const hb_core *core, const hb_reader *request, hb_writer *reply)
{
    hb_identify_reply fields;

    if (!hb_get_end(request)) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    fields.protocol = HB_PROTOCOL;
    fields.dictionary = HB_DICTIONARY_HASH;
    fields.firmware = HB_FIRMWARE;
    fields.board = core->hal.board;
    fields.boots = core->hal.boots;
    fields.rate_hz = HB_RATE_HZ;
    fields.ring_records = core->hal.ring_records;
    fields.max_steps = HB_MAX_STEPS;
    fields.max_segments = HB_MAX_SEGMENTS;
    hb_put_identify(reply, &fields);
    return HB_REFUSAL_NONE;
}

static hb_u16 write_settings(hb_core *core, hb_reader *reader)
{
    hb_write_settings_request request;

    if (!hb_get_write_settings(reader, &request)) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    if (core->state == HB_STATE_RUNNING) {
        return HB_REFUSAL_BUSY;
    }
    if ((hb_u32)request.first + request.values_count > HB_SETTINGS) {
        return HB_REFUSAL_OUT_OF_RANGE;
    }
    hb_reader check = *reader;
    for (hb_u16 i = 0; i < request.values_count; i++) {
        if (!hb_finite(hb_get_f32(&check))) {
            return HB_REFUSAL_OUT_OF_RANGE;
        }
    }
    for (hb_u16 i = 0; i < request.values_count; i++) {
        hb_settings_write(&core->settings, (hb_u16)(request.first + i), hb_get_f32(reader));
    }
    core->started = false;
    hb_core_configure(core);
    return HB_REFUSAL_NONE;
}

static hb_u16 write_segment(hb_core *core, hb_reader *reader)
{
    hb_write_segment_request request;

    if (!hb_get_write_segment(reader, &request)) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    if (core->state == HB_STATE_RUNNING) {
        return HB_REFUSAL_BUSY;
    }
    if (!hb_segment_valid(&request.segment)
        || !hb_segments_write(&core->steps, request.index, &request.segment)) {
        return HB_REFUSAL_OUT_OF_RANGE;
    }
    core->started = false;
    return HB_REFUSAL_NONE;
}

static hb_u16 write_step(hb_core *core, hb_reader *reader)
{
    hb_write_step_request request;

    if (!hb_get_write_step(reader, &request)) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    if (core->state == HB_STATE_RUNNING) {
        return HB_REFUSAL_BUSY;
    }
    if (!hb_step_valid(&request.step)
        || !hb_steps_write(&core->steps, request.index, &request.step)) {
        return HB_REFUSAL_OUT_OF_RANGE;
    }
    core->started = false;
    return HB_REFUSAL_NONE;
}

static hb_u16 start(hb_core *core, hb_octet sequence, hb_reader *reader)
{
    hb_start_request request;

    if (!hb_get_start(reader, &request)) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    const bool repeated = core->started && sequence == core->start_sequence
                       && request.settings_crc == core->start_settings_crc
                       && request.steps_crc == core->start_steps_crc;

    if (core->state == HB_STATE_FAULT) {
        return HB_REFUSAL_FAULT_LATCHED;
    }
    if (repeated) { /* the schedule may be over by now, or stopped: it is not started again */
        return HB_REFUSAL_NONE;
    }
    if (core->state == HB_STATE_RUNNING) {
        return HB_REFUSAL_BUSY;
    }
    if (!hb_settings_complete(&core->settings) || core->steps.count == 0u) {
        return HB_REFUSAL_NOT_READY;
    }
    if (request.settings_crc != hb_settings_crc(&core->settings)) {
        return HB_REFUSAL_SETTINGS_DIFFER;
    }
    if (request.steps_crc != hb_steps_crc(&core->steps)) {
        return HB_REFUSAL_STEPS_DIFFER;
    }
    if (!hb_settings_valid(&core->settings, core->hal.dac.range_v)
        || !hb_steps_valid(&core->steps, &core->settings)) {
        return HB_REFUSAL_OUT_OF_RANGE;
    }
    if (!hb_log_has_numbers(&core->log)) {
        return HB_REFUSAL_RESET_NEEDED;
    }
    core->started = true;
    core->start_sequence = sequence;
    core->start_settings_crc = request.settings_crc;
    core->start_steps_crc = request.steps_crc;
    hb_core_start(core);
    return HB_REFUSAL_NONE;
}

static hb_u16 stop(hb_core *core, const hb_reader *request)
{
    if (!hb_get_end(request)) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    if (core->state == HB_STATE_RUNNING) {
        hb_core_halt(core, HB_STATE_IDLE, HB_FAULT_STOPPED);
    }
    return HB_REFUSAL_NONE;
}

static hb_u16 clear_fault(hb_core *core, const hb_reader *request)
{
    if (!hb_get_end(request)) {
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
    const float *value = core->sensors.value;
    hb_status_reply fields;

    if (!hb_get_end(request)) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    fields.state = core->state;
    fields.phase = core->schedule.phase;
    fields.fault = core->fault;
    fields.step = core->schedule.step;
    fields.cycle = core->schedule.cycle;
    fields.run = hb_schedule_run(&core->steps, &core->schedule);
    fields.runs_done = core->schedule.runs_done;
    fields.tick = core->tick;
    fields.log_first = hb_log_first(&core->log);
    fields.log_next = core->log.next;
    fields.x_m = value[HB_SENSOR_X];
    fields.v_m_s = core->sensors.velocity.v;
    fields.v_ref_m_s = core->schedule.references.v_m_s;
    fields.f_applied_n = value[HB_SENSOR_F_APPLIED];
    fields.p_tp_pa = value[HB_SENSOR_P_TP];
    fields.p_tr_pa = value[HB_SENSOR_P_TR];
    fields.p_lp_pa = value[HB_SENSOR_P_LP];
    fields.p_lr_pa = value[HB_SENSOR_P_LR];
    fields.p_s_pa = value[HB_SENSOR_P_S];
    hb_put_status(reply, &fields);
    return HB_REFUSAL_NONE;
}

/* Copies a record while no tick can overwrite it; false if it was overwritten before. */
static bool copy_record(const hb_core *core, hb_u32 number, hb_log_record record)
{
    core->hal.mask_control(core->hal.context);
    const bool held = number >= hb_log_first(&core->log);
    const hb_u16 *words = hb_log_words(&core->log, number);
    for (hb_u16 i = 0; i < HB_RECORD_WORDS; i++) {
        record[i] = words[i];
    }
    core->hal.unmask_control(core->hal.context);
    return held;
}

/* Writes the records from first on, as many as fit; false if a tick overwrote one of them. */
static bool put_records(const hb_core *core, const hb_read_log_reply *fields, hb_u16 count,
                        hb_writer *reply)
{
    hb_log_record record;

    for (hb_u32 number = fields->first;
         number < fields->next && number - fields->first < count && reply->room >= RECORD_OCTETS;
         number++) {
        if (!copy_record(core, number, record)) {
            return false;
        }
        for (hb_u16 i = 0; i < HB_RECORD_WORDS; i++) {
            hb_put_u16(reply, record[i]);
        }
    }
    return true;
}

/* The only request during which ticks go on, because its reply is long. It begins again when they
 * overwrite one of its records. */
static hb_u16 read_log(const hb_core *core, hb_reader *reader, hb_writer *reply)
{
    const hb_writer empty = *reply;
    hb_read_log_request request;
    hb_read_log_reply fields;

    if (!hb_get_read_log(reader, &request)) {
        return HB_REFUSAL_BAD_PAYLOAD;
    }
    do {
        core->hal.mask_control(core->hal.context);
        const hb_u32 oldest = hb_log_first(&core->log);
        fields.next = core->log.next;
        core->hal.unmask_control(core->hal.context);
        fields.first = request.first < oldest ? oldest : request.first;

        *reply = empty;
        hb_put_read_log(reply, &fields);
    } while (!put_records(core, &fields, request.count, reply));
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
