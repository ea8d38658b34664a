"""Velocity steps (section 5.4): settled friction at each level, and the transient between levels.

    F_fT = F_T - F_applied - m_T a,    a_k = (x_(k+1) - 2 x_k + x_(k-1)) / dt^2

The second difference covers only three records, since a step is faster than the smooth derivative
of ``logged_motion``. It is still a mean over records: if the inertia at the step is comparable to
the overshoot, the log does not resolve the overshoot.
"""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from hbench.analysis.curves.average import student_interval
from hbench.analysis.screening.friction_channels import friction_with_inertia
from hbench.analysis.screening.reference_sections import level_windows
from hbench.analysis.screening.screen import window_means
from hbench.records import Level, Run, ScreenedRun, Series

_CLEAR = 5.0  # standard deviations of the settled friction: a larger transient is significant
_NEAR = 3.0  # standard deviations: friction within them has settled, as has
_SHARE = 0.1  # friction within this share of the transient
_COMPARABLE = 0.5  # of the overshoot: larger inertia does not let the log resolve it


@dataclass(frozen=True)
class VelocityStep:
    """A level of a run, with the step to it."""

    v_from_m_s: float
    v_to_m_s: float
    before_n: float | None
    after_n: float
    overshoot_n: float | None
    settling_s: float | None
    inertia_n: float  # the largest in the log, from the step to the settled half
    dt_s: float


def level_runs(screened: Iterable[ScreenedRun]) -> tuple[ScreenedRun, ...]:
    """Return each moving level of the accepted runs of steps as a steady run of its own."""
    level_runs = []
    for verdict in screened:
        run = verdict.run
        if not verdict.accepted or run.v_ref_m_s is None:
            continue
        for level, settled in level_windows(run):
            if level != 0.0:
                level_run = replace(run, plan=replace(run.plan, v_ref_m_s=level))
                level_runs.append(ScreenedRun(level_run, (), window_means(level_run, settled)))
    return tuple(level_runs)


def step_levels(screened: Iterable[ScreenedRun], mass_kg: float) -> tuple[Level, ...]:
    """Return every step of the accepted runs, averaged over trials. ``mass_kg``: test side's."""
    groups: dict[tuple, list[tuple[int, str, list[VelocityStep]]]] = defaultdict(list)
    for verdict in screened:
        run = verdict.run
        if verdict.accepted and run.v_ref_m_s is not None:
            steps = velocity_steps(run, mass_kg)
            key = run.plan.series, run.plan.kind, tuple(step.v_to_m_s for step in steps)
            groups[key].append((run.plan.trial, run.plan.run, steps))
    return tuple(
        _level(series, kind, number, runs)
        for (series, kind, levels), runs in groups.items()
        for number in range(len(levels))
    )


def velocity_steps(run: Run, mass_kg: float) -> list[VelocityStep]:
    """Return the steps of a run. Raises ``DataError`` if a channel is missing."""
    dt = float(np.median(np.diff(run.t_s)))
    a = np.zeros(len(run.x_m))
    a[1:-1] = np.diff(run.x_m, 2) / dt**2
    inertia = mass_kg * a
    friction = friction_with_inertia(run) - inertia
    steps: list[VelocityStep] = []
    before, v_before, start = None, 0.0, 0
    for level, settled in level_windows(run):
        after, noise = float(friction[settled].mean()), float(friction[settled].std(ddof=1))
        change = after - (before or 0.0)
        transient = np.sign(change) * (friction[start : settled.start] - after)
        overshoot = settling = None
        if len(transient) and np.abs(transient).max() > _CLEAR * noise:
            near = max(_NEAR * noise, _SHARE * float(np.abs(transient).max()))
            settling = float((np.flatnonzero(np.abs(transient) > near)[-1] + 1) * dt)
        if len(transient) and transient.max() > _CLEAR * noise:
            overshoot = float(transient.max())
        largest = float(np.abs(inertia[start : settled.start]).max(initial=0.0))
        steps.append(VelocityStep(v_before, level, before, after, overshoot, settling, largest, dt))
        before, v_before, start = after, level, settled.stop
    return steps


def _level(
    series: Series, kind: str, number: int, runs: list[tuple[int, str, list[VelocityStep]]]
) -> Level:
    trials: dict[int, list[VelocityStep]] = defaultdict(list)
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

    steps = [step for trial in trials.values() for step in trial]
    after = np.array([np.mean([step.after_n for step in trial]) for trial in trials.values()])
    overshoot, settling_ci95_s = mean("overshoot_n"), interval("settling_s")
    inertia, dt = max(step.inertia_n for step in steps), first.dt_s
    resolved = overshoot is None or inertia < _COMPARABLE * overshoot
    remark = ""
    if not resolved:
        remark = (
            f"overshoot not resolved by a {1 / dt:.3g} Hz log: the inertia at the step reaches "
            f"{inertia:.3g} N"
        )
    without = sum(all(step.overshoot_n is None for step in trial) for trial in trials.values())
    if overshoot is None and without < len(trials):
        some = sum(any(step.overshoot_n is None for step in trial) for trial in trials.values())
        remark = f"no mean overshoot: none above the noise in {some} of {len(trials)} trials"
    return Level(
        series=series,
        number=number + 1,
        v_from_m_s=first.v_from_m_s,
        v_to_m_s=first.v_to_m_s,
        before_n=mean("before_n"),
        after_n=float(after.mean()),
        after_ci95_n=student_interval(after),
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
