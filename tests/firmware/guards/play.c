/* Applies a script to a board and outputs its replies and DAC codes: natively, under sanitizers, on an
 * emulated controller with a 16-bit int, and in a fuzzer.
 *
 * A script is a sequence of commands, little-endian; unknown octets are skipped:
 *   R count octets...                       octets from the host, then the idle loop
 *   T count(2) words(14)                    control ticks with the same seven converter words
 *   F sequence type count payload...        like R, a frame whose CRC and stuffing are added here, so
 *                                           that a fuzzer passes these checks
 *   O                                       a late tick
 *   N tick(2)                               the last tick gets this number, as after so many ticks
 *   S sequence a b                          a start with the checksums of the settings and steps on
 *                                           the board, modified by the bits in a and b
 * The output consists of the octets of the replies and the three DAC codes of each tick. Invariants
 * are checked after each step.
 */
#include "host.h"
#include "octets.h"
#include "play.h"

#define REPLY_OCTETS 512u

typedef struct {
    hb_host *host;
    const hb_core *core;
    hb_receiver replies;
    unsigned char last; /* octet of the replies */
    bool cleared; /* the last octets cleared the fault */
} session;

static hb_u16 next_u16(void)
{
    const unsigned low = play_next();
    return (hb_u16)(low | (unsigned)play_next() << 8);
}

static void output_u16(unsigned value)
{
    play_output(value & 0xFFu);
    play_output(value >> 8 & 0xFFu);
}

/* Contracts of a running board: all that commands and time limits promise. Comparisons with NaN are
 * false. */
static void check_running(const hb_core *core)
{
    const float *setting = core->settings.value;
    const hb_schedule_state *schedule = &core->schedule;
    const hb_schedule_config *config = &core->schedule_config;
    const float limit = setting[HB_SETTING_VOLTAGE_LIMIT_V];
    const float p_max = setting[HB_SETTING_PRESSURE_MAX_PA];
    const hb_step *step = &core->steps.step[schedule->step];

    PLAY_CHECK(hb_settings_complete(&core->settings));
    PLAY_CHECK(hb_settings_valid(&core->settings, core->hal.dac.range_v));
    PLAY_CHECK(core->safety.silence_ticks <= core->safety_config.heartbeat_ticks);
    PLAY_CHECK(core->safety.error_ticks <= core->safety_config.speed_error_ticks);
    PLAY_CHECK(schedule->step < core->steps.count && schedule->trial < step->trials);
    PLAY_CHECK(schedule->segment < step->segments && schedule->cycle < step->cycles);
    PLAY_CHECK(step->p_lr_ref_pa <= p_max && step->p_lp_ref_pa <= p_max);
    PLAY_CHECK(schedule->ready_ticks <= schedule->ticks);
    PLAY_CHECK(schedule->phase != HB_PHASE_RETURN
               || schedule->ticks <= config->return_ticks + 1u);
    PLAY_CHECK(schedule->phase != HB_PHASE_HOLD
               || schedule->ticks - schedule->ready_ticks <= config->load_ticks + 1u);
    for (hb_u16 i = 0; i < HB_VALVES; i++) {
        PLAY_CHECK(core->control.u[i] >= -limit && core->control.u[i] <= limit);
    }
}

/* Invariants after a step, and those of its changes. */
static void check(const session *s, hb_u16 state, hb_u16 fault, hb_u32 log_next, bool may_start)
{
    const hb_core *core = s->core;

    PLAY_CHECK(core->state < PLAY_STATES);
    PLAY_CHECK(core->schedule.phase < PLAY_PHASES);
    PLAY_CHECK(core->fault < PLAY_FAULTS);
    PLAY_CHECK((core->state == HB_STATE_RUNNING) == (core->schedule.phase != HB_PHASE_NONE));
    PLAY_CHECK(core->state != HB_STATE_FAULT || core->fault != HB_FAULT_NONE);
    PLAY_CHECK(core->log.next >= log_next);
    if (core->state == HB_STATE_RUNNING) {
        PLAY_CHECK(state == HB_STATE_RUNNING || may_start);
        check_running(core);
    }
    if (state == HB_STATE_FAULT && !s->cleared) {
        PLAY_CHECK(core->state == HB_STATE_FAULT && core->fault == fault);
    }
}

/* Outputs the replies. Each octet must belong to a valid frame or to a status line. */
static void output_replies(session *s)
{
    unsigned char octets[REPLY_OCTETS];
    hb_frame frame;
    uint32_t count;

    while ((count = hb_host_transmit(s->host, octets, REPLY_OCTETS)) > 0u) {
        for (uint32_t i = 0; i < count; i++) {
            play_output(octets[i]);
            if (hb_receive(&s->replies, octets[i], &frame)) {
                s->cleared = s->cleared || frame.type == (HB_MESSAGE_CLEAR_FAULT | HB_REPLY);
            } else {
                PLAY_CHECK(octets[i] != 0u || s->last == '\n');
            }
            s->last = octets[i];
        }
        hb_host_poll(s->host);
    }
}

