/* PI controller of equation D.18 in incremental form, with anti-windup by clamping:
 *
 *   u_k = u_{k-1} + K_c tau_c (e_k - e_{k-1}) + K_c T e_k,   then low <= u_k <= high.
 *
 * The next step starts from the clamped u_k.
 */
#ifndef HB_PI_H
#define HB_PI_H

typedef struct {
    float proportional; /* K_c tau_c [V per unit of e] */
    float integral;     /* K_c T [V per unit of e and step] */
} hb_pi_config;

typedef struct {
    float u; /* u_{k-1} [V], clamped */
    float e; /* e_{k-1} */
} hb_pi_state;

hb_pi_config hb_pi_design(float gain, float time_constant_s, float period_s);
float hb_pi_step(const hb_pi_config *config, hb_pi_state *state, float e, float low, float high);

#endif
