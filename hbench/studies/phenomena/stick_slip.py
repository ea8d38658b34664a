"""Stick-slip (figure 3.11): a mass that a spring pulls at constant speed."""

from math import atan, pi, sqrt

import numpy as np
from scipy.optimize import brentq

from hbench.model.parameters import FrictionParameters
from hbench.records import Finding, Line, Panel, Phenomenon
from hbench.studies.phenomena.breakaway import breakaway_by_formula
from hbench.studies.phenomena.driven_friction import driven_mass
from hbench.studies.phenomena.laws import LUGRE, line

# Stiff bristles and a narrow Stribeck peak: near the friction with two levels of the closed forms.
STICK_SLIP = LUGRE._replace(
    viscous=0.0, stribeck_velocity=3e-3, bristle_stiffness=3e7, bristle_damping=2.4e4
)
MASS_KG = 10.0


def pulled(
    speed_m_s: float, stiffness_n_m: float, law: FrictionParameters, cycles: float = 4.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return time [s], velocity [m/s] and spring force [N] of a mass pulled from rest."""
    drop = law.stiction - law.coulomb
    dwell, slip = stick_slip_times(speed_m_s, stiffness_n_m, drop)
    dt = 2e-5
    until = law.stiction / (stiffness_n_m * speed_m_s) + cycles * (dwell + slip)
    t = dt * np.arange(round(until / dt))
    drive = stiffness_n_m * speed_m_s * t
    moved = driven_mass(drive, stiffness_n_m, MASS_KG, dt, law)
    return t, moved.v_m_s, drive - stiffness_n_m * moved.x_m


def stick_slip_times(speed_m_s: float, stiffness_n_m: float, drop_n: float) -> tuple[float, float]:
    """Return dwell and slip time [s] where friction drops by F_s - F_k; no viscous part.

    t_d = 2 (F_s - F_k) / (K V),  t_s = 2 sqrt(m/K) (pi - atan((F_s - F_k) / (V sqrt(K m))))
    """
    dwell = 2 * drop_n / (stiffness_n_m * speed_m_s)
    angle = atan(drop_n / (speed_m_s * sqrt(stiffness_n_m * MASS_KG)))
    return dwell, 2 * sqrt(MASS_KG / stiffness_n_m) * (pi - angle)


def measured_times(t_s: np.ndarray, v_m_s: np.ndarray, speed_m_s: float) -> tuple[float, float]:
    """Return the mean dwell and slip time [s] of a motion, without its first slip.

    It slips while it is faster than half the pull.
    """
    slips = np.diff((v_m_s > 0.5 * speed_m_s).astype(int))
    starts, ends = t_s[:-1][slips > 0], t_s[:-1][slips < 0]
    ends = ends[ends > starts[0]]
    n = min(len(starts), len(ends))
    starts, ends = starts[:n], ends[:n]
    return float(np.mean(starts[2:] - ends[1:-1])), float(np.mean(ends[1:] - starts[1:]))


# With viscous friction, so that there is a speed above which it slides evenly.
DAMPED = LUGRE._replace(viscous=600.0, bristle_damping=0.0)
STIFFNESS_N_M = 5e4


def critical_speed(stiffness_n_m: float, law: FrictionParameters) -> float:
    """Return the speed [m/s] above which even sliding is stable: Routh on linearised LuGre.

    m s^2 + (B + F_dry' / (1 + s tau)) s + K = 0,  tau = F_dry / (sigma_0 v)
    is stable where (m + B tau) (B + F_dry') + B K tau^2 > 0. Without sigma_1.
    """

    def margin(v: float) -> float:
        fallen = (law.stiction - law.coulomb) * np.exp(-v / law.stribeck_velocity)
        slope = -fallen / law.stribeck_velocity
        tau = (law.coulomb + fallen) / (law.bristle_stiffness * v)
        b, m = law.viscous, MASS_KG
        return (m + b * tau) * (b + slope) + b * stiffness_n_m * tau**2

    least = law.stribeck_velocity * np.log(
        (law.stiction - law.coulomb) / (law.viscous * law.stribeck_velocity)
    )
    if margin(least / 2) >= 0:
        return 0.0
    return float(brentq(margin, least / 2, 2 * least))


def growth(speed_m_s: float, stiffness_n_m: float, law: FrictionParameters) -> float:
    """Return the simulated growth rate [1/s] of a small disturbance of even sliding."""
    dry = law.coulomb + (law.stiction - law.coulomb) * np.exp(-speed_m_s / law.stribeck_velocity)
    dt, seconds = 2e-5, 4.0
    t = dt * np.arange(round(seconds / dt))
    pull = dry + law.viscous * speed_m_s + stiffness_n_m * speed_m_s * t
    moved = driven_mass(
        pull, stiffness_n_m, MASS_KG, dt, law, (1 + 1e-6) * speed_m_s, dry / law.bristle_stiffness
    )
    off = moved.v_m_s - speed_m_s
    half = len(off) // 2
    early, late = np.abs(off[half // 2 : half]).max(), np.abs(off[-half // 2 :]).max()
    return float(np.log(late / early) / (0.5 * seconds))


def stick_slip() -> Phenomenon:
    """Show the motion, its dwell and slip times, and the speed above which it ends."""
    speeds, stiffnesses = np.array([2e-3, 5e-3, 1e-2, 2e-2]), (2e4, 5e4)
    lines: dict[str, list[Line]] = {"dwell": [], "slip": []}
    findings = []
    fine = np.geomspace(speeds[0], speeds[-1], 40)
    for stiffness in stiffnesses:
        theory = np.array([_expected(v, stiffness) for v in fine])
        simulated = np.array([_dwell_and_slip(v, stiffness) for v in speeds])
        spring = f"{stiffness / 1e3:g} kN/m"
        for column, name in enumerate(lines):
            lines[name] += [
                line(f"{spring}, closed form", 1e3 * fine, theory[:, column]),
                line(f"{spring}, simulated", 1e3 * speeds, simulated[:, column], True),
            ]
        for v, times in zip(speeds, simulated, strict=True):
            for name, time, formula in zip(lines, times, _expected(v, stiffness), strict=True):
                findings.append(
                    Finding(
                        f"{name} time at {1e3 * v:g} mm/s, {spring}",
                        "s",
                        time,
                        formula,
                        "2 (F_b - F_C) / (K V)"
                        if name == "dwell"
                        else "2 sqrt(m/K) (pi - atan((F_b - F_C) / (V sqrt(K m))))",
                    )
                )
    even = critical_speed(STIFFNESS_N_M, DAMPED)
    onset = brentq(
        lambda v: growth(v, STIFFNESS_N_M, DAMPED), 0.85 * even, 1.15 * even, xtol=1e-5 * even
    )
    findings.append(
        Finding(
            "speed above which it slides evenly",
            "mm/s",
            1e3 * onset,
            1e3 * even,
            "Routh on the linearised law",
        )
    )
    t, v, force = pulled(5e-3, 2e4, STICK_SLIP, cycles=3.0)
    return Phenomenon(
        name="stick-slip",
        title="Stick-slip",
        text=(
            "A spring pulls a mass of 10 kg at a constant speed. It rests until the spring's force "
            "has reached breakaway F_b, slips faster than the spring's end, and rests again when "
            "the spring has been relieved by 2 (F_b - F_C). The dwell time falls with speed and "
            "stiffness; the slip time is half a period of mass and spring, and a little more.",
            "F_b is itself lower the faster the force rises (see 'breakaway'); the closed forms "
            "take it at the rate K V.",
            "With viscous friction there is a speed above which even sliding is stable. It lies "
            "below the minimum of the Stribeck curve, because the bristles delay the falling part.",
        ),
        panels=(
            Panel(
                "force",
                "The spring's force",
                "Time (s)",
                "Spring force (N)",
                (line("5 mm/s, 20 kN/m", t, force),),
            ),
            Panel(
                "velocity",
                "The mass",
                "Time (s)",
                "Velocity (mm/s)",
                (line("5 mm/s, 20 kN/m", t, 1e3 * v),),
            ),
            Panel(
                "dwell",
                "Time at rest",
                "Mean speed (mm/s)",
                "Dwell time (s)",
                tuple(lines["dwell"]),
                x_log=True,
                y_log=True,
            ),
            Panel(
                "slip",
                "Time of a slip",
                "Mean speed (mm/s)",
                "Slip time (s)",
                tuple(lines["slip"]),
                x_log=True,
            ),
        ),
        findings=tuple(findings),
    )


def _expected(speed_m_s: float, stiffness_n_m: float) -> tuple[float, float]:
    away = breakaway_by_formula(stiffness_n_m * speed_m_s, STICK_SLIP)
    return stick_slip_times(speed_m_s, stiffness_n_m, away - STICK_SLIP.coulomb)


def _dwell_and_slip(speed_m_s: float, stiffness_n_m: float) -> tuple[float, float]:
    t, v, _ = pulled(speed_m_s, stiffness_n_m, STICK_SLIP)
    return measured_times(t, v, speed_m_s)
