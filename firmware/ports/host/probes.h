/* Functions of the core applied to arrays, for tests that compare them with a reference. */
#ifndef HB_PROBES_H
#define HB_PROBES_H

#include "host.h"

void hb_probe_velocity(float tau_s, float period_s, const float *x, const float *a, float *v,
                       uint32_t count);
void hb_probe_lowpass(float tau_s, float period_s, const float *in, float *out, uint32_t count);

/* Means of divider words each; returns their number. */
uint32_t hb_probe_mean(uint16_t divider, const uint16_t *in, uint16_t *out, uint32_t count);

/* A PI with limits. state: u and e of the previous step, updated. */
void hb_probe_pi(float gain, float time_constant_s, float period_s, float low, float high,
                 float *state, const float *e, float *u, uint32_t count);

uint16_t hb_probe_crc(const unsigned char *octets, uint16_t count);
uint16_t hb_probe_cobs_encode(const unsigned char *in, uint16_t count, unsigned char *out);
uint16_t hb_probe_cobs_decode(const unsigned char *in, uint16_t count, unsigned char *out);

/* Copies up to capacity records of the log, HB_RECORD_WORDS words each, from record number first
 * on, without the protocol; returns their number. */
uint32_t hb_probe_records(const hb_host *host, uint32_t first, uint16_t *words, uint32_t capacity);

/* Gives the log's next record a number, as after so many records. */
void hb_probe_skip_records(hb_host *host, uint32_t next);

/* Gives the last tick a number, as after so many ticks. */
void hb_probe_skip_ticks(hb_host *host, uint32_t tick);

/* Encodes a frame; returns the number of octets in out. */
uint16_t hb_probe_frame(unsigned char sequence, unsigned char type, const unsigned char *payload,
                        uint16_t count, unsigned char *out);
/* Decodes the last frame in the octets to its sequence, type and payload; returns their number,
 * 0 without a valid frame. */
uint16_t hb_probe_receive(const unsigned char *octets, uint16_t count, unsigned char *out);

/* Reads and writes a field of type 'u' (u16), 'l' (u32) or 'f' (f32). */
double hb_probe_get(char kind, const unsigned char *octets, uint16_t count);
uint16_t hb_probe_put(char kind, double value, unsigned char *out);
uint16_t hb_probe_put_text16(const char *text, unsigned char *out);

#endif
