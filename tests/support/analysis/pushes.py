"""Made-up pushes: a force rises on a resting piston until it breaks away."""

import numpy as np

from hbench.records import Motion, Run, RunPlan, ScreenedRun, Segment, Specimen

SPECIMEN = Specimen(1.25e-3, 0.75e-3, 0.4)
RATE, LOAD, T = 500.0, 2000.0, 0.01


def push(peak_n, run=1, trial=1, dwell_s=1.0, sign=1.0, noise_n=0.0, after=None, ends_s=None):
    """Friction rises at the rate to its peak, falls to 60 % within a record, then rises slowly."""
    t = np.arange(0.0, peak_n / RATE + 0.5, T) + T / 2
    at = peak_n / RATE
    slid = 0.6 * peak_n + 150.0 * (t - at) if after is None else after + 0.0 * t
    friction = np.where(t < at, RATE * t, slid)
    friction += noise_n * np.random.default_rng(run).standard_normal(len(t))
    x = 0.2 + sign * np.where(t < at, 2e-4 * t / at, 2e-4 + 0.03 * (t - at))
    f_applied = np.full(len(t), sign * LOAD)
    p_tr = np.full(len(t), 20e5)
    p_tp = (f_applied + sign * friction + p_tr * SPECIMEN.area_rod_m2) / SPECIMEN.area_piston_m2
    segment = Segment(0.0, 1.0, ends_s or 8.0, force_rate_n_s=sign * RATE, displacement_m=0.01)
    plan = RunPlan(
        f"{run:04d}", "breakaway", trial, 0.0, SPECIMEN, f_load_n=sign * LOAD, p_lr_ref_pa=15e5,
        motion=Motion(0.2, 0.2, 0.2, dwell_s, (segment,)), force_rate_n_s=sign * RATE,
        dwell_s=dwell_s,
    )  # fmt: skip
    return Run(plan, t, x, p_tp_pa=p_tp, p_tr_pa=p_tr, f_applied_n=f_applied)


def accepted(*runs):
    return [ScreenedRun(run, (), None) for run in runs]
