"""Steady runs of a cylinder while its oil warms, as arrays: no board, no plant.

Unlike the reduction's assumptions, the viscosity follows Vogel's equation through three printed
viscosities (G. W. Stachowiak, A. W. Batchelor, Engineering Tribology, 2nd ed., table 2.3: a machine
oil of 153, 34 and 9.1 mPa s at 30, 60 and 100 degC), the dry friction falls with the temperature by
itself, and the scatter of the trials and the error of the sensor are drawn.
"""

from dataclasses import dataclass

import numpy as np

from hbench.config.oil.record import OilRecord
from hbench.records import Run, RunPlan, ScreenedRun, Specimen, SteadyMeans

ZERO_K = 273.15
SPEEDS = np.array([5, 10, 20, 35, 50, 65, 80, 100, 120, 140, 160, 180, 190, 195, 200]) * 1e-3
RUN_S = 5.0  # from the start of one run to that of the next: 90 runs take 7.5 min
PRINTED = {30.0: 0.153, 60.0: 0.034, 100.0: 0.0091}  # Pa s at degC


def vogel(temp_k):
    """eta = a exp(b / (T - c)) [Pa s] through the printed values."""
    (t_1, e_1), (t_2, e_2), (t_3, e_3) = ((t + ZERO_K, np.log(e)) for t, e in PRINTED.items())
    q = (e_1 - e_2) / (e_2 - e_3) * (t_3 - t_2) / (t_2 - t_1)  # = (t_3 - c) / (t_1 - c)
    c = (t_3 - q * t_1) / (1 - q)
    b = (e_1 - e_2) / (1 / (t_1 - c) - 1 / (t_2 - c))
    return np.exp(e_1 + b * (1 / (temp_k - c) - 1 / (t_1 - c)))


def data_sheet():
    """The oil's record as a data sheet states it: kinematic, at 40 and 100 degC; 880 kg/m^3."""
    points = {}
    for celsius in (40.0, 100.0):
        density = 880.0 / (1 + 7e-4 * (celsius - 15))
        points[f"{celsius} degC"] = f"{1e6 * vogel(celsius + ZERO_K) / density} mm^2/s"
    return OilRecord(grade="made", viscosity=points, density="880 kg/m^3")


@dataclass(frozen=True)
class Friction:
    """Friction against the motion [N] over speed and temperature."""

    viscous_n_s_m: float = 2400.0  # at 40 degC, table 6.5: 2331
    coulomb_n: float = 150.0
    stribeck_n: float = 200.0
    stribeck_m_s: float = 0.03
    dry_per_k: float = 0.0  # share of the dry friction that it falls by with each K
    film: bool = False  # friction is one function of eta v: the Stribeck curve shifts too

    def __call__(self, v_m_s, temp_k):
        ratio = vogel(temp_k) / vogel(40 + ZERO_K)
        duty = v_m_s * ratio if self.film else v_m_s
        dry = self.coulomb_n + self.stribeck_n * np.exp(-duty / self.stribeck_m_s)
        dry *= 1 - self.dry_per_k * (temp_k - 40 - ZERO_K)
        return dry + self.viscous_n_s_m * ratio * v_m_s


def order_of(name, rng, speeds=SPEEDS, trials=3):
    """(speed, trial) of both directions: "experiments" in rows of rising speed, or "random"."""
    points = [*speeds, *-speeds]
    if name == "experiments":
        return [(v, trial) for v in points for trial in range(1, trials + 1)]
    return [(v, trial) for trial in range(1, trials + 1) for v in rng.permutation(points)]


def warming(seconds, from_c=34.0, by_k=25.0, tau_s=300.0):
    """Oil temperature [K] after ``seconds``."""
    return from_c + ZERO_K + by_k * (1 - np.exp(-seconds / tau_s))


def warm_runs(order, friction, rng, temperature=warming, scatter=0.015, sensor_k=0.3):
    """Accepted runs in ``order`` with a tank sensor; the scatter is a share of friction."""
    runs = []
    for number, (v, trial) in enumerate(order):
        temp_k = float(temperature(RUN_S * number))
        magnitude = friction(abs(v), temp_k) * (1 + scatter * rng.standard_normal())
        force = float(np.sign(v) * magnitude)
        plan = RunPlan(f"{number:04d}", "steady", trial, float(v), Specimen(1.26e-3, 7.7e-4))
        means = SteadyMeans(
            0.0, 1.0, 100, float(v), force, force, 0.0, 6e6, 2e6,
            temp_tank_k=temp_k + sensor_k * rng.standard_normal(),
        )  # fmt: skip
        runs.append(ScreenedRun(Run(plan, np.zeros(0), np.zeros(0)), (), means))
    return runs


MAP = """
name: seal test stand
columns:
  t_s: {column: t, unit: s}
  x_m: {column: x, unit: mm}
  p_tp_pa: {column: p_A, unit: bar}
  p_tr_pa: {column: p_B, unit: bar}
  f_applied_n: {column: F, unit: N}
  temp_tank_k: {column: T_oil, unit: degC}
series:
  - label: NBR
    files: "*_{speed}mms_{trial}.csv"
    cylinder: {piston_diameter: 40 mm, rod_diameter: 25 mm}
"""
RATE_HZ, LOAD_N = 100.0, 1000.0


def write_logs(folder, order, friction, rng, temperature=warming, scatter=0.015):
    """Write a log of each run: constant speed, constant load, the temperature in degC."""
    folder.mkdir(parents=True, exist_ok=True)
    area_p, area_r = np.pi / 4 * 0.040**2, np.pi / 4 * (0.040**2 - 0.025**2)
    for number, (v, trial) in enumerate(order):
        t = np.arange(0, np.clip(0.03 / abs(v), 1.5, 6.0), 1 / RATE_HZ)
        temp_k = temperature(RUN_S * number)
        force = np.sign(v) * friction(abs(v), temp_k) * (1 + scatter * rng.standard_normal())
        load = LOAD_N + 1.0 * rng.standard_normal(len(t))
        p_tr = 20e5
        p_tp = (load + force + p_tr * area_r) / area_p
        columns = {
            "t": t,
            "x": 1e3 * ((0.0 if v > 0 else 0.4) + v * t + 1e-6 * rng.standard_normal(len(t))),
            "p_A": 1e-5 * p_tp + 1e-3 * rng.standard_normal(len(t)),
            "p_B": np.full(len(t), 1e-5 * p_tr) + 1e-3 * rng.standard_normal(len(t)),
            "F": load,
            "T_oil": np.round(temp_k - ZERO_K + 0.05 * rng.standard_normal(len(t)), 1),
        }
        rows = [
            ",".join(columns),
            *(",".join(f"{x:.6g}" for x in row) for row in zip(*columns.values(), strict=True)),
        ]
        (folder / f"{number:04d}_{1e3 * v:g}mms_{trial}.csv").write_text("\n".join(rows) + "\n")
