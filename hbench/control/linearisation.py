"""The linear model of the bench around an operating point (source, section 4.1).

Chambers and valves of the equations 4.4 to 4.23, masses and viscous friction of 4.1 to 4.3. The
position is held: chamber volumes change slowly against everything else. Coulomb friction is a
constant and drops out. The slope of a Stribeck curve and the sag of a pump's pressure are left to
the nonlinear check.
"""

from dataclasses import dataclass, fields
from math import copysign, sqrt

import numpy as np
from scipy.optimize import brentq

from hbench.errors import ConfigError
from hbench.model.cylinders import extending_volumes, retracting_volumes
from hbench.model.friction.laws import steady_friction, viscous_coefficient
from hbench.model.parameters import PlantParameters
from hbench.model.supply import rest_flow

# State of the linear model: m/s; Pa; spools in V and V/s. Inputs: u_T, u_L1, u_L2 in V.
N_STATES = 11
V, P_TP, P_TR, P_LP, P_LR = range(5)
SPOOLS, RATES = slice(5, 8), slice(8, 11)
SPOOL_T, SPOOL_L1, SPOOL_L2 = 5, 6, 7


@dataclass(frozen=True)
class OperatingPoint:
    """Operating point of a linearisation. Not every point of the source is a steady state."""

    x_m: float
    v_m_s: float  # positive extends the test cylinder
    p_tp_pa: float
    p_tr_pa: float
    p_lp_pa: float
    p_lr_pa: float
    u_t_v: float
    u_l1_v: float
    u_l2_v: float
    viscous_n_s_m: float  # B = B_T + B_L


@dataclass(frozen=True)
class LinearCoefficients:
    """Coefficients of 4.1 to 4.23. Flows enter a chamber but leave the test cylinder's rod side."""

    ku_tp: float  # flow gains dQ/du, m^3/s/V
    ku_tr: float
    ku_lp: float
    ku_lr: float
    kp_tp: float  # flow-pressure coefficients dQ/dP, m^3/s/Pa
    kp_tr: float
    kp_lp: float
    kp_lr: float
    v_tp: float  # chamber volumes, m^3
    v_tr: float
    v_lp: float
    v_lr: float
    a_tp: float  # areas, m^2
    a_tr: float
    a_lp: float
    a_lr: float
    beta: float  # Pa
    mass: float  # kg
    viscous: float  # N s/m

    @property
    def feedforward_rod(self) -> float:
        """C_ffLr = A_Lr / K_uLr [V s/m], equation 4.27."""
        return self.a_lr / self.ku_lr

    @property
    def feedforward_piston(self) -> float:
        """C_ffLp = A_Lp / K_uLp [V s/m], equation 4.28; the board subtracts it."""
        return self.a_lp / self.ku_lp


def steady_point(
    par: PlantParameters, x_m: float, v_m_s: float, f_load_n: float, p_lr_pa: float
) -> OperatingPoint:
    """Return the steady state at constant velocity and load.

    Flows into the chambers are A v (4.4 to 4.9), pressures balance with friction (4.1). The
    symmetric test valve keeps P_Tr - P_t = r^2 (P_s - P_Tp) in extension, and
    P_s - P_Tr = r^2 (P_Tp - P_t) in retraction, r = A_r / A_p.

    Raises ``ConfigError`` where supply or valve is insufficient.
    """
    test, load = par.test, par.load
    p_s, p_t, k_s = rest_flow(par.supply)[0], par.supply.tank_pa, par.valve.flow_gain
    p_lp = (load.area_rod_m2 * p_lr_pa + f_load_n) / load.area_piston_m2
    needed = f_load_n + steady_friction(v_m_s, p_lp, p_lr_pa, load.friction)
    near, far = (p_s, p_t) if v_m_s >= 0 else (p_t, p_s)  # of the test cylinder's piston side
    ratio = (test.area_rod_m2 / test.area_piston_m2) ** 2

    def rod(p_tp: float) -> float:
        return far + ratio * (near - p_tp)

    def surplus(p_tp: float) -> float:
        p_tr = rod(p_tp)
        force = p_tp * test.area_piston_m2 - p_tr * test.area_rod_m2
        return force - needed - steady_friction(v_m_s, p_tp, p_tr, test.friction)

    where = f"at {1e3 * v_m_s:.4g} mm/s, load {f_load_n:.4g} N, p_lr {p_lr_pa / 1e5:.4g} bar"
    if not (p_t < p_lp < p_s and p_t < p_lr_pa < p_s):
        raise ConfigError(
            f"{where} the load cylinder needs {p_lp / 1e5:.4g} and {p_lr_pa / 1e5:.4g} bar; "
            f"tank and supply are {p_t / 1e5:g} and {p_s / 1e5:g} bar"
        )
    if surplus(p_t) * surplus(p_s) >= 0:
        raise ConfigError(f"{where} the test cylinder's pressures can't balance the load")
    p_tp = brentq(surplus, p_t, p_s, xtol=1e-3)

    def volts(area: float, speed: float, pressure: float) -> float:
        return area * speed / (k_s * sqrt(p_s - pressure if speed >= 0 else pressure - p_t))

    point = OperatingPoint(
        x_m=x_m,
        v_m_s=v_m_s,
        p_tp_pa=p_tp,
        p_tr_pa=rod(p_tp),
        p_lp_pa=p_lp,
        p_lr_pa=p_lr_pa,
        u_t_v=volts(test.area_piston_m2, v_m_s, p_tp),
        u_l1_v=volts(load.area_rod_m2, v_m_s, p_lr_pa),
        u_l2_v=volts(load.area_piston_m2, -v_m_s, p_lp),
        viscous_n_s_m=viscous_coefficient(v_m_s, test.friction)
        + viscous_coefficient(v_m_s, load.friction),
    )
    needs = max(abs(point.u_t_v), abs(point.u_l1_v), abs(point.u_l2_v))
    if needs > par.valve.limit_v:
        raise ConfigError(f"{where} a valve needs {needs:.3g} V; limit {par.valve.limit_v:g} V")
    return point


