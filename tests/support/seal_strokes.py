"""Made-up cyclic strokes of a seal at several pressures, with a known friction law, as an import.

One direction of a cycle: a ramp of RAMP_S to the speed, constant speed, a ramp down, a pause. The
friction is +-half + middle + VISCOUS v, and MASS_KG a acts on the load cell too.
"""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import yaml

from hbench import workflow

BORE_M = 0.025
AREA_M2 = np.pi / 4 * BORE_M**2
STROKE_M, RAMP_S, PAUSE_S = 0.04, 0.2, 0.25
VISCOUS, MASS_KG = 20.0, 2.0  # N s/m, kg
MAP = {
    "name": "made-up strokes",
    "kind": "steady",
    "columns": {
        "t_s": {"column": "t", "unit": "s"},
        "x_m": {"column": "x", "unit": "mm"},
        "p_tp_pa": {"column": "p", "unit": "bar"},
        "f_applied_n": {"column": "F", "unit": "N"},
    },
    "constants": {"p_tr_pa": "0 bar"},
    "cut": "reversals",
    "min_stroke": "20 mm",
    "screening": {"settle_travel": "5 mm", "friction_drift": "10 N"},
}


def energy_j(half_n: float, v_m_s: float) -> float:
    """Energy of a cycle: middle and inertia do no work, 2 (half L + VISCOUS integral of v^2 dt)."""
    at_speed = STROKE_M / v_m_s - RAMP_S
    return 2 * (half_n * STROKE_M + VISCOUS * v_m_s**2 * (at_speed + 2 / 3 * RAMP_S))


def half_band_n(half_n: float, v_m_s: float) -> float:
    """Half band at constant speed."""
    return half_n + VISCOUS * v_m_s


def motion(v_m_s: float, cycles: int, rate_hz: float) -> tuple[np.ndarray, ...]:
    """Time, position, velocity and acceleration of ``cycles``, each beginning with an extension."""
    at_speed = STROKE_M / v_m_s - RAMP_S
    knots = np.cumsum([0, PAUSE_S, RAMP_S, at_speed, RAMP_S])
    period = knots[-1]
    t = np.arange(round((2 * cycles * period + PAUSE_S) * rate_hz)) / rate_hz
    number, phase = np.divmod(t, period)
    out = np.where(number % 2 == 0, 1.0, -1.0)
    speed = np.interp(phase, knots, [0, 0, v_m_s, v_m_s, 0])
    a = np.select([(phase > knots[1]) & (phase < knots[2]), phase > knots[3]], [1.0, -1.0], 0.0) * (
        v_m_s / RAMP_S
    )
    a[number >= 2 * cycles] = speed[number >= 2 * cycles] = 0.0
    up = np.clip(phase - knots[1], 0, RAMP_S)
    down = np.clip(phase - knots[3], 0, RAMP_S)
    way = v_m_s * (up**2 / (2 * RAMP_S) + np.clip(phase - knots[2], 0, at_speed + RAMP_S))
    way -= v_m_s * down**2 / (2 * RAMP_S)
    x = np.where(out > 0, way, STROKE_M - way)
    x[number >= 2 * cycles] = 0.0
    return t, x, out * speed, out * a


def write_strokes(
    folder: Path,
    label: str,
    bands: dict[float, tuple[float, float]],
    v_m_s: float = 0.02,
    cycles: int = 5,
    scatter_n: float = 0.0,
    rate_hz: float = 200.0,
    seed: int = 0,
) -> Path:
    """Write a log for each pressure of ``bands`` {bar: (half, middle) [N]} and the map.

    ``scatter_n`` is the standard deviation of half band and middle from cycle to cycle.
    """
    rng = np.random.default_rng(seed)
    folder.mkdir(parents=True)
    for bar, (half, middle) in bands.items():
        t, x, v, a = motion(v_m_s, cycles, rate_hz)
        cycle = np.minimum((t / (t[-1] + 1e-9) * cycles).astype(int), cycles - 1)
        halves = half + scatter_n * rng.standard_normal(cycles)
        middles = middle + scatter_n * rng.standard_normal(cycles)
        friction = np.sign(v) * halves[cycle] + middles[cycle] + VISCOUS * v
        force = bar * 1e5 * AREA_M2 - friction - MASS_KG * a
        rows = np.column_stack([t, 1e3 * x, np.full(len(t), bar), force])
        np.savetxt(
            folder / f"{label}_{bar:g}bar.csv", rows, "%.9g", ",", header="t,x,p,F", comments=""
        )
    series = {
        "label": label,
        "files": f"{label}_{{pressure}}bar.csv",
        "cylinder": {"piston_diameter": f"{1e3 * BORE_M:g} mm"},
    }
    (folder / "map.yaml").write_text(yaml.safe_dump(MAP | {"series": [series]}))
    return folder


def stroke_campaign(logs: Path, campaign: Path) -> Path:
    """Import the logs of ``write_strokes``."""
    clock = lambda: datetime(2026, 1, 1, tzinfo=UTC)  # noqa: E731
    workflow.import_runs(logs, campaign, logs / "map.yaml", clock)
    return campaign
