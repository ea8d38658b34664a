"""Breakaway: the first maximum of friction while a rising force pushes a piston that has rested.

    F_fT = F_T - F_applied        (5.1; the piston is at rest, so that 2.12 has no inertia)

It is the end of a straight line through the last samples of a run up to the maximum, which takes
no part in what follows: friction falls within a sample or two. Means and Student's intervals are
over trials of the same direction, load, dwell and rate. Over the dwell t, static friction grows by
one of two laws, each linear in log t (Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30,
1994, section 2.4):

    logarithmic    F = F_1 + g log10(t / 1 s)
    power          F = F_1 (t / 1 s)^m
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from statistics import fmean
from typing import Literal, NamedTuple

import numpy as np

from hbench.analysis.curves.average import student_interval
from hbench.analysis.screening.friction_channels import (
    missing_friction_channels,
    test_force,
)
from hbench.analysis.screening.push_peak import first_peak, peak_n
from hbench.analysis.statistics.student import student_factor
from hbench.analysis.uncertainty.budget import with_instruments
from hbench.config.sensors import Instruments
from hbench.records import SIGNS, Breakaway, Curve, CurvePoint, DwellLaw, Run, RunPlan, ScreenedRun
from hbench.records.rod_pressure import series_key

_LEAST_DWELLS = 3  # for a law over the time at rest


class _Peak(NamedTuple):
    """The moment of the largest friction in one run."""

    friction_n: float  # against the motion
    displacement_m: float
    v_m_s: float
    f_test_n: float
    f_applied_n: float
    p_tp_pa: float
    p_tr_pa: float


def breakaways(
    screened: Iterable[ScreenedRun], instruments: Instruments | None
) -> tuple[Breakaway, ...]:
    """Return the breakaway of the accepted runs: a row a series, rest and rate."""
    groups: dict[tuple, dict[int, list[tuple[str, _Peak]]]] = defaultdict(lambda: defaultdict(list))
    plans: dict[tuple, RunPlan] = {}
    for verdict in screened:
        plan = verdict.run.plan
        peak = _peak(verdict.run) if verdict.accepted else None
        if peak is None:
            continue
        series = plan.kind, *series_key(plan), plan.specimen
        key = (*series, plan.dwell_s, abs(plan.force_rate_n_s or 0.0))
        plans.setdefault(key, plan)
        groups[key][plan.trial].append((plan.run, peak))
    return tuple(_mean(plans[key], groups[key], instruments) for key in sorted(groups, key=_place))


def dwell_laws(measured: Iterable[Breakaway]) -> tuple[DwellLaw, ...]:
    """Fit both laws to the trials of each direction, load and rate with three dwells or more.

    By least squares, the better law first; intervals are Student's.
    """
    groups: dict[tuple, list[Breakaway]] = defaultdict(list)
    for each in measured:
        if each.dwell_s:
            groups[each.series, each.direction, each.rate_n_s, each.kind].append(each)
    laws: list[DwellLaw] = []
    for group in groups.values():
        if len({each.dwell_s for each in group}) >= _LEAST_DWELLS:
            fitted = [_fitted(group, law) for law in ("logarithmic", "power")]
            laws += sorted((law for law in fitted if law), key=lambda law: law.rmse_n)
    return tuple(laws)


def _place(key: tuple) -> tuple:
    """Return the place of a group: by label, direction, size of the load, rest and rate."""
    kind, label, direction, load, p_lr, _, *rest_and_rate = key
    return kind, label, direction, abs(load or 0.0), p_lr or 0.0, *(x or 0.0 for x in rest_and_rate)


def _peak(run: Run) -> _Peak | None:
    """Return the moment of breakaway; None if there is no maximum, or a channel is missing."""
    if missing_friction_channels(run):
        return None
    sign = SIGNS[run.plan.direction]
    f_test, f_applied = test_force(run, slice(None)), run.channel("f_applied_n")
    friction = sign * (f_test - f_applied)
    peak = first_peak(friction)
    if peak is None:
        return None
    at = peak.at
    line = slice(max(at + 1 - peak.samples, 0), at + 1)

    return _Peak(
        friction_n=peak_n(run.t_s, friction, peak) if at else float(friction[0]),
        displacement_m=sign * float(run.x_m[at] - run.x_m[0]),
        v_m_s=sign * float(np.polyfit(run.t_s[line], run.x_m[line], 1)[0]) if at else 0.0,
        f_test_n=float(f_test[at]),
        f_applied_n=float(f_applied[at]),
        p_tp_pa=np.nan if run.p_tp_pa is None else float(run.p_tp_pa[at]),
        p_tr_pa=np.nan if run.p_tr_pa is None else float(run.p_tr_pa[at]),
    )


def _mean(
    plan: RunPlan,
    trials: dict[int, list[tuple[str, _Peak]]],
    instruments: Instruments | None,
) -> Breakaway:
    by_trial = [_Peak(*np.mean([peak for _, peak in runs], axis=0)) for runs in trials.values()]
    mean = _Peak(*np.mean(by_trial, axis=0).tolist())
    friction = np.array([peak.friction_n for peak in by_trial])
    sign = SIGNS[plan.direction]
    hydraulic = plan.specimen.area_piston_m2 > 0
    point = CurvePoint(
        v_m_s=0.0,
        friction_n=sign * mean.friction_n,
        ci95_n=student_interval(friction),
        n=len(by_trial),
        f_test_n=mean.f_test_n,
        f_applied_n=mean.f_applied_n,
        p_tp_pa=mean.p_tp_pa if hydraulic else None,
        p_tr_pa=mean.p_tr_pa if hydraulic and plan.specimen.area_rod_m2 else None,
        trials=tuple(trials),
        trials_n=tuple(friction.tolist()),
        trials_f_test_n=tuple(peak.f_test_n for peak in by_trial),
        runs=tuple(run for runs in trials.values() for run, _ in runs),
    )
    load = plan.f_load_n, plan.p_lr_ref_pa
    curve = Curve(plan.kind, plan.direction, *load, plan.label, plan.specimen, (point,))
    (point,) = with_instruments(curve, instruments).points
    area = plan.specimen.driving_area_m2(plan.direction)
    return Breakaway(
        series=plan.series,
        direction=plan.direction,
        dwell_s=plan.dwell_s,
        rate_n_s=None if plan.force_rate_n_s is None else abs(plan.force_rate_n_s),
        breakaway_n=mean.friction_n,
        ci95_n=point.ci95_n,
        u95_n=point.u95_n,
        u95_dof=point.u95_dof,
        n=point.n,
        trials_n=point.trials_n,
        displacement_m=mean.displacement_m,
        p_tp_pa=point.p_tp_pa,
        p_tr_pa=point.p_tr_pa,
        f_applied_n=point.f_applied_n,
        runs=point.runs,
        kind=plan.kind,
        breakaway_pa=mean.friction_n / area if area else None,
        u95_pa=point.u95_n / area if area and point.u95_n is not None else None,
        v_m_s=mean.v_m_s,
        sigma_instruments_n=point.sigma_instruments_n,
        sigma_instruments_dof=point.sigma_instruments_dof,
    )


def _fitted(group: Sequence[Breakaway], law: Literal["logarithmic", "power"]) -> DwellLaw | None:
    """Return one law; None where it does not exist, since a friction is not positive."""
    decades = np.log10([each.dwell_s or 1.0 for each in group for _ in each.trials_n])
    friction = np.array([trial for each in group for trial in each.trials_n])
    if law == "power" and friction.min() <= 0.0:
        return None
    y = friction if law == "logarithmic" else np.log10(friction)
    deviation = decades - decades.mean()
    spread = float(deviation @ deviation)
    slope = float(deviation @ y) / spread
    level = float(y.mean() - slope * decades.mean())  # at log10 t = 0
    residual = y - level - slope * decades
    dof = len(y) - 2
    variance = float(residual @ residual) / dof
    t = student_factor(dof)
    slope_half = t * np.sqrt(variance / spread)
    level_half = t * np.sqrt(variance * (1 / len(y) + decades.mean() ** 2 / spread))
    f_1s = level if law == "logarithmic" else 10**level
    if law == "power":
        level_half *= f_1s * np.log(10.0)  # to first order
        residual = friction - f_1s * 10 ** (slope * decades)
    return DwellLaw(
        series=group[0].series,
        direction=group[0].direction,
        law=law,
        f_1s_n=f_1s,
        f_1s_ci95_n=float(level_half),
        growth=slope,
        growth_ci95=float(slope_half),
        rmse_n=float(np.sqrt(fmean(residual**2))),
        dwells=len({each.dwell_s for each in group}),
        n=len(y),
        kind=group[0].kind,
    )
