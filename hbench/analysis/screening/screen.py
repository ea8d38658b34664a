"""Which runs count: the verdict on each run, with every reason that speaks against it."""

from collections.abc import Iterator
from dataclasses import fields, replace
from typing import Any

import numpy as np

from hbench.analysis.rounding import ROUNDING, exceeds
from hbench.analysis.screening.by_kind import RULES, motion_notes, motion_reasons, near_end
from hbench.analysis.screening.saturation import sensors_at_their_end
from hbench.analysis.screening.steadiness import drift, mean_speed, speed_ripple
from hbench.analysis.screening.steady_window import (
    at_reference,
    stands_still,
    steady_window,
    window_length_s,
)
from hbench.analysis.uncertainty.efficiency import Forces, efficiency_of
from hbench.config.schedule import Screening
from hbench.records import KINDS, Run, ScreenedRun, SteadyMeans

# Codes of the reasons, the most fundamental first. A reason reads "code: words, value, limit".
CODES = (
    "aborted",
    "truncated",
    "missing_channel",
    "gapped",
    "sensor_saturated",
    "too_short",
    "incomplete",
    "end_stop",
    "valve_saturated",
    "off_reference",
    "not_steady",
)

SCREENING_RULES = ("steady_window", *RULES)  # of the column ``screening`` of KINDS

_STANDSTILL_S = 0.2
_SURE = 3.0  # standard errors that a drift must stand above its limit


def screen(run: Run, rules: Screening) -> ScreenedRun:
    """Judge a run and average its steady window.

    The window starts ``settle_time`` and ``settle_travel`` after the reference was reached. The
    limits are those of ``rules``; see ``CODES`` for the reasons. Runs of another kind than
    ``steady`` have rules of their own (``screen_motion``) and no steady window.
    """
    run, notes = _with_values(run)
    if not KINDS[run.plan.kind].has_constant_speed:
        reasons = [*_integrity(run, slice(0, None), rules), *motion_reasons(run, rules)]
        return ScreenedRun(run, _in_order(reasons), None, (*notes, *motion_notes(run)))
    part = at_reference(run)
    window = steady_window(run, part, rules)
    long_enough = window_length_s(run, window) >= rules.min_window - ROUNDING
    means = window_means(run, window) if long_enough else None
    reasons = [*_integrity(run, window if long_enough else part, rules)]
    if not long_enough:
        reasons.append(_too_short(run, part, window, rules))
    reasons += _motion(run, part, window if long_enough else part, rules)
    if long_enough:
        reasons += _steadiness(run, window, means, rules)
    lost = run.missing_records
    if lost and not any(reason.startswith("gapped") for reason in reasons):
        notes.append(f"{lost} records are missing outside the steady window")
    return ScreenedRun(run, _in_order(reasons), means, tuple(notes))


def _in_order(reasons: list[str]) -> tuple[str, ...]:
    return tuple(sorted(reasons, key=lambda reason: CODES.index(reason.split(":")[0])))


def _with_values(run: Run) -> tuple[Run, list[str]]:
    """Leave out empty channels and samples that lack what friction is made of, and say so.

    A channel that is NaN throughout is one that the bench does not have.
    """
    channels = {
        field.name: values
        for field in fields(run)
        if isinstance(values := getattr(run, field.name), np.ndarray)
    }
    optional = [name for name in channels if name not in ("t_s", "x_m")]
    empty = [name for name in optional if len(run.t_s) and np.isnan(channels[name]).all()]
    notes = [f"{name} has no value in any sample: taken as not measured" for name in empty]
    none: dict[str, Any] = dict.fromkeys(empty)
    run = replace(run, **none)
    needed = [channels[n] for n in ("t_s", "x_m", *_needed(run)) if getattr(run, n) is not None]
    known = np.logical_and.reduce([np.isfinite(values) for values in needed])
    if known.all():
        return run, notes
    kept: dict[str, Any] = {
        name: values[known] for name, values in channels.items() if name not in empty
    }
    words = "lack time, position or what friction is made of"
    return replace(run, **kept), [
        *notes,
        f"{np.sum(~known)} of {len(known)} samples {words}, left out",
    ]


def _integrity(run: Run, window: slice, rules: Screening) -> Iterator[str]:
    """Reasons that lie in the log, not in the motion."""
    if run.aborted:
        yield f"aborted: {run.aborted}"
    if run.truncated:
        yield f"truncated: {run.truncated}"
    missing = missing_channels(run)
    if KINDS[run.plan.kind].is_at_rest:
        missing = [name for name in missing if name != "f_applied_n"]
    if missing:
        yield f"missing_channel: friction needs {' and '.join(missing)}"
    steps = np.diff(run.t_s[window])
    if len(steps):
        lost = int(np.sum(np.rint(steps / np.median(steps)) - 1)) if run.missing_records else 0
        if lost > 0:
            yield f"gapped: {lost} records are missing in the window of {len(steps) + 1}; limit 0"
        elif exceeds(steps.max(), rules.max_gap):
            yield (
                f"gapped: {steps.max():.2f} s between two samples of the window; "
                f"limit {rules.max_gap:g} s"
            )
    for reason in _saturated("sensor_saturated", run.sensor_saturated, window):
        which = sensors_at_their_end(run, window)
        yield f"{reason}; {which}" if which else reason


