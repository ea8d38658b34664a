"""Friction curves: averages of the accepted runs at each reference, with Student's interval."""

import math
from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable, Sequence
from statistics import fmean

import numpy as np

from hbench.analysis.statistics.student import student_factor
from hbench.records import TEMPERATURES, Curve, CurvePoint, RunPlan, ScreenedRun
from hbench.records.runs import TemperatureSensor


def curves(screened: Iterable[ScreenedRun]) -> tuple[Curve, ...]:
    """Average the accepted runs with means into curves.

    Curves are in the order of their labels' first runs; those of a label are sorted by direction,
    size of load and rod-side pressure, since runs may have a random order, and files that of their
    names.

    Runs of a curve have the same kind, direction, load, rod-side pressure of the load cylinder,
    label and test cylinder; runs of a point have the same reference speed too.
    The unit of the statistics is the trial: runs with the same trial number (the strokes of one
    file) are averaged first, since they have the same set-up and are not independent.
    """
    usable = [run for run in screened if run.accepted and run.means is not None]
    sensor = temperature_sensor(usable)
    return tuple(
        Curve(
            kind=runs[0].run.plan.kind,
            direction=runs[0].run.plan.direction,
            f_load_n=runs[0].run.plan.f_load_n,
            p_lr_ref_pa=runs[0].run.plan.p_lr_ref_pa,
            label=runs[0].run.plan.label,
            factors=runs[0].run.plan.factors,
            specimen=runs[0].run.plan.specimen,
            points=tuple(
                sorted(
                    (
                        _point(group, sensor)
                        for group in _grouped(runs, lambda plan: plan.v_ref_m_s)
                    ),
                    key=lambda point: abs(point.v_m_s),
                )
            ),
        )
        for runs in _in_order(_grouped(usable, _series))
    )


def temperature_sensor(screened: Iterable[ScreenedRun]) -> TemperatureSensor | None:
    """Return the field of the oil's temperature that results take, or None if there is none.

    It is the sensor nearest to the seal that all accepted runs have, or else that any of them has.
    """
    means = [run.means for run in screened if run.accepted and run.means is not None]
    for enough in (all, any):
        for name in TEMPERATURES if means else ():
            if enough(getattr(mean, name) is not None for mean in means):
                return name
    return None


def student_interval(values: np.ndarray) -> float | None:
    """Return the half-width of the 95 % interval of a mean: t S / sqrt(n), equations 6.3 and 6.4.

    S is the standard deviation and t Student's factor, both with n - 1 degrees of freedom. None
    for fewer than two values.
    """
    n = len(values)
    if n < 2:
        return None
    return float(student_factor(n - 1) * np.std(values, ddof=1) / np.sqrt(n))


def _series(plan: RunPlan) -> tuple:
    load = plan.f_load_n, plan.p_lr_ref_pa
    return plan.kind, plan.direction, *load, plan.label, plan.specimen


def _in_order(series: Sequence[list[ScreenedRun]]) -> list[list[ScreenedRun]]:
    """Sort the series of each label."""
    plans = [runs[0].run.plan for runs in series]
    labels = list(dict.fromkeys((plan.kind, plan.label) for plan in plans))

    def place(runs: list[ScreenedRun]) -> tuple:
        plan = runs[0].run.plan
        label = labels.index((plan.kind, plan.label))
        return label, plan.direction, abs(plan.f_load_n or 0.0), _last(plan.p_lr_ref_pa)

    return sorted(series, key=place)


def _last(pressure_pa: float | None) -> float:
    return math.inf if pressure_pa is None else pressure_pa


def _grouped(
    runs: Iterable[ScreenedRun], key: Callable[[RunPlan], Hashable]
) -> list[list[ScreenedRun]]:
    groups: dict[Hashable, list[ScreenedRun]] = defaultdict(list)
    for run in runs:
        groups[key(run.run.plan)].append(run)
    return list(groups.values())


def _point(runs: list[ScreenedRun], temperature: str | None) -> CurvePoint:
    trials = _grouped(runs, lambda plan: plan.trial)

    def of_trials(name: str) -> np.ndarray:
        return np.array([np.mean([getattr(run.means, name) for run in trial]) for trial in trials])

    friction, f_test = of_trials("friction_n"), of_trials("f_test_n")

    def is_known(name: str) -> bool:
        return all(getattr(run.means, name) is not None for run in runs)

    def mean_pressure(name: str) -> float | None:
        return float(of_trials(name).mean()) if is_known(name) else None

    measured = temperature is not None and is_known(temperature)
    temps_k = of_trials(temperature) if measured and temperature else np.zeros(0)

    return CurvePoint(
        v_m_s=float(of_trials("v_m_s").mean()),
        friction_n=float(friction.mean()),
        ci95_n=student_interval(friction),
        n=len(trials),
        f_test_n=float(f_test.mean()),
        f_applied_n=float(of_trials("f_applied_n").mean()),
        p_tp_pa=mean_pressure("p_tp_pa"),
        p_tr_pa=mean_pressure("p_tr_pa"),
        trials=tuple(trial[0].run.plan.trial for trial in trials),
        trials_n=tuple(friction.tolist()),
        trials_f_test_n=tuple(f_test.tolist()),
        runs=tuple(run.run.plan.run for run in runs),
        trials_work_j=_works(trials),
        temp_k=float(temps_k.mean()) if measured else None,
        trials_temp_k=tuple(temps_k.tolist()),
        u_steps=_largest_steps(runs),
        far_shift_n=float(of_trials("far_shift_n").mean()),
    )


def _largest_steps(runs: Iterable[ScreenedRun]) -> dict[str, float]:
    """Return the largest uncertainty of each channel: runs alike are rounded alike."""
    largest: dict[str, float] = {}
    for run in runs:
        for name, u in run.means.u_steps.items() if run.means else ():
            if not np.isnan(u):
                largest[name] = max(u, largest.get(name, 0.0))
    return largest


def _works(trials: Iterable[Iterable[ScreenedRun]]) -> tuple[float | None, ...]:
    """Return the mean work of each trial's strokes; empty where none is known."""
    known = [[run.work_j for run in trial if run.work_j is not None] for trial in trials]
    return tuple(fmean(works) if works else None for works in known) if any(known) else ()
