#include "probes.h"

#include "crc.h"
#include "filters.h"
#include "octets.h"
#include "pi.h"
#include "wire.h"

#define MAX_OCTETS 1024u

void hb_probe_velocity(float tau_s, float period_s, const float *x, const float *a, float *v,
                       uint32_t count)
{
    const hb_velocity_config config = hb_velocity_design(tau_s, period_s);
    hb_velocity_state state = {0.0f, 0.0f};

    for (uint32_t i = 0; i < count; i++) {
        hb_velocity_step(&config, &state, x[i], a[i]);
        v[i] = state.v;
    }
}

void hb_probe_lowpass(float tau_s, float period_s, const float *in, float *out, uint32_t count)
{
    const hb_lowpass_config config = hb_lowpass_design(tau_s, period_s);
    float y = 0.0f;

    for (uint32_t i = 0; i < count; i++) {
        hb_lowpass_step(&config, &y, in[i]);
        out[i] = y;
    }
}

uint32_t hb_probe_mean(uint16_t divider, const uint16_t *in, uint16_t *out, uint32_t count)
{
    uint32_t means = 0;
    uint32_t sum = 0;

    for (uint32_t i = 0; i < count; i++) {
        sum += in[i];
        if ((i + 1u) % divider == 0u) {
            out[means++] = hb_mean_word(sum, divider);
            sum = 0;
        }
    }
    return means;
}

void hb_probe_pi(float gain, float time_constant_s, float period_s, float low, float high,
                 float *state, const float *e, float *u, uint32_t count)
{
    const hb_pi_config config = hb_pi_design(gain, time_constant_s, period_s);
    hb_pi_state pi = {state[0], state[1]};

    for (uint32_t i = 0; i < count; i++) {
        u[i] = hb_pi_step(&config, &pi, e[i], low, high);
    }
    state[0] = pi.u;
    state[1] = pi.e;
}

/* Octets to the core's width and back. */
static void widen(const unsigned char *in, uint16_t count, hb_octet *out)
{
    for (uint16_t i = 0; i < count; i++) {
        out[i] = in[i];
    }
}

static void narrow(const hb_octet *in, uint16_t count, unsigned char *out)
{
    for (uint16_t i = 0; i < count; i++) {
        out[i] = (unsigned char)in[i];
    }
}

uint16_t hb_probe_crc(const unsigned char *octets, uint16_t count)
{
    hb_octet wide[MAX_OCTETS];

    widen(octets, count, wide);
    return hb_crc_octets(HB_CRC_START, wide, count);
}

uint16_t hb_probe_cobs_encode(const unsigned char *in, uint16_t count, unsigned char *out)
{
    hb_octet plain[MAX_OCTETS];
    hb_octet stuffed[MAX_OCTETS + MAX_OCTETS / 254u + 1u];

    widen(in, count, plain);
    const uint16_t length = hb_cobs_encode(plain, count, stuffed);
    narrow(stuffed, length, out);
    return length;
}

uint16_t hb_probe_cobs_decode(const unsigned char *in, uint16_t count, unsigned char *out)
{
    hb_octet octets[MAX_OCTETS + MAX_OCTETS / 254u + 1u];

    widen(in, count, octets);
    const uint16_t length = hb_cobs_decode(octets, count, octets);
    narrow(octets, length, out);
    return length;
}

uint32_t hb_probe_records(const hb_host *host, uint32_t first, uint16_t *words, uint32_t capacity)
{
    const hb_log *log = &hb_host_core(host)->log;
    uint32_t copied = 0;

    while (copied < capacity && first + copied < log->next) {
        const hb_u16 *record = hb_log_words(log, first + copied++);
        for (hb_u16 i = 0; i < HB_RECORD_WORDS; i++) {
            *words++ = record[i];
        }
    }
    return copied;
}

/* The next two change the core, through a pointer that is constant for others. */
// cppcheck-suppress constParameterPointer
void hb_probe_skip_records(hb_host *host, uint32_t next)
{
    hb_core *core = (hb_core *)hb_host_core(host);

    core->log.next = next;
}

// cppcheck-suppress constParameterPointer
void hb_probe_skip_ticks(hb_host *host, uint32_t tick)
{
    hb_core *core = (hb_core *)hb_host_core(host);

    core->tick = tick;
}

uint16_t hb_probe_frame(unsigned char sequence, unsigned char type, const unsigned char *payload,
                        uint16_t count, unsigned char *out)
{
    hb_octet plain[HB_MAX_FRAME];
    hb_octet stuffed[HB_MAX_ON_WIRE];

    widen(payload, count, &plain[2]);
    const uint16_t length = hb_encode_frame(sequence, type, plain, count, stuffed);
    narrow(stuffed, length, out);
    return length;
}

uint16_t hb_probe_receive(const unsigned char *octets, uint16_t count, unsigned char *out)
{
    hb_receiver receiver;
    hb_frame frame;
    uint16_t length = 0;

    receiver.count = 0;
    receiver.too_long = false;
    for (uint16_t i = 0; i < count; i++) {
        if (hb_receive(&receiver, octets[i], &frame)) {
            out[0] = (unsigned char)frame.sequence;
            out[1] = (unsigned char)frame.type;
            narrow(frame.payload, frame.count, &out[2]);
            length = (uint16_t)(frame.count + 2u);
        }
    }
    return length;
}

double hb_probe_get(char kind, const unsigned char *octets, uint16_t count)
{
    hb_octet wide[MAX_OCTETS];
    hb_reader reader = {wide, count, true};

    widen(octets, count, wide);
    if (kind == 'u') {
        return hb_get_u16(&reader);
    }
    return kind == 'l' ? (double)hb_get_u32(&reader) : (double)hb_get_f32(&reader);
}

static uint16_t written(const hb_octet *wide, const hb_writer *writer, unsigned char *out)
{
    const uint16_t count = (uint16_t)(MAX_OCTETS - writer->room);

    narrow(wide, count, out);
    return count;
}

uint16_t hb_probe_put(char kind, double value, unsigned char *out)
{
    hb_octet wide[MAX_OCTETS];
    hb_writer writer = {wide, MAX_OCTETS, true};

    if (kind == 'u') {
        hb_put_u16(&writer, (hb_u16)value);
    } else if (kind == 'l') {
        hb_put_u32(&writer, (hb_u32)value);
    } else {
        hb_put_f32(&writer, (float)value);
    }
    return written(wide, &writer, out);
}

uint16_t hb_probe_put_text16(const char *text, unsigned char *out)
{
    hb_octet wide[MAX_OCTETS];
    hb_writer writer = {wide, MAX_OCTETS, true};

    hb_put_text16(&writer, text);
    return written(wide, &writer, out);
}
