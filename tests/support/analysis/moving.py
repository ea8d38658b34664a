"""Runs with a changing velocity, made here at 10 kHz and averaged to 100 Hz records."""

import numpy as np

from hbench.records import Motion, Run, RunPlan, Segment, Specimen

SPECIMEN = Specimen(area_piston_m2=1.25e-3, area_rod_m2=0.75e-3, stroke_m=0.4)
TICK_S, TICKS = 1e-4, 100


def records(values):
    """Means over whole records."""
    whole = len(values) // TICKS * TICKS
    return np.asarray(values)[:whole].reshape(-1, TICKS).mean(axis=1)


def filtered(v, tau_s):
    """A first-order lag, exact for a straight v between ticks but for O(tick)."""
    out, state, part = np.empty(len(v)), v[0], 1 - np.exp(-TICK_S / tau_s)
    for i, value in enumerate(v):
        state += part * (value - state)
        out[i] = state
    return out


def moving_run(
    kind,
    v,
    friction,
    mass_kg=0.0,
    v_ref=None,
    load_n=2000.0,
    plan=None,
    v_board=None,
    x0=0.05,
    noise_n=0.0,
    seed=0,
    **changes,
) -> Run:
    """Return the log of velocity ``v`` and ``friction`` [N], both given each 100 us.

    F_T carries friction, load and the inertia of ``mass_kg``.
    """
    v = np.asarray(v, dtype=float)
    x = x0 + np.concatenate(([0.0], np.cumsum((v[1:] + v[:-1]) / 2 * TICK_S)))
    f_test = load_n + friction + mass_kg * np.gradient(v, TICK_S)
    n = len(records(v))
    noise = noise_n * np.random.default_rng(seed).standard_normal(n)
    p_tr = np.full(n, 20e5)
    reference = v if v_ref is None else v_ref
    return Run(
        plan=RunPlan(
            **{
                "run": "0001",
                "kind": kind,
                "trial": 1,
                "v_ref_m_s": float(max(reference, key=abs)),
                "specimen": SPECIMEN,
                "f_load_n": load_n,
            }
            | (plan or {})
        ),
        t_s=(np.arange(n) + 0.5) * TICK_S * TICKS,
        x_m=records(x),
        v_m_s=records(v if v_board is None else v_board),
        p_tp_pa=(records(f_test) + noise + p_tr * SPECIMEN.area_rod_m2) / SPECIMEN.area_piston_m2,
        p_tr_pa=p_tr,
        f_applied_n=np.full(n, load_n),
        v_ref_m_s=np.asarray(reference)[TICKS - 1 :: TICKS][:n],
        **{
            "sensor_saturated": np.zeros(n, bool),
            "valve_saturated": np.zeros(n, bool),
        }
        | changes,
    )


def ramp_velocity(a, top):
    return a * TICK_S * np.arange(round(top / a / TICK_S))


def triangle_velocity(a, top, cycles):
    """From rest to top, to -top and back to rest, ``cycles`` times."""
    quarter = top / a
    t = TICK_S * np.arange(round(4 * quarter * cycles / TICK_S))
    phase = (t / quarter) % 4
    return top * np.where(phase < 1, phase, np.where(phase < 3, 2 - phase, phase - 4))


def levels_velocity(levels, dwell_s):
    return np.repeat(levels, round(dwell_s / TICK_S))


def motion_of(segments=(), x_min=0.0, x_max=0.4):
    return Motion(0.05, x_min, x_max, 0.0, tuple(Segment(v, 1.0, 1.0) for v in segments))
