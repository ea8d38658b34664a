"""Logs of known motion, from any bench: good runs are accepted, bad ones rejected for their cause.

The generator shares nothing with the search for the steady window: corners of a velocity profile,
exact positions, sensor noise, resolution and drift, rests, and one cause of rejection or none.
"""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hbench.analysis.screening.screen import screen
from hbench.config.schedule import Screening
from hbench.records import Run, RunPlan, Specimen

SPECIMEN = Specimen(area_piston_m2=1.25e-3, area_rod_m2=0.75e-3)
RULES = Screening()
MASS_KG = 8.0
PERIOD_S = 0.5  # of stick-slip; at 20 Hz a faster one looks like noise
# Which codes are a true answer to what is wrong with a log.
CODES = {
    "nothing": set(),
    "stops early": {"too_short"},
    "another speed": {"off_reference"},
    "stick-slip": {"not_steady", "off_reference"},
    "friction drifts": {"not_steady"},
    "load comes late": {"not_steady"},
    "gap": {"gapped"},
}


@dataclass(frozen=True)
class Log:
    run: Run
    plateau_s: tuple[float, float]


def profile(corners, t):
    """Return position and velocity of a velocity profile with corners (time, speed)."""
    times, speeds = (np.array(values, dtype=float) for values in zip(*corners, strict=True))
    v = np.interp(t, times, speeds)
    steps = np.diff(times) * (speeds[1:] + speeds[:-1]) / 2
    at_corners = np.concatenate(([0.0], np.cumsum(steps)))
    i = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(times) - 2)
    return at_corners[i] + (t - times[i]) * (speeds[i] + v) / 2, v


def log(cause, v, rate_hz, rests, noise_m, step_m, seed, uneven):
    rng = np.random.default_rng(seed)
    speed, a, actual = abs(v), 1.0, v
    if cause == "another speed":
        error = max(0.12, 1.5 * RULES.speed_limit(v) / speed) * rng.uniform(1, 2)
        actual = v * (1 + error * (rng.choice([-1, 1]) if error < 0.5 else 1))
    settled = max(RULES.settle_time, RULES.settle_travel / abs(actual))
    hold = settled + (6 * PERIOD_S if cause == "stick-slip" else 0.6) + 6 / rate_hz
    if cause == "stops early":
        hold = 0.5 * settled
    reached = rests[0] + speed / a
    corners = [(0, 0), (rests[0], 0), (reached, actual), (reached + hold, actual)]
    corners += [(reached + hold + speed / a, 0), (reached + hold + speed / a + rests[1] + 1e-9, 0)]
    n = int(corners[-1][0] * rate_hz)
    t = np.arange(n) / rate_hz
    if uneven:
        t = t + rng.uniform(-0.3, 0.3, n) / rate_hz
    x, v_t = profile(corners, t)
    inside = (t > reached) & (t < reached + hold)
    if cause == "stick-slip":
        moving = np.where(inside, 0.9 * np.sin(2 * np.pi * (t - reached) / PERIOD_S), 0.0)
        x = x + np.concatenate(([0], np.cumsum(np.diff(t) * actual * moving[1:])))
    acceleration = np.gradient(v_t, t)
    friction = np.sign(v_t) * (250 + 150 * np.exp(-np.abs(v_t) / 0.05)) + 1500 * v_t
    friction = np.where(np.abs(v_t) > 1e-6, friction, 0.0)
    load = np.full(n, 2000.0)
    start = reached + settled
    if cause == "friction drifts":
        friction = friction + np.sign(v) * np.clip((t - start) / 0.6, 0, 1) * 600
    if cause == "load comes late":
        load = np.where(t < start + 0.25, 0.0, 2000.0)
    p_tr = 20e5 + 2e3 * rng.standard_normal(n)
    force = load + friction + MASS_KG * acceleration
    p_tp = (force + p_tr * SPECIMEN.area_rod_m2) / SPECIMEN.area_piston_m2
    x = 0.1 + x + noise_m * rng.standard_normal(n)
    x = np.rint(x / step_m) * step_m if step_m else x
    kept = np.ones(n, dtype=bool)
    if cause == "gap":
        kept = (t < start + 0.2) | (t > start + 0.2 + max(0.2, 3 / rate_hz))
    plan = RunPlan(run="0001", kind="steady", trial=1, v_ref_m_s=v, specimen=SPECIMEN)
    channels = {
        "t_s": t,
        "x_m": x,
        "p_tp_pa": p_tp + 2e3 * rng.standard_normal(n),
        "p_tr_pa": p_tr,
        "f_applied_n": load + 2 * rng.standard_normal(n),
    }
    run = Run(plan=plan, **{name: values[kept] for name, values in channels.items()})
    return Log(run, (reached, reached + hold))


@settings(max_examples=150, deadline=None)
@given(
    cause=st.sampled_from(sorted(CODES)),
    v=st.floats(np.log(1e-3), np.log(0.5)).map(lambda x: float(np.exp(x))),
    sign=st.sampled_from([-1, 1]),
    rate=st.sampled_from([20, 50, 100, 500, 2000, 10_000]),
    rests=st.tuples(*2 * [st.sampled_from([0.0, 0.4, 3.0, 30.0])]),
    noise=st.sampled_from([0.0, 5e-6, 2e-5]),
    step=st.sampled_from([0.0, 1e-5]),
    seed=st.integers(0, 10**6),
    uneven=st.booleans(),
)
def test_good_runs_are_accepted_and_bad_ones_rejected_for_their_cause(
    cause, v, sign, rate, rests, noise, step, seed, uneven
):
    if cause == "stick-slip":  # slower, it is within the limit of 2 mm/s
        v = min(max(v, 0.005), 0.1)
    rate = min(rate, 500) if 0.02 / v + sum(rests) > 8 else rate
    made = log(cause, sign * v, rate, rests, noise, step, seed, uneven)
    found = screen(made.run, RULES)
    codes = {reason.split(":")[0] for reason in found.reasons}
    # Unsteady and interrupted motions leave little steady time, which is true too.
    also = {"too_short"} if cause in ("gap", "stick-slip") else set()
    assert bool(codes & CODES[cause]) == bool(CODES[cause]), found.reasons
    assert codes <= CODES[cause] | also, found.reasons
    if not codes:
        truth = sign * (250 + 150 * np.exp(-v / 0.05) + 1500 * v)
        assert found.means.friction_n == pytest.approx(truth, abs=6 + 0.02 * abs(truth))
        assert found.means.v_m_s == pytest.approx(sign * v, rel=0.02, abs=1e-4)
