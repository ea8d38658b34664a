/* The three control loops: velocity of the test cylinder, two pressures of the load cylinder.
 *
 *   u_T  controls the velocity, or during a push the force F_T: u_T = K (F_ref - F_T). Oil between
 *        closed ports integrates flow to pressure, so that a ramp of F_ref is followed at its rate,
 *        with a constant lag;
 *   u_L1 controls the pressure on the load cylinder's rod side, feedforward +C_rod v (the chamber
 *        grows while the test cylinder extends, and the valve must fill it);
 *   u_L2 controls the pressure on the load cylinder's piston side, feedforward -C_piston v
 *        (equation 4.28 with its sign corrected: the chamber shrinks).
 *
 * The force between the cylinders is that of both load pressures and the load cylinder's friction.
 * For a force without this friction, u_L2 can control one of these instead of P_Lp,ref:
 *
 *   load cell     the reference is P_Lp,ref + integral of (F_ref - F_applied) / (A_Lp tau_F), where
 *                 F_ref = P_Lp,ref A_Lp - P_Lr,ref A_Lr. The pressure's loop remains inside: a loop
 *                 of its speed around the load cell is unstable, as it also feels the inertia;
 *   friction law  the reference is P_Lp,ref - F_fL(v_ref) / A_Lp, with the law of equation 3.2.
 */
#ifndef HB_CONTROL_H
#define HB_CONTROL_H

#include "hal.h"
#include "pi.h"
#include "sensors.h"
#include "settings.h"

typedef struct {
    float v_m_s;
    float p_lr_pa;
    float p_lp_pa;
    bool pushing; /* the force counts instead of the velocity */
    float f_test_n;
} hb_references;

typedef struct {
    hb_pi_config loop[HB_VALVES];
    float feedforward[HB_VALVES]; /* signed [V s/m]; zero while it is off */
    float force_gain_v_n;
    float limit_v;
    hb_u16 load_control;
    float load_integral; /* T / tau_F */
    float load_trim_max_pa;
    float load_piston_m2; /* areas of the load cylinder */
    float load_rod_m2;
    float coulomb_n; /* friction of the load cylinder */
    float stiction_n;
    float stribeck_m_s;
    float viscous_n_s_m;
} hb_control_config;

typedef struct {
    hb_pi_state loop[HB_VALVES];
    float u[HB_VALVES]; /* commands [V], within the limit */
    float load_trim_pa; /* what the load cell adds to the reference of P_Lp */
    bool saturated;     /* a command is at the limit */
} hb_control_state;

/* All valves at u_v, integrators empty. */
void hb_control_hold(hb_control_state *state, float u_v);
hb_control_config hb_control_design(const hb_settings *settings);
void hb_control_step(const hb_control_config *config, hb_control_state *state,
                     const hb_references *references, const hb_sensors_state *sensors);

/* The DAC code of a command. */
hb_i16 hb_dac_code(const hb_dac_scale *dac, float volts);

#endif
