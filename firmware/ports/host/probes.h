/* Parts of the core run over arrays, for tests that compare them with something else. */
#ifndef HB_PROBES_H
#define HB_PROBES_H

#include "host.h"

void hb_probe_velocity(float tau_s, float period_s, const float *x, float *v, uint32_t count);
void hb_probe_lowpass(float tau_s, float period_s, const float *in, float *out, uint32_t count);

/* Means of divider words each; returns how many. */
uint32_t hb_probe_mean(uint16_t divider, const uint16_t *in, uint16_t *out, uint32_t count);

/* A PI between two clamps. state: u and e of the step before, updated. */
void hb_probe_pi(float gain, float time_constant_s, float period_s, float low, float high,
                 float *state, const float *e, float *u, uint32_t count);

uint16_t hb_probe_crc(const unsigned char *octets, uint16_t count);
uint16_t hb_probe_cobs_encode(const unsigned char *in, uint16_t count, unsigned char *out);
uint16_t hb_probe_cobs_decode(const unsigned char *in, uint16_t count, unsigned char *out);

/* What the board holds in its log, past the wire: HB_RECORD_WORDS words each, from record number
 * first on, at most capacity records; returns how many. */
uint32_t hb_probe_records(hb_host *host, uint32_t first, uint16_t *words, uint32_t capacity);

/* A whole frame from its parts; returns the octets in out. */
uint16_t hb_probe_frame(unsigned char sequence, unsigned char type, const unsigned char *payload,
                        uint16_t count, unsigned char *out);
/* Sequence, type and payload of the last frame in the octets; returns how many, 0 without one. */
uint16_t hb_probe_receive(const unsigned char *octets, uint16_t count, unsigned char *out);

/* A field of kind 'u' (u16), 'l' (u32) or 'f' (f32) from its octets, and to them. */
double hb_probe_get(char kind, const unsigned char *octets, uint16_t count);
uint16_t hb_probe_put(char kind, double value, unsigned char *out);
uint16_t hb_probe_put_text16(const char *text, unsigned char *out);

#endif
