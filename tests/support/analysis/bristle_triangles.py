"""Triangles of velocity on a made-up bench without hydraulics: bristles, drive, noisy position.

Nothing of hbench's plant or its integration is used: the piston's motion is prescribed, and the
bristles (Dahl's, with a slip force that falls with speed) are integrated exactly in steps of
0.25 ms, in which the velocity is constant.
"""

from math import copysign, exp

import numpy as np

from hbench.records import Run, RunPlan, Specimen

TRUTH = {
    "f_coulomb_n": 300.0,
    "f_stiction_n": 450.0,
    "v_stribeck_m_s": 0.018,
    "b_viscous_n_s_m": 1500.0,
}
MASS_KG = 5.0
DT_S = 0.005
_STEP_S = 2.5e-4
_STIFFNESS_N_M = 1.2e6
_REST_S = 0.6
_TRIANGLES = ((0.02, 0.04), (0.04, 0.1), (0.08, 0.2), (0.08, 0.1))  # peak [m/s], slope [m/s^2]
_FORCE_NOISE_N = 3.0
_SCATTER = 0.01  # of the friction of a run
_SPECIMEN = Specimen(area_piston_m2=1.25e-3, area_rod_m2=0.75e-3, stroke_m=0.4)


def campaign(noise_m, seed, stiffness_n_m=_STIFFNESS_N_M, unlike=False):
    """Eight runs at 200 Hz: four triangles, two trials each, with rests at both ends.

    ``unlike`` a fit's law, the slip force falls as 1 / (1 + (v / v_s)^2) (Hess and Soom), and the
    noise of the position is uniform.
    """
    rng = np.random.default_rng(seed)
    return [
        _run(number, *triangle, noise_m, rng, stiffness_n_m, unlike)
        for number, triangle in enumerate(each for each in _TRIANGLES for _ in range(2))
    ]


def _run(number, peak, slope, noise_m, rng, stiffness_n_m, unlike):
    corners = [0.0, _REST_S, *(_REST_S + (k + 1) * peak / slope for k in range(12))]
    speeds = [0.0, 0.0, *([peak, 0.0, -peak, 0.0] * 3)]
    t = np.arange(0.0, corners[-1] + _REST_S, _STEP_S)
    v = np.interp(t, corners, speeds)
    level = 1 + _SCATTER * rng.standard_normal()
    force = _friction(v, level, stiffness_n_m, unlike) + MASS_KG * np.gradient(v, _STEP_S)
    samples = round(DT_S / _STEP_S)
    count = len(t) // samples
    t, x, force = (
        each[: count * samples].reshape(count, samples).mean(axis=1)
        for each in (t, 0.1 + np.cumsum(v) * _STEP_S, force)
    )
    noise = rng.uniform(-(3**0.5), 3**0.5, count) if unlike else rng.standard_normal(count)
    return Run(
        plan=RunPlan(
            run=f"{number:04d}", kind="verification", trial=1, v_ref_m_s=peak, specimen=_SPECIMEN
        ),
        t_s=t,
        x_m=x + noise_m * noise,
        f_applied_n=np.zeros(count),
        f_drive_n=force + _FORCE_NOISE_N * rng.standard_normal(count),
    )


def _friction(v, level, stiffness_n_m, unlike):
    """Force of the bristles and the oil (n,)."""
    dry = TRUTH["f_stiction_n"] - TRUTH["f_coulomb_n"]
    slow = np.abs(v) / TRUTH["v_stribeck_m_s"]
    slip = level * (TRUTH["f_coulomb_n"] + dry * (1 / (1 + slow**2) if unlike else np.exp(-slow)))
    force, out = 0.0, []
    for speed, limit in zip(v.tolist(), slip.tolist(), strict=True):
        end = copysign(limit, speed)
        force = end + (force - end) * exp(-stiffness_n_m * abs(speed) * _STEP_S / limit)
        out.append(force)
    return np.array(out) + TRUTH["b_viscous_n_s_m"] * v
