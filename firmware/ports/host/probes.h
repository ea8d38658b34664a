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

#endif
