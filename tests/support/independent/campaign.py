"""A campaign of the independent bench: logs as its own logger writes them, map and model file."""

from pathlib import Path

import numpy as np
import yaml

from tests.support.independent.bench import BAR, MASS_LOAD_KG, MASS_TEST_KG, Bench, Effects, stroke

# Pressure references of the load cylinder's piston and rod side, in bar: from -2 to 13 kN.
LOADS_BAR = ((30, 40), (40, 40), (50, 40), (30, 48), (50, 65))
SPEEDS_MM_S = (10, 25, 60, 120, 180)
_TRAVEL_M, _SLOW_TRAVEL_M = (0.05, 0.43), 0.04
_HEAD = "Time;Pos;Vel;pA;pB;pC;pD;pP;F;Y1;Y2;Y3\ns;mm;mm/s;bar;bar;bar;bar;bar;kN;%;%;%\n"
_UNITS = np.array([1.0, 1e3, 1e3, *[1 / BAR] * 5, 1e-3, 10.0, 10.0, 10.0])  # 10 V is 100 %
_PRESSURE_STEP_PA, _FORCE_STEP_N = 250e5 / 2**14, 40e3 / 2**14

# What a user of this bench knows, with a friction that he guesses.
MODEL = {
    "test_cylinder": {
        "piston_diameter": "63 mm",
        "rod_diameter": "45 mm",
        "stroke": "500 mm",
        "dead_volume_piston": "300 cm^3",
        "dead_volume_rod": "320 cm^3",
    },
    "load_cylinder": {
        "piston_diameter": "80 mm",
        "rod_diameter": "50 mm",
        "stroke": "500 mm",
        "dead_volume_piston": "350 cm^3",
        "dead_volume_rod": "300 cm^3",
        "offset": "0 mm",
    },
    "moving_mass": {"test": f"{MASS_TEST_KG} kg", "load": f"{MASS_LOAD_KG} kg"},
    "oil": {"bulk_modulus": "7000 bar", "density": "870 kg/m^3"},
    "supply": {"pressure": "120 bar", "tank": "1.5 bar"},
    "valve": {"gain": "1.25e-6 m^2/V", "bandwidth": "70 Hz", "damping": 0.7, "limit": "10 V"},
    "friction": {
        "test": {
            "law": "lugre",
            "coulomb": "150 N",
            "stiction": "340 N",
            "stribeck_velocity": "40 mm/s",
            "stribeck_exponent": 1,
            "viscous": "3000 N s/m",
            "bristle_stiffness": "6e5 N/m",
            "bristle_damping": "0 N s/m",
        },
        "load": {
            "law": "lugre",
            "coulomb": "200 N",
            "stiction": "320 N",
            "stribeck_velocity": "50 mm/s",
            "stribeck_exponent": 1,
            "viscous": "2600 N s/m",
            "bristle_stiffness": "6e5 N/m",
            "bristle_damping": "0 N s/m",
        },
    },
    "end_stop": {"stiffness": "2e7 N/m", "damping": "2e4 N s/m"},
}

MAP = {
    "name": "independent bench",
    "kind": "steady",
    "format": {"separator": "semicolon", "units_row": True},
    "columns": {
        "t_s": {"column": "Time"},
        "x_m": {"column": "Pos"},
        "v_m_s": {"column": "Vel"},
        "p_tp_pa": {"column": "pA"},
        "p_tr_pa": {"column": "pB"},
        "p_lp_pa": {"column": "pC"},
        "p_lr_pa": {"column": "pD"},
        "p_s_pa": {"column": "pP"},
        "f_applied_n": {"column": "F"},
        "u_t_v": {"column": "Y1", "unit": "V", "scale": 0.1},
        "u_l1_v": {"column": "Y2", "unit": "V", "scale": 0.1},
        "u_l2_v": {"column": "Y3", "unit": "V", "scale": 0.1},
    },
    "series": [
        {
            "label": "bench",
            "files": "v{speed}_lp{lp}_lr{lr}_{trial}.csv",
            "cylinder": {"piston_diameter": "63 mm", "rod_diameter": "45 mm", "stroke": "500 mm"},
            "factors": {"lp": "bar", "lr": "bar"},
        }
    ],
    "instruments": {
        "force": {"tolerance": "0.1 %", "of": "full_scale", "full_scale": "20 kN"},
        "pressure": {"tolerance": "0.25 %", "of": "full_scale", "full_scale": "250 bar"},
    },
}


