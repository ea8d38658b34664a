"""Velocity steps (section 5.4): friction settled at each level, and on its way to the next.

    F_fT = F_T - F_applied - m_T a,    a_k = (x_(k+1) - 2 x_k + x_(k-1)) / dt^2

The second difference reaches over three records alone, since a jump is faster than the smooth
derivative of ``logged_motion``. It is still a mean over records: where the inertia at the jump is
comparable to the overshoot, the log does not resolve the overshoot.
"""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from hbench.analysis.curves.average import student_interval
from hbench.analysis.screening.reference_sections import level_windows
from hbench.analysis.screening.screen import test_force, window_means
from hbench.records import Level, Run, ScreenedRun, Series

_CLEAR = 5.0  # standard deviations of the settled friction: then a swing is seen
_NEAR = 3.0  # and within these it has settled, or
_SHARE = 0.1  # within this share of the swing
_COMPARABLE = 0.5  # of the overshoot


@dataclass(frozen=True)
class Step:
    """One level of one run."""

    v_from_m_s: float
    v_to_m_s: float
    before_n: float | None
    after_n: float
    overshoot_n: float | None
    settling_s: float | None
    inertia_n: float  # the largest, from the jump to the settled half, as far as the log has it
    dt_s: float


def level_runs(screened: Iterable[ScreenedRun]) -> tuple[ScreenedRun, ...]:
    """Return each moving level of the accepted runs of steps as a steady run of its own."""
    found = []
    for one in screened:
        run = one.run
        if not one.accepted or run.v_ref_m_s is None:
            continue
        for level, held in level_windows(run):
            if level != 0.0:
                part = replace(run, plan=replace(run.plan, v_ref_m_s=level))
                found.append(ScreenedRun(part, (), window_means(part, held)))
    return tuple(found)


def levels(screened: Iterable[ScreenedRun], mass_kg: float) -> tuple[Level, ...]:
    """Return every step of the accepted runs, averaged over trials. ``mass_kg``: test side's."""
    groups: dict[tuple, list[tuple[int, str, list[Step]]]] = defaultdict(list)
    for one in screened:
        run = one.run
        if one.accepted and run.v_ref_m_s is not None:
            steps = steps_of(run, mass_kg)
            series = run.plan.label, run.plan.f_load_n, run.plan.p_lr_ref_pa
            key = (*series, run.plan.kind, tuple(step.v_to_m_s for step in steps))
            groups[key].append((run.plan.trial, run.plan.run, steps))
    return tuple(
        _level(Series(*key[:3]), key[3], number, runs)
        for key, runs in groups.items()
        for number in range(len(key[4]))
    )


def steps_of(run: Run, mass_kg: float) -> list[Step]:
    """Return the steps of one run that has its reference and what friction is made of."""
    dt = float(np.median(np.diff(run.t_s)))
    a = np.zeros(len(run.x_m))
    a[1:-1] = np.diff(run.x_m, 2) / dt**2
    inertia = mass_kg * a
    friction = test_force(run, slice(None)) - run.f_applied_n - inertia
    found, before, v_before, jump = [], None, 0.0, 0
    for level, held in level_windows(run):
        after, noise = float(friction[held].mean()), float(friction[held].std(ddof=1))
        change = after - (before or 0.0)
        way = np.sign(change) * (friction[jump : held.start] - after)
        overshoot = settling = None
        if len(way) and np.abs(way).max() > _CLEAR * noise:
            near = max(_NEAR * noise, _SHARE * float(np.abs(way).max()))
            settling = float((np.flatnonzero(np.abs(way) > near)[-1] + 1) * dt)
        if len(way) and way.max() > _CLEAR * noise:
            overshoot = float(way.max())
        largest = float(np.abs(inertia[jump : held.start]).max(initial=0.0))
        found.append(Step(v_before, level, before, after, overshoot, settling, largest, dt))
        before, v_before, jump = after, level, held.stop
    return found


def _level(
    series: Series, kind: str, number: int, runs: list[tuple[int, str, list[Step]]]
) -> Level:
    trials: dict[int, list[Step]] = defaultdict(list)
    for trial, _, steps in runs:
        trials[trial].append(steps[number])
    first = runs[0][2][number]

    def of_trials(name: str) -> np.ndarray | None:
        values = [[getattr(step, name) for step in steps] for steps in trials.values()]
        if any(value is None for trial in values for value in trial):
            return None
        return np.array([np.mean(trial) for trial in values])

    def mean(name: str) -> float | None:
        values = of_trials(name)
        return None if values is None else float(values.mean())

    def interval(name: str) -> float | None:
        values = of_trials(name)
        return None if values is None else student_interval(values)

    steps = [step for of_trial in trials.values() for step in of_trial]
    overshoot, settling_ci95_s = mean("overshoot_n"), interval("settling_s")
    inertia, dt = max(step.inertia_n for step in steps), first.dt_s
    resolved = overshoot is None or inertia < _COMPARABLE * overshoot
    remark = ""
    if not resolved:
        remark = (
            f"overshoot not resolved by a {1 / dt:.3g} Hz log: the jump's inertia reaches "
            f"{inertia:.3g} N"
        )
    without = sum(all(step.overshoot_n is None for step in found) for found in trials.values())
    if overshoot is None and without < len(trials):
        some = sum(any(step.overshoot_n is None for step in found) for found in trials.values())
        remark = f"no overshoot above the noise in {some} of {len(trials)} trials: no mean"
    return Level(
        series=series,
        number=number + 1,
        v_from_m_s=first.v_from_m_s,
        v_to_m_s=first.v_to_m_s,
        before_n=mean("before_n"),
        after_n=mean("after_n"),
        after_ci95_n=student_interval(of_trials("after_n")),
        overshoot_n=overshoot,
        settling_s=mean("settling_s"),
        n=len(trials),
        runs=tuple(run for _, run, _ in runs),
        overshoot_ci95_n=interval("overshoot_n"),
        settling_ci95_s=None if settling_ci95_s is None else max(settling_ci95_s, dt / 2),
        settling_step_s=dt,
        remark=remark,
        resolved=resolved,
        kind=kind,
    )
