"""Residuals of the measured runs themselves, whose trials need not begin at the same moment.

A run's windows are compared with a model that is evaluated along the same log, so nothing is
averaged over the trials. The scatter of a balance is that of a single window:

    s^2 = variance of a window for itself
          + variance of the runs' means between the trials of an operating point

The first is the smaller of two estimates, of the median run, as a gap is in some runs only: half
the mean of (r_i - r_(i+2))^2 within a run, windows that share no sample, and the same between the
windows of two trials, less their mean. Each contains more than noise where the other does not: what
is fast, and trials that begin at different moments.

Runs of an operating point that do not move alike, as under random steps, are no trials here: the
model's error differs between them and would raise the scatter that it is compared with.
"""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.special import fdtrc

from hbench.analysis.rounding import ROUNDING, ranked
from hbench.analysis.statistics.holm import holm
from hbench.reconcile.gaps.gap_map import GapMap, column_means
from hbench.reconcile.measured.balances import FLOWS
from hbench.records import Gap
from hbench.records.reconcile.diagnosis import REST_M_S, SIGNIFICANT_P, UNEXPLAINED_GAP

_APART = 2  # windows
_BLOCK = 4  # windows; those of a block may share samples with two of the next one
_ALIKE = 0.8  # correlation of the velocities of two trials
_IRREGULAR = 3.0  # times what is material
_DEPENDENT = 0.1  # share of the largest function of the motion: a smaller one shows little alone


@dataclass(frozen=True)
class Windows:
    """Windows of all runs, w in all."""

    run: np.ndarray  # (w,) index of the run
    points: tuple[Hashable, ...]  # of the runs, see ``point_of``
    t_s: np.ndarray  # (w,) since the run's start
    x_m: np.ndarray  # (w,)
    v_m_s: np.ndarray  # (w,)
    load_n: np.ndarray  # (w,)


def log_map(
    windows: Windows, names: tuple[str, ...], values: np.ndarray, resolution: np.ndarray
) -> GapMap:
    """Return the map of the residuals ``values`` (w, c); ``resolution`` (c,) is their rounding."""
    keys = tuple(dict.fromkeys(windows.points))
    point_of_run = np.array([keys.index(point) for point in windows.points])
    trials = like_runs(windows.run, point_of_run, windows.v_m_s)
    noise = _noise(values, windows.run, trials) + resolution**2
    scatter = np.sqrt(noise + between_runs(values, windows.run, trials))
    scatter = np.where(scatter > 0, scatter, np.nan)
    return GapMap(
        names=names,
        difference=values,
        scatter=np.tile(scatter, (len(values), 1)),
        noise=np.tile(scatter**2, (len(values), 1)),
        t_s=windows.t_s,
        x_m=windows.x_m,
        v_m_s=windows.v_m_s,
        load_n=windows.load_n,
        point=point_of_run[windows.run],
        points=keys,
        run=windows.run,
        white=noise / scatter**2,
    )


def like_runs(run: np.ndarray, point_of_run: np.ndarray, v_m_s: np.ndarray) -> np.ndarray:
    """Return an index (r,) that is the same for runs of an operating point that move alike.

    ``v_m_s`` (w,) is at the windows of the runs ``run`` (w,). The first run of a point is that with
    which the others are compared.
    """
    moving = np.where(np.abs(v_m_s) > REST_M_S, v_m_s, 0.0)
    motions = np.split(moving, np.flatnonzero(np.diff(run)) + 1)
    groups = np.arange(len(point_of_run))
    for point in np.unique(point_of_run):
        first, *others = np.flatnonzero(point_of_run == point)
        for other in others:
            if _move_alike(motions[first], motions[other]):
                groups[other] = first
    return groups


def _move_alike(one: np.ndarray, other: np.ndarray) -> bool:
    """Return whether two velocities are alike, one of them shifted in time."""
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    return size == 0.0 or float(np.correlate(one, other, "full").max()) > _ALIKE * size


def _noise(values: np.ndarray, run: np.ndarray, trials_of_run: np.ndarray) -> np.ndarray:
    """Return the variance (c,) that a window has for itself; see above."""
    runs = np.split(values, np.flatnonzero(np.diff(run)) + 1)
    inside = [
        0.5 * column_means((own[_APART:] - own[:-_APART]) ** 2) for own in runs if len(own) > _APART
    ]
    between = []
    for each in np.unique(trials_of_run):
        trials = [runs[i] for i in np.flatnonzero(trials_of_run == each)]
        for first, second in pairwise(trials):
            m = min(len(first), len(second))
            difference = first[:m] - second[:m]
            between.append(0.5 * column_means((difference - column_means(difference)) ** 2))
    estimates = [_median(np.array(each)) for each in (inside, between) if each]
    return np.fmin.reduce(estimates)