def _motion(run: Run, part: slice, window: slice, rules: Screening) -> Iterator[str]:
    """Reasons that lie in where the piston is and what the valve does."""
    x, stroke, margin = run.x_m[window], run.plan.specimen.stroke_m, rules.end_stop_margin
    standing = 0.0 if run.at_reference is None else stands_still(run, part)
    if len(x) and stroke is not None and (nearest := near_end(x, stroke, margin)) is not None:
        yield (
            f"end_stop: the piston is at {1e3 * nearest:.1f} mm of a stroke of "
            f"{1e3 * stroke:g} mm; limit {1e3 * margin:g} mm from either end"
        )
    elif standing >= _STANDSTILL_S:
        yield (
            f"end_stop: the piston stands for the last {standing:.1f} s while the reference "
            f"moves on; limit {_STANDSTILL_S:g} s"
        )
    yield from _saturated("valve_saturated", run.valve_saturated, window)


def _steadiness(
    run: Run, window: slice, means: SteadyMeans | None, rules: Screening
) -> Iterator[str]:
    """Reasons that lie in the speed and in the friction over the window."""
    t, x, v_ref = run.t_s[window], run.x_m[window], run.plan.v_ref_m_s
    v = mean_speed(t, x)
    limit = rules.speed_limit(v_ref)
    if abs(v - v_ref) > limit + ROUNDING * abs(v_ref):
        yield (
            f"off_reference: mean speed {1e3 * v:.2f} mm/s is {1e3 * abs(v - v_ref):.2f} mm/s "
            f"off the reference {1e3 * v_ref:.2f} mm/s; limit {1e3 * limit:.2f} mm/s"
        )
    ripple = speed_ripple(t, x)
    limit = max(rules.speed_ripple, rules.speed_ripple_relative * abs(v_ref))
    if exceeds(ripple.total_m_s, np.hypot(limit, ripple.noise_m_s)):
        yield (
            f"not_steady: speed over 0.1 s varies by {1e3 * ripple.total_m_s:.2f} mm/s (standard "
            f"deviation); limit {1e3 * limit:.2f} mm/s and {1e3 * ripple.noise_m_s:.2f} mm/s noise"
        )
    if run.v_m_s is not None and np.isfinite(run.v_m_s[window]).sum() > 1:
        swing = np.nanstd(run.v_m_s[window], ddof=1)
        limit = max(rules.speed_oscillation, rules.speed_oscillation_relative * abs(v_ref))
        if exceeds(swing, limit):
            yield (
                f"not_steady: the controller's velocity oscillates by {1e3 * swing:.2f} mm/s "
                f"(standard deviation); limit {1e3 * limit:.2f} mm/s"
            )
    if means is None or means.friction_n is None:
        return
    change = drift(t, test_force(run, window) - run.f_applied_n[window])
    limit = max(rules.friction_drift, rules.friction_drift_relative * abs(means.friction_n))
    if exceeds(abs(change.value), limit + _SURE * change.se):
        yield (
            f"not_steady: friction drifts by {change.value:+.1f} N (standard error "
            f"{change.se:.1f} N) over the window; limit {limit:.1f} N"
        )


def _too_short(run: Run, part: slice, window: slice, rules: Screening) -> str:
    limit = f"limit {rules.min_window:g} s"
    reached = run.t_s[part]
    if not len(reached):
        return f"too_short: the reference speed was never reached, so there is no window; {limit}"
    return (
        f"too_short: a steady window of {window_length_s(run, window):.2f} s is left of "
        f"{reached[-1] - reached[0]:.2f} s at the reference, after settling for "
        f"{rules.settle_time:g} s and {1e3 * rules.settle_travel:g} mm; {limit}"
    )


def _saturated(code: str, flags: np.ndarray | None, window: slice) -> Iterator[str]:
    count = 0 if flags is None else int(np.sum(flags[window]))
    if count:
        yield f"{code}: in {count} of the {len(flags[window])} records of the window; limit 0"


def _needed(run: Run) -> tuple[str, ...]:
    """Return the channels that friction is made of; a plunger has no rod side."""
    rod_side = ("p_tr_pa",) if run.plan.specimen.area_rod_m2 > 0 else ()
    return "p_tp_pa", *rod_side, "f_applied_n"


def missing_channels(run: Run) -> list[str]:
    """Return the channels that friction needs and the run lacks."""
    return [name for name in _needed(run) if getattr(run, name) is None]


def test_force(run: Run, window: slice) -> np.ndarray:
    """Return F_T = P_Tp A_p - P_Tr A_r."""
    specimen = run.plan.specimen
    force = run.p_tp_pa[window] * specimen.area_piston_m2
    if "p_tr_pa" not in _needed(run):
        return force
    return force - run.p_tr_pa[window] * specimen.area_rod_m2


def window_means(run: Run, window: slice) -> SteadyMeans:
    """Average a window of steady speed: friction by 5.1, which is 2.12 without acceleration."""
    t = run.t_s[window]
    v = mean_speed(t, run.x_m[window])
    known = {name: _mean(getattr(run, name), window) for name in _needed(run)}
    p_tp, p_tr = known["p_tp_pa"], known.get("p_tr_pa")
    f_applied, missing = known["f_applied_n"], missing_channels(run)
    pressures = not {"p_tp_pa", "p_tr_pa"} & set(missing)
    f_test = float(np.mean(test_force(run, window))) if pressures else None
    forces = None if missing else Forces(v, f_applied, p_tp, p_tr, run.plan.specimen)
    return SteadyMeans(
        t_start_s=float(t[0]),
        t_stop_s=float(t[-1]),
        n=len(t),
        v_m_s=v,
        friction_n=None if missing else f_test - f_applied,
        f_test_n=f_test,
        f_applied_n=f_applied,
        p_tp_pa=p_tp,
        p_tr_pa=p_tr,
        efficiency=None if forces is None else efficiency_of(forces),
    )


def _mean(values: np.ndarray | None, window: slice) -> float | None:
    return None if values is None else float(np.mean(values[window]))