def linear_coefficients(par: PlantParameters, point: OperatingPoint) -> LinearCoefficients:
    """Return the coefficients 4.14 to 4.23 and the volumes at ``point``."""
    v_tp, v_tr = extending_volumes(point.x_m, par.test)
    v_lp, v_lr = retracting_volumes(point.x_m, par.load)
    ku_tp, kp_tp = _port(par, point.u_t_v, point.p_tp_pa)
    ku_tr, kp_tr = _port(par, -point.u_t_v, point.p_tr_pa)
    ku_lp, kp_lp = _port(par, point.u_l2_v, point.p_lp_pa)
    ku_lr, kp_lr = _port(par, point.u_l1_v, point.p_lr_pa)
    return LinearCoefficients(
        ku_tp=ku_tp,
        ku_tr=ku_tr,
        ku_lp=ku_lp,
        ku_lr=ku_lr,
        kp_tp=kp_tp,
        kp_tr=-kp_tr,
        kp_lp=kp_lp,
        kp_lr=kp_lr,
        v_tp=v_tp,
        v_tr=v_tr,
        v_lp=v_lp,
        v_lr=v_lr,
        a_tp=par.test.area_piston_m2,
        a_tr=par.test.area_rod_m2,
        a_lp=par.load.area_piston_m2,
        a_lr=par.load.area_rod_m2,
        beta=par.bulk_modulus_pa,
        mass=par.mass_test_kg + par.mass_load_kg,
        viscous=point.viscous_n_s_m,
    )


def _port(par: PlantParameters, u: float, pressure: float) -> tuple[float, float]:
    """dQ/du and dQ/dP of a flow into a chamber: k_s sqrt(dP), -+ k_s u / (2 sqrt(dP)).

    K_T sqrt(2/rho dP) and K_T u / (rho sqrt(2/rho dP)) of the source, with k_s = K_T sqrt(2/rho).
    """
    drop = rest_flow(par.supply)[0] - pressure if u >= 0 else pressure - par.supply.tank_pa
    gain = par.valve.flow_gain * sqrt(drop)
    return gain, copysign(1.0, -u) * gain * u / (2 * drop)


def state_space(c: LinearCoefficients, par: PlantParameters) -> tuple[np.ndarray, np.ndarray]:
    """Return A (11, 11) and B (11, 3) of the whole bench, valves (2.16) included."""
    a, b = np.zeros((N_STATES, N_STATES)), np.zeros((N_STATES, 3))
    a[V, : P_LR + 1] = np.array([-c.viscous, c.a_tp, -c.a_tr, -c.a_lp, c.a_lr]) / c.mass
    for chamber, stiffness, area, kp, spool, ku in (
        (P_TP, c.beta / c.v_tp, -c.a_tp, c.kp_tp, SPOOL_T, c.ku_tp),
        (P_TR, c.beta / c.v_tr, c.a_tr, -c.kp_tr, SPOOL_T, -c.ku_tr),
        (P_LP, c.beta / c.v_lp, c.a_lp, c.kp_lp, SPOOL_L2, c.ku_lp),
        (P_LR, c.beta / c.v_lr, -c.a_lr, c.kp_lr, SPOOL_L1, c.ku_lr),
    ):
        a[chamber, V] = stiffness * area
        a[chamber, chamber] = stiffness * kp
        a[chamber, spool] = stiffness * ku
    omega, zeta = par.valve.natural_frequency_rad_s, par.valve.damping
    a[SPOOLS, RATES] = np.eye(3)
    a[RATES, SPOOLS] = -(omega**2) * np.eye(3)
    a[RATES, RATES] = -2 * zeta * omega * np.eye(3)
    b[RATES] = omega**2 * np.eye(3)
    return a, b


def as_numbers(record: OperatingPoint | LinearCoefficients) -> dict[str, float]:
    """Return the fields of an operating point or of coefficients by name."""
    return {field.name: float(getattr(record, field.name)) for field in fields(record)}