def _median(variances: np.ndarray) -> np.ndarray:
    """Return the median (c,) of the finite variances (k, c); nan without any."""
    median = np.full(variances.shape[1], np.nan)
    compared = np.isfinite(variances).any(axis=0)
    median[compared] = np.nanmedian(variances[:, compared], axis=0)
    return median


def between_runs(values: np.ndarray, run: np.ndarray, point_of_run: np.ndarray) -> np.ndarray:
    """Return the variance (c,) between the means of an operating point's runs; 0 without."""
    means = _run_means(values, run, len(point_of_run))
    squares, dof = np.zeros(values.shape[1]), np.zeros(values.shape[1])
    for point in np.unique(point_of_run):
        own = means[point_of_run == point]
        centred = own - column_means(own)
        squares += np.nansum(centred**2, axis=0)
        dof += np.maximum(np.isfinite(own).sum(axis=0) - 1, 0)
    return squares / np.maximum(dof, 1)


def _run_means(values: np.ndarray, run: np.ndarray, runs: int) -> np.ndarray:
    """Return the means (runs, c) of each run's windows; nan where nothing is compared."""
    usable = np.isfinite(values)
    sums, counts = np.zeros((runs, values.shape[1])), np.zeros((runs, values.shape[1]))
    np.add.at(sums, run, np.where(usable, values, 0.0))
    np.add.at(counts, run, usable)
    with np.errstate(invalid="ignore"):
        return sums / np.where(counts > 0, counts, np.nan)


def expected_square(residuals: GapMap) -> np.ndarray:
    """Return the expected square (w, c) of a correct model's residuals, in squares of the scatter.

    It is the variance between the trials of the window's operating point. The scatter is that of
    all points: trials at high flow differ by more, as the gain of a valve is not the same in each.
    Where there is one trial it is 1; nan where nothing is compared.
    """
    relative = residuals.difference / residuals.scatter
    _, first, run = np.unique(residuals.run, return_index=True, return_inverse=True)
    trials_of_run = like_runs(run, residuals.point[first], residuals.v_m_s)
    runs, expected = np.split(relative, first[1:]), np.empty_like(relative)
    for each in np.unique(trials_of_run):
        alike = trials_of_run == each
        expected[alike[run]] = _between_trials([runs[i] for i in np.flatnonzero(alike)])
    return np.where(np.isfinite(relative), expected, np.nan)


def _between_trials(trials: Sequence[np.ndarray]) -> np.ndarray:
    """Return the mean variance (c,) of a window between trials (m, c); 1 where it is unknown."""
    if len(trials) < 2:
        return np.ones(trials[0].shape[1])
    m = min(map(len, trials))
    variance = column_means(np.var([trial[:m] for trial in trials], axis=0, ddof=1))
    return np.where(np.isfinite(variance), variance, 1.0)


def ranked_gaps(residuals: GapMap, allowed: np.ndarray) -> tuple[Gap, ...]:
    """Return the gaps of all balances, largest first; ``allowed`` (c,) is what tolerances explain.

    The p-value is that of what the trials of an operating point have in common: in a correct model
    it is as large as the differences between them make it.
    """
    assert residuals.white is not None and residuals.material is not None
    p_values = holm(_p_values(residuals))
    scatter = residuals.scatter[0]
    d = residuals.difference / scatter
    mean_square = column_means(d**2)
    gaps = []
    for i, name in enumerate(residuals.names):
        windows = int(np.isfinite(d[:, i]).sum())
        if not windows:
            continue
        gap = float(np.sqrt(mean_square[i]))
        beyond_noise = float(np.sqrt(max(mean_square[i] - residuals.white[i], 0.0)))
        gaps.append(
            Gap(
                name=name,
                gap=gap,
                p_value=float(p_values[i]),
                scatter=float(scatter[i]),
                windows=windows,
                deviation=beyond_noise * float(scatter[i]),
                material=float(residuals.material[i] * scatter[i]),
                allowed=float(allowed[i]),
            )
        )
    return tuple(ranked(gaps, lambda balance: balance.gap, ROUNDING))


