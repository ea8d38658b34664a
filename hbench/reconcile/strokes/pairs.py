"""Pairs of steady strokes of another bench: one in each direction at one load and speed."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np

from hbench.analysis.rounding import is_constant
from hbench.config.bench import Bore
from hbench.reconcile.strokes.load_cell import Stroke
from hbench.reconcile.strokes.within_stroke import change_over_window
from hbench.records import KINDS, RunPlan, ScreenedRun, Specimen

_FEWEST_STROKES = 2  # in each direction at one speed
_LOAD_IN_BAND = 0.1  # share of the friction band that a difference of the load may have


@dataclass(frozen=True)
class StrokePair:
    """Strokes in both directions at one load, pressure and speed."""

    plan: RunPlan  # of the load, without a speed
    speed_m_s: (
        float  # that was set, or measured where there are several; 0 for one that was not set
    )
    extend: Stroke
    retract: Stroke


def stroke_pairs(screened: Iterable[ScreenedRun]) -> tuple[StrokePair, ...]:
    """Return accepted steady runs in pairs, one for each trial if a speed has several trials.

    Strokes of one trial share its set-up, so they are not independent repeats. Where no load has a
    second trial, successive strokes are paired and serve as repeats.
    """
    of_loads: dict[RunPlan, list[ScreenedRun]] = defaultdict(list)
    for run in screened:
        plan = run.run.plan
        if run.accepted and KINDS[plan.kind].has_constant_speed and run.means is not None:
            load = replace(
                plan, run="", trial=0, v_ref_m_s=0.0, x_low_m=None, x_high_m=None
            )  # the positions to average over are those of a file
            of_loads[load].append(run)
    strokes: dict[tuple[RunPlan, float], dict[tuple[int, str], list[Stroke]]] = {}
    for load, runs in of_loads.items():
        speeds = _speeds([run.run.plan for run in runs])
        for run, speed in zip(runs, speeds, strict=True):
            by_trial = strokes.setdefault((load, speed), defaultdict(list))
            by_trial[run.run.plan.trial, run.run.plan.direction].append(_stroke(run))
    repeated = any(len({trial for trial, _ in by_trial}) > 1 for by_trial in strokes.values())
    pairs = []
    for key, by_trial in strokes.items():
        for trial in sorted({trial for trial, _ in by_trial}):
            extending, retracting = by_trial[trial, "extend"], by_trial[trial, "retract"]
            if repeated and extending and retracting:
                extending, retracting = [_mean(extending)], [_mean(retracting)]
            pairs += [StrokePair(*key, *both) for both in zip(extending, retracting, strict=False)]
    return tuple(pairs)


def _speeds(plans: Sequence[RunPlan]) -> list[float]:
    """Return the speeds at which the runs of a load are compared.

    Speeds that nobody set differ a little between the directions, so those of equal rank belong
    together. They count as one, 0, where a direction has more of them or where one has no repeat.
    """
    runs = [(plan.direction, abs(plan.v_ref_m_s)) for plan in plans]
    if not plans[0].speed_is_measured:
        return [speed for _, speed in runs]
    out, back = (sorted({v for way, v in runs if way == w}) for w in ("extend", "retract"))
    if len(out) != len(back) or min(Counter(runs).values()) < _FEWEST_STROKES:
        return [0.0] * len(runs)
    common = dict(zip(back, out, strict=True))
    return [speed if way == "extend" else common[speed] for way, speed in runs]


def repeats(pairs: Iterable[StrokePair]) -> dict[RunPlan, list[tuple[StrokePair, ...]]]:
    """Return the repeats of each load with two or more: a pair of each speed, slowest first.

    Left out are speeds with a single pair, and of each speed the pairs beyond the fewest of one.
    """
    by_load: dict[RunPlan, dict[float, list[StrokePair]]] = {}
    for pair in pairs:
        by_load.setdefault(pair.plan, {}).setdefault(pair.speed_m_s, []).append(pair)
    of_loads = {}
    for load, by_speed in by_load.items():
        several = [
            by_speed[speed] for speed in sorted(by_speed) if len(by_speed[speed]) >= _FEWEST_STROKES
        ]
        if several:
            of_loads[load] = list(zip(*several, strict=False))
    return of_loads


def has_force_sensor(screened: Iterable[ScreenedRun]) -> bool:
    """Return whether the applied force varies among the samples of a load, as readings do."""
    forces: dict[float | None, list[np.ndarray]] = defaultdict(list)
    for run in screened:
        if run.run.f_applied_n is not None:
            forces[run.run.plan.f_load_n].append(run.run.f_applied_n)
    return not all(is_constant(np.concatenate(of_load)) for of_load in forces.values())


def with_unknown_load(pairs: Iterable[StrokePair]) -> tuple[StrokePair, ...]:
    """Return pairs whose applied force is the mean pressure force of both directions.

    A pair is left out if its load differs between the mean positions of its strokes by more than a
    tenth of the friction band, since that difference would count as friction.
    """
    out = []
    for pair in pairs:
        strokes, areas = (pair.extend, pair.retract), pair.plan.specimen
        forces = [_pressure_force(stroke, areas) for stroke in strokes]
        travel = sum(stroke.travel_m for stroke in strokes)
        slope = sum(stroke.change_n for stroke in strokes) / travel if travel > 0 else 0.0
        of_load = slope * (pair.extend.x_m - pair.retract.x_m)
        if abs(of_load) <= _LOAD_IN_BAND * abs(forces[0] - forces[1]):
            load = sum(forces) / 2
            both = (replace(stroke, f_applied_n=load) for stroke in strokes)
            out.append(StrokePair(pair.plan, pair.speed_m_s, *both))
    return tuple(out)


def _stroke(screened: ScreenedRun) -> Stroke:
    run, means = screened.run, screened.means
    assert means is not None
    assert means.p_tp_pa is not None and means.f_applied_n is not None  # of an accepted run
    centre = (means.t_start_s + means.t_stop_s) / 2
    x_m = run.x_m[(run.t_s >= means.t_start_s) & (run.t_s <= means.t_stop_s)]
    return Stroke(
        t_s=centre,
        v_m_s=means.v_m_s,
        p_tp_pa=means.p_tp_pa,
        p_tr_pa=means.p_tr_pa or 0.0,
        f_applied_n=means.f_applied_n,
        change_n=change_over_window(run, means),
        x_m=float(x_m.mean()) if len(x_m) else 0.0,
        travel_m=float(np.ptp(x_m)) if len(x_m) else 0.0,
    )


def _mean(strokes: Sequence[Stroke]) -> Stroke:
    return Stroke(*np.mean([astuple(stroke) for stroke in strokes], axis=0).tolist())


def mean_pair(pairs: Sequence[StrokePair]) -> StrokePair:
    """Return the mean of pairs at one load and speed."""
    extend, retract = ([getattr(pair, way) for pair in pairs] for way in ("extend", "retract"))
    return replace(pairs[0], extend=_mean(extend), retract=_mean(retract))


def lost_force(stroke: Stroke, areas: Bore) -> float:
    """Return F_T - F_applied [N] of a stroke."""
    return _pressure_force(stroke, areas) - stroke.f_applied_n


def _pressure_force(stroke: Stroke, areas: Bore | Specimen) -> float:
    return stroke.p_tp_pa * areas.area_piston_m2 - stroke.p_tr_pa * areas.area_rod_m2