static void receive(session *s, const unsigned char *octets, hb_u16 count)
{
    const hb_u16 state = s->core->state;
    const hb_u16 fault = s->core->fault;
    const hb_u32 log_next = s->core->log.next;

    PLAY_CHECK(hb_host_receive(s->host, octets, count) == count);
    s->cleared = false;
    hb_host_poll(s->host);
    output_replies(s);
    check(s, state, fault, log_next, true);
}

static void receive_frame(session *s, unsigned sequence, unsigned type, hb_octet *plain,
                          hb_u16 count)
{
    hb_octet stuffed[HB_MAX_ON_WIRE];
    unsigned char octets[HB_MAX_ON_WIRE];
    const hb_u16 length =
        hb_encode_frame((hb_octet)sequence, (hb_octet)type, plain, count, stuffed);

    for (hb_u16 i = 0; i < length; i++) {
        octets[i] = (unsigned char)stuffed[i];
    }
    receive(s, octets, length);
}

static void play_octets(session *s)
{
    unsigned char octets[255];
    const hb_u16 count = (hb_u16)play_next();

    for (hb_u16 i = 0; i < count; i++) {
        octets[i] = (unsigned char)play_next();
    }
    receive(s, octets, count);
}

static void play_frame(session *s)
{
    hb_octet plain[HB_MAX_FRAME];
    const unsigned sequence = play_next();
    const unsigned type = play_next();
    const unsigned announced = play_next();
    const hb_u16 count = (hb_u16)(announced < HB_MAX_PAYLOAD ? announced : HB_MAX_PAYLOAD);

    for (hb_u16 i = 0; i < count; i++) {
        plain[2u + i] = (hb_octet)play_next();
    }
    receive_frame(s, sequence, type, plain, count);
}

static void play_start(session *s)
{
    hb_octet plain[HB_MAX_FRAME];
    hb_writer payload = {&plain[2], 4, true};
    const unsigned sequence = play_next();

    hb_put_u16(&payload, (hb_u16)(hb_settings_crc(&s->core->settings) ^ play_next()));
    hb_put_u16(&payload, (hb_u16)(hb_steps_crc(&s->core->steps) ^ play_next()));
    receive_frame(s, sequence, HB_MESSAGE_START, plain, 4);
}

static void play_ticks(session *s)
{
    hb_u16 adc[HB_INPUTS];
    hb_i16 dac[HB_VALVES];
    const hb_u16 count = next_u16();

    for (hb_u16 i = 0; i < HB_INPUTS; i++) {
        adc[i] = next_u16();
    }
    for (hb_u16 n = 0; n < count && play_may_tick(); n++) {
        const hb_u16 state = s->core->state;
        const hb_u16 fault = s->core->fault;
        const hb_u32 log_next = s->core->log.next;

        s->cleared = false;
        hb_host_tick(s->host, adc, dac);
        for (hb_u16 i = 0; i < HB_VALVES; i++) {
            PLAY_CHECK(dac[i] >= s->core->hal.dac.code_min && dac[i] <= s->core->hal.dac.code_max);
            PLAY_CHECK(dac[i] == 0
                       || (s->core->state == HB_STATE_RUNNING
                           && s->core->schedule.phase != HB_PHASE_CLOSED));
            output_u16((hb_u16)dac[i]);
        }
        check(s, state, fault, log_next, false);
    }
}

static void play_number(const session *s)
{
    hb_core *core = (hb_core *)s->core;

    core->tick = next_u16();
}

static void play_late(session *s)
{
    const hb_u16 state = s->core->state;
    const hb_u16 fault = s->core->fault;

    s->cleared = false;
    hb_host_overrun(s->host);
    PLAY_CHECK(s->core->state != HB_STATE_RUNNING);
    check(s, state, fault, s->core->log.next, false);
}

void play(void)
{
    session s = {hb_host_create(1, 0), 0, {{0}, 0, false}, 0, false};

    PLAY_CHECK(s.host != 0);
    s.core = hb_host_core(s.host);
    while (play_more()) {
        switch (play_next()) {
        case 'R':
            play_octets(&s);
            break;
        case 'T':
            play_ticks(&s);
            break;
        case 'F':
            play_frame(&s);
            break;
        case 'O':
            play_late(&s);
            break;
        case 'N':
            play_number(&s);
            break;
        case 'S':
            play_start(&s);
            break;
        default:
            break;
        }
    }
    hb_host_destroy(s.host);
}