def write_campaign(
    out: Path,
    effects: Effects,
    seed: int,
    speeds_mm_s: tuple[int, ...] = SPEEDS_MM_S,
    loads_bar: tuple[tuple[int, int], ...] = LOADS_BAR,
    trials: int = 3,
) -> None:
    """Write ``logs/``, ``map.yaml`` and ``model.yaml`` of a campaign with hidden effects."""
    rng = np.random.default_rng([seed, 5])
    bench = Bench(
        gains=_about(rng, 6e-8, 3),
        nulls_v=tuple(rng.uniform(-0.04, 0.04, 3).tolist()),
        edges=tuple(np.random.default_rng([seed, 6]).uniform(-0.03, 0.03, 2).tolist()),
        volumes_m3=tuple((np.array([3e-4, 3.2e-4, 3.5e-4, 3e-4]) * _about(rng, 1.0, 4)).tolist()),
        spool_rad_s=_about(rng, 440.0, 1)[0],
        bulk_modulus_pa=_about(rng, 8e8, 1)[0],
    )
    offset_pa, drift_pa = rng.uniform(-0.1, 0.1, 5) * BAR, rng.uniform(-0.05, 0.05, 5) * BAR
    offset_pa[0] += effects.offset_pa
    plan = [
        (speed, load, trial)
        for trial in range(1, trials + 1)
        for load in loads_bar
        for speed in speeds_mm_s
    ]
    rng.shuffle(plan)
    (out / "logs").mkdir(parents=True)
    wander = np.zeros(2)
    for i, (speed, (p_lp, p_lr), trial) in enumerate(plan):
        for sign in (1, -1):
            wander = 0.8 * wander + 0.6 * rng.uniform(-0.03, 0.03, 2)
            low, high = _TRAVEL_M
            if speed < 30:
                low = rng.uniform(0.1, 0.3)
                high = low + _SLOW_TRAVEL_M
            start, end = (low, high) if sign > 0 else (high, low)
            v = 1e-3 * speed
            duration_s = 1.2 + (high - low) / v + v / 0.3
            levels = tuple((np.array([1.08, 0.93]) * (1 + wander)).tolist())
            log = stroke(bench, effects, start, end, v, p_lp * BAR, p_lr * BAR, levels, duration_s)
            errors = offset_pa + drift_pa * i / len(plan)
            name = f"v{sign * speed}_lp{p_lp}_lr{p_lr}_{trial}.csv"
            _write(out / "logs" / name, _logged(log, errors, effects, rng))
    (out / "map.yaml").write_text(yaml.safe_dump(MAP))
    (out / "model.yaml").write_text(yaml.safe_dump(MODEL))


def _about(rng: np.random.Generator, value: float, count: int) -> tuple[float, ...]:
    """Draw values within 5 % of one."""
    return tuple((value * (1 + rng.uniform(-0.05, 0.05, count))).tolist())


def _logged(
    log: np.ndarray, errors_pa: np.ndarray, effects: Effects, rng: np.random.Generator
) -> np.ndarray:
    """Add the sensors' noise, errors and resolution."""
    log = log.copy()
    log[:, 3] *= 1 + effects.pressure_gain
    scatter = [0.0, 2e-6, 2e-4, *[0.012 * BAR] * 5, 2.0, 0.0, 0.0, 0.0]
    shown = log + scatter * rng.standard_normal(log.shape)
    shown[:, 3:8] = np.round((shown[:, 3:8] + errors_pa) / _PRESSURE_STEP_PA) * _PRESSURE_STEP_PA
    shown[:, 8] = np.round(shown[:, 8] * (1 + effects.cell_gain) / _FORCE_STEP_N) * _FORCE_STEP_N
    return shown


def _write(path: Path, log: np.ndarray) -> None:
    with path.open("w") as file:
        file.write(_HEAD)
        np.savetxt(file, log * _UNITS, fmt="%.6g", delimiter=";")
