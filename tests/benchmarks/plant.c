/* The plant in plain C, a peer of hbench/model for its results and its speed: both cylinders with
 * LuGre's friction, three valves, constant supply. Written from the equations, all in SI. */

#include <math.h>
#include <stddef.h>
#include <string.h>

enum { X, V, P_TP, P_TR, P_LP, P_LR, Y_T, Y_L1, Y_L2, DY_T, DY_L1, DY_L2, Z_T, Z_L, STATES };
enum { U_T, U_L1, U_L2, COMMANDS };

typedef struct {
    double coulomb, stiction, v_stribeck, exponent; /* N, N, m/s, 1 */
    double viscous, sigma_0, sigma_1;               /* N s/m, N/m, N s/m */
    double piston_seal, rod_seal;                   /* N/Pa */
} friction;

typedef struct {
    double area_p, area_r, stroke, dead_p, dead_r, offset;
    friction friction;
} cylinder;

typedef struct {
    cylinder test, load;
    double mass_test, mass_load;
    double beta;                           /* bulk modulus */
    double p_supply, p_tank;
    double k_s, omega, damping, limit;     /* of the valves */
    double stop_stiffness, stop_damping;
} plant;

static double clamped(double value, double limit)
{
    return value > limit ? limit : value < -limit ? -limit : value;
}

/* 3.8 to 3.12, with seal terms after 3.7 */
static double lugre(double v, double z, double p_p, double p_r, const friction *f, double *dz)
{
    double s = fabs(v) / f->v_stribeck;
    if (f->exponent != 1.0) {
        s = pow(s, f->exponent);
    }
    const double seal = f->piston_seal * fabs(p_p - p_r) + f->rod_seal * p_r;
    const double dry = f->coulomb + seal + (f->stiction - f->coulomb) * exp(-s);
    *dz = v - fabs(v) * z * f->sigma_0 / dry;
    return f->sigma_0 * z + f->sigma_1 * *dz + f->viscous * v;
}

/* Of the heads on the piston: a spring and a damper that never pull. */
static double stop_force(double position, double v, double stroke, const plant *p)
{
    if (position < 0.0) {
        return fmax(0.0, -p->stop_stiffness * position - p->stop_damping * v);
    }
    if (position > stroke) {
        return -fmax(0.0, p->stop_stiffness * (position - stroke) + p->stop_damping * v);
    }
    return 0.0;
}

/* Square root of a pressure drop with its sign, smooth within some 1e3 Pa of zero. */
static double root(double dp)
{
    if (fabs(dp) > 1e6) {
        return copysign(sqrt(fabs(dp)), dp);
    }
    return dp / sqrt(sqrt(dp * dp + 1e6));
}

/* 2.13, 2.17, 2.18: into a chamber */
static double flow(double spool, double pressure, const plant *p)
{
    const double y = clamped(spool, p->limit);
    return p->k_s * y * root(y >= 0.0 ? p->p_supply - pressure : pressure - p->p_tank);
}

/* 2.1 to 2.8; below 1 bar a chamber that is torn apart cavitates. */
static double pressure_rate(double pressure, double volume, double inflow, double beta)
{
    const double rate = beta / volume * inflow;
    return rate < 0.0 && pressure < 1e5 ? rate * fmax(pressure, 0.0) / 1e5 : rate;
}

static void derivatives(const double *s, const double *u, const plant *p, double *d)
{
    const cylinder *t = &p->test, *l = &p->load;
    const double v = s[V], x_t = s[X] + t->offset, x_l = s[X] + l->offset;
    const double friction_t = lugre(v, s[Z_T], s[P_TP], s[P_TR], &t->friction, &d[Z_T]);
    const double friction_l = lugre(v, s[Z_L], s[P_LP], s[P_LR], &l->friction, &d[Z_L]);
    const double test = s[P_TP] * t->area_p - s[P_TR] * t->area_r + stop_force(x_t, v, t->stroke, p);
    const double load = s[P_LP] * l->area_p - s[P_LR] * l->area_r - stop_force(x_l, v, l->stroke, p);

    d[X] = v;
    d[V] = (test - load - friction_t - friction_l) / (p->mass_test + p->mass_load);
    d[P_TP] = pressure_rate(s[P_TP], t->dead_p + t->area_p * x_t,
                            flow(s[Y_T], s[P_TP], p) - t->area_p * v, p->beta);
    d[P_TR] = pressure_rate(s[P_TR], t->dead_r + t->area_r * (t->stroke - x_t),
                            flow(-s[Y_T], s[P_TR], p) + t->area_r * v, p->beta);
    d[P_LP] = pressure_rate(s[P_LP], l->dead_p + l->area_p * (l->stroke - x_l),
                            flow(s[Y_L2], s[P_LP], p) + l->area_p * v, p->beta);
    d[P_LR] = pressure_rate(s[P_LR], l->dead_r + l->area_r * x_l,
                            flow(s[Y_L1], s[P_LR], p) - l->area_r * v, p->beta);
    for (int i = 0; i < COMMANDS; i++) {
        const double error = clamped(u[i], p->limit) - s[Y_T + i];
        d[Y_T + i] = s[DY_T + i];
        d[DY_T + i] = p->omega * (p->omega * error - 2.0 * p->damping * s[DY_T + i]);
    }
}

/* Ralston's third order */
static void step(double *s, const double *u, const plant *p, double h)
{
    static const double weight[3] = {2.0, 3.0, 4.0}, reach[3] = {0.5, 0.75, 0.0};
    double trial[STATES], slope[STATES], total[STATES] = {0.0};

    memcpy(trial, s, sizeof trial);
    for (int stage = 0; stage < 3; stage++) {
        derivatives(trial, u, p, slope);
        for (int i = 0; i < STATES; i++) {
            total[i] += weight[stage] * slope[i];
            trial[i] = s[i] + reach[stage] * h * slope[i];
        }
    }
    for (int i = 0; i < STATES; i++) {
        s[i] += h / 9.0 * total[i];
    }
}

void run(const plant *p, double *state, const double *u, size_t ticks)
{
    for (size_t tick = 0; tick < ticks; tick++) {
        step(state, &u[COMMANDS * tick], p, 1e-4);
    }
}