def unexplained_gaps(ranked: Sequence[Gap]) -> tuple[Gap, ...]:
    """Return the gaps that are structured, material and too large for the scatter of the trials.

    And those of flows that are far beyond what is material, although no trial is like another: what
    does not repeat, such as a spool that sticks, raises the scatter that it is compared with.
    Friction may differ from run to run.
    """
    return tuple(gap for gap in ranked if _is_structured(gap) or _is_irregular(gap))


def _is_structured(gap: Gap) -> bool:
    return (
        gap.gap > UNEXPLAINED_GAP
        and gap.p_value < SIGNIFICANT_P
        and not gap.deviation <= gap.material
    )


def _is_irregular(gap: Gap) -> bool:
    return gap.name in FLOWS and gap.deviation > _IRREGULAR * gap.material


def unexplained_at(residuals: GapMap, points: np.ndarray) -> tuple[Gap, ...]:
    """Return the unexplained gaps at some operating points, largest first."""
    chosen = residuals.select_points(points)
    chosen = replace(chosen, run=np.unique(chosen.run, return_inverse=True)[1])
    return unexplained_gaps(ranked_gaps(chosen, np.zeros(len(chosen.names))))


def _p_values(residuals: GapMap) -> np.ndarray:
    """Return p-values (c,) of what the trials of operating points have in common; see above.

    An F test: the mean moments of each point and function against their variance between trials,
    with degrees of freedom for variances that differ (Satterthwaite 1946).
    """
    trial = _trials(residuals)
    common, within, dof = [], [], []
    for point in np.unique(residuals.point):
        own = np.flatnonzero(residuals.point == point)
        moments = _moments(residuals, own, trial[own])
        if len(moments) > 1:
            mean = moments.mean(axis=0)
            common.append(len(moments) * mean**2)
            within.append(((moments - mean) ** 2).sum(axis=0))
            dof.append(np.full(len(mean), len(moments) - 1.0))
    if not dof:
        return np.full(len(residuals.names), np.nan)
    nu, w = np.concatenate(dof)[:, None], np.concatenate(within)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.concatenate(common).mean(axis=0) / (w.sum(axis=0) / nu.sum())
        of_common = (w / nu).sum(axis=0) ** 2 / (w**2 / (nu * (nu + 2))).sum(axis=0)
        of_within = w.sum(axis=0) ** 2 / (w**2 / (nu + 2)).sum(axis=0)
    return fdtrc(of_common, of_within, ratio)


def _trials(residuals: GapMap) -> np.ndarray:
    """Return the number (w,) of the trial that each window belongs to.

    A trial is a run. Where an operating point has one run, its windows are taken as two trials, in
    alternating blocks: halves of a run differ in position or direction, where errors differ too.
    """
    run = np.unique(residuals.run, return_inverse=True)[1]
    first = np.unique(run, return_index=True)[1]
    point_of_run = residuals.point[first]
    alone = (np.bincount(point_of_run) == 1)[point_of_run]
    odd = (np.arange(len(run)) - first[run]) // _BLOCK % 2
    return 2 * run + odd * alone[run]


def _moments(residuals: GapMap, own: np.ndarray, trial: np.ndarray) -> np.ndarray:
    """Return the products (t, k, c) of each trial's residuals with k functions of the motion.

    ``own`` are the windows of an operating point. The functions are for each direction a constant,
    speed, position and load, made orthogonal. In the mean alone, errors of strokes to and fro would
    cancel. Each but the constant has the mean 0 in every trial: the positions of two holds differ
    by micrometres, and such a function would turn a deviation that they have in common into a
    difference between them.
    """
    v, load = residuals.v_m_s[own], np.nan_to_num(residuals.load_n[own])
    which = np.unique(trial, return_inverse=True)[1]
    plane = np.array([np.ones_like(v), *map(_scaled, (np.abs(v), residuals.x_m[own], load))])
    varying = np.vstack([plane[1:], np.sign(v) * plane]).T
    for each in range(which.max() + 1):
        varying[which == each] -= varying[which == each].mean(axis=0)
    every, sizes, _ = np.linalg.svd(np.column_stack([plane[0], varying]), full_matrices=False)
    functions = every[:, sizes > _DEPENDENT * sizes[0]]
    products = functions[:, :, None] * np.nan_to_num(residuals.difference[own])[:, None, :]
    return np.stack([products[which == each].sum(axis=0) for each in range(which.max() + 1)])


def _scaled(values: np.ndarray) -> np.ndarray:
    """Return values with the mean 0 and the standard deviation 1; 0 where they are all equal."""
    spread = values.std()
    return (values - values.mean()) / spread if spread > 0 else np.zeros_like(values)
