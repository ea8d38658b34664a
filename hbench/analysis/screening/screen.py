"""Screening: the verdict on each run, with all reasons for a rejection."""

from collections.abc import Iterator
from dataclasses import fields, replace
from typing import Any

import numpy as np

from hbench.analysis.rounding import ROUNDING, exceeds
from hbench.analysis.screening.by_kind import RULES, end_stop_reasons, motion_notes, motion_reasons
from hbench.analysis.screening.far_samples import Outliers, far_samples
from hbench.analysis.screening.friction_channels import (
    friction_channels,
    friction_with_inertia,
    missing_friction_channels,
    test_force,
)
from hbench.analysis.screening.log_steps import rounding_errors
from hbench.analysis.screening.oscillation import (
    oscillation_of_position,
    oscillation_of_velocity,
)
from hbench.analysis.screening.saturation import (
    saturated_sensors,
    saturated_valves,
    saturation_reasons,
)
from hbench.analysis.screening.steadiness import (
    BLOCK_S,
    drift,
    line_change,
    load_step,
    speed_ripple,
)
from hbench.analysis.screening.steady_window import (
    at_reference,
    standstill_s,
    steady_window,
    window_length_s,
)
from hbench.analysis.uncertainty.efficiency import SteadyForces, efficiency_of
from hbench.config.schedule import Screening
from hbench.motion.noise import noise_over_motion, resolution
from hbench.motion.reversals import travel
from hbench.motion.speeds import mean_speed
from hbench.records import KINDS, TEMPERATURES, Run, ScreenedRun, SteadyMeans
from hbench.sentences import listed

# Codes of the reasons, the most fundamental first. A reason reads "code: fault, value, limit".
CODES = (
    "aborted",
    "unfinished",
    "missing",
    "unreadable",
    "truncated",
    "changed",
    "copy",
    "missing_channel",
    "gapped",
    "sensor_saturated",
    "too_short",
    "incomplete",
    "end_stop",
    "stalled",
    "valve_saturated",
    "off_reference",
    "not_steady",
)

SCREENING_RULES = ("steady_window", *RULES)  # of the column ``screening`` of KINDS

_CAUSED = {  # faults of a log that another reason causes
    "aborted": ("truncated", "too_short"),
    "unfinished": ("missing", "truncated", "too_short"),
}
_OF_LOG = ("unfinished", "missing", "unreadable", "truncated", "changed", "copy")
_STANDSTILL_S = 0.2
_DRIFT_ERRORS = 3.0  # standard errors by which a drift must exceed its limit


def screen(run: Run, rules: Screening) -> ScreenedRun:
    """Screen a run and average its steady window.

    The window starts ``settle_time`` and ``settle_travel`` after the reference was reached. The
    limits are those of ``rules``; see ``CODES`` for the reasons. Non-steady runs have rules of
    their own (``motion_reasons``) and no steady window.
    """
    run, notes = _with_values(run)
    return replace(
        _screened(run, rules, notes),
        travel_m=travel(run.t_s, run.x_m),
        friction_work_j=None if missing_friction_channels(run) else _work(run),
        ends_m=(float(run.x_m[0]), float(run.x_m[-1])) if len(run.x_m) else None,
    )


def _screened(run: Run, rules: Screening, notes: list[str]) -> ScreenedRun:
    if not KINDS[run.plan.kind].has_constant_speed:
        reasons = [*_integrity(run, slice(0, None), rules), *motion_reasons(run, rules)]
        return ScreenedRun(run, _in_order(reasons), None, (*notes, *motion_notes(run)))
    section = at_reference(run)
    window = steady_window(run, section, rules)
    long_enough = window_length_s(run, window) >= rules.min_window - ROUNDING
    means = window_means(run, window) if long_enough else None
    reasons = [*_integrity(run, window if long_enough else section, rules)]
    if not long_enough:
        reasons.append(_too_short(run, section, window, rules))
        if run.plan.motion is None:
            reasons += _ripple(run, section, rules)
    reasons += _motion(run, section, window if long_enough else section, rules)
    if long_enough:
        reasons += _steadiness(run, window, means, rules)
    lost = run.missing_records
    if lost and not any(reason.startswith("gapped") for reason in reasons):
        notes.append(f"{lost} records are missing outside the steady window")
    work_j = None if run.plan.positions_m is None else _stroke_work(run, rules)
    return ScreenedRun(run, _in_order(reasons), means, tuple(notes), work_j)


def _in_order(reasons: list[str]) -> tuple[str, ...]:
    """Sort reasons, without the short log of a run that ended early: the end is its cause."""
    codes = [reason.split(":")[0] for reason in reasons]
    left_out = {caused for code in codes for caused in _CAUSED.get(code, ())}
    kept = [each for each in zip(codes, reasons, strict=True) if each[0] not in left_out]
    return tuple(reason for _, reason in sorted(kept, key=lambda each: CODES.index(each[0])))


def _with_values(run: Run) -> tuple[Run, list[str]]:
    """Leave out empty channels and samples without friction, and return notes on them.

    A channel that is NaN throughout is taken as not measured.
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
    names = ("t_s", "x_m", *friction_channels(run))
    needed = [channels[name] for name in names if getattr(run, name) is not None]
    known = np.logical_and.reduce([np.isfinite(values) for values in needed])
    if known.all():
        return run, notes
    kept: dict[str, Any] = {
        name: values[known] for name, values in channels.items() if name not in empty
    }
    missing = f"{np.sum(~known)} of {len(known)} samples"
    note = f"{missing} without time, position, pressure or force left out"
    return replace(run, **kept), [*notes, note]


def _integrity(run: Run, window: slice, rules: Screening) -> Iterator[str]:
    """Yield the reasons found in the log, not in the motion."""
    if run.aborted:
        yield f"aborted: {run.aborted}"
    if run.truncated:
        yield from _of_log(run.truncated)
    missing = missing_friction_channels(run)
    if KINDS[run.plan.kind].is_at_rest:
        missing = [name for name in missing if name != "f_applied_n"]
    if missing:
        yield f"missing_channel: friction needs {listed(missing)}"
    steps = np.diff(run.t_s[window])
    if len(steps):
        lost = int(np.sum(np.rint(steps / np.median(steps)) - 1)) if run.missing_records else 0
        if lost > 0:
            planned = len(steps) + 1 + lost
            yield f"gapped: {lost} of {planned} records of the window are missing (none may be)"
        elif exceeds(np.median(steps), rules.max_gap):
            yield (
                f"gapped: the log has a sample every {np.median(steps):.2f} s; limit "
                f"{rules.max_gap:g} s (screening.max_gap)"
            )
        elif exceeds(steps.max(), rules.max_gap):
            yield (
                f"gapped: {steps.max():.2f} s between two samples of the window; "
                f"limit {rules.max_gap:g} s"
            )
    if KINDS[run.plan.kind].needs_supply_off:
        return  # a vented transducer may show its lowest value, which zero_check.py reports
    yield from saturation_reasons(
        "sensor_saturated", run.sensor_saturated, window, saturated_sensors(run, window)
    )


def _of_log(faults: str) -> Iterator[str]:
    """Yield a reason for each kind of fault of a log, the most fundamental first."""
    kinds: dict[str, list[str]] = {}
    code = "truncated"
    for part in faults.split("; "):
        before, _, words = part.partition(": ")
        code, text = (before, words) if before in _OF_LOG else (code, part)
        kinds.setdefault(code, []).append(text)
    yield from (f"{code}: {'; '.join(kinds[code])}" for code in _OF_LOG if code in kinds)


def _motion(run: Run, section: slice, window: slice, rules: Screening) -> Iterator[str]:
    """Yield the reasons found in the piston's position and the valve."""
    standing = 0.0 if run.at_reference is None else standstill_s(run, section)
    if at_end := list(end_stop_reasons(run.x_m[window], run, rules)):
        yield from at_end
    elif standing >= _STANDSTILL_S:
        yield (
            f"stalled: the piston rests at {1e3 * run.x_m[section][-1]:.1f} mm for the last "
            f"{standing:.2f} s while the reference continues; limit {_STANDSTILL_S:g} s"
        )
    yield from saturation_reasons(
        "valve_saturated", run.valve_saturated, window, saturated_valves(run, window)
    )


def _steadiness(
    run: Run, window: slice, means: SteadyMeans | None, rules: Screening
) -> Iterator[str]:
    """Yield the reasons found in speed and friction over the window."""
    t, x, v_ref = run.t_s[window], run.x_m[window], run.plan.v_ref_m_s
    v = mean_speed(t, x)
    limit = rules.speed_limit(v_ref)
    if abs(v - v_ref) > limit + ROUNDING * abs(v_ref):
        yield (
            f"off_reference: mean speed {1e3 * v:.2f} mm/s deviates by "
            f"{1e3 * abs(v - v_ref):.2f} mm/s from the reference {1e3 * v_ref:.2f} mm/s; "
            f"limit {1e3 * limit:.2f} mm/s"
        )
    # Noise widens the limit of the ripple: it is computed only where that matters.
    beyond = means and exceeds(means.v_ripple_m_s or 0.0, rules.ripple_limit(v_ref))
    varies = list(_ripple(run, window, rules)) if beyond else []
    yield from varies
    yield from oscillation_of_velocity(run, window, rules)
    if not varies:
        yield from oscillation_of_position(run, window, rules)
    if means is None or means.friction_n is None:
        return
    f_applied = run.channel("f_applied_n")[window]
    # A board of hbench controls the load itself; in other logs it may come late.
    step = load_step(f_applied) if run.plan.motion is None else 0.0
    limit = max(rules.friction_drift, rules.friction_drift_relative * abs(np.mean(f_applied)))
    if exceeds(abs(step), limit):
        yield f"not_steady: the load changes by {step:+.0f} N in the window; limit {limit:.0f} N"
    friction = test_force(run, window) - f_applied
    limit = max(rules.friction_drift, rules.friction_drift_relative * abs(means.friction_n))
    if exceeds(abs(means.far_shift_n), limit):
        yield (
            f"not_steady: {means.far_samples} of {len(friction)} samples are far from all others "
            f"and change mean friction by {means.far_shift_n:+.0f} N; limit {limit:.0f} N"
        )
    change = drift(t, friction)
    is_drift = exceeds(abs(change.value), limit + _DRIFT_ERRORS * change.se)
    if is_drift and exceeds(abs(line_change(t, friction)), limit):
        yield (
            f"not_steady: friction drifts by {change.value:+.0f} N (standard error "
            f"{change.se:.0f} N) over the window; limit {limit:.0f} N"
        )


def _ripple(run: Run, window: slice, rules: Screening) -> Iterator[str]:
    t, x = run.t_s[window], run.x_m[window]
    foreign = run.plan.motion is None
    ripple = speed_ripple(t, x, noise_over_motion(run.t_s, run.x_m) if foreign else np.inf)
    limit = rules.ripple_limit(run.plan.v_ref_m_s)
    largest = float(np.hypot(limit, ripple.noise_m_s))
    if exceeds(ripple.total_m_s, largest):
        step_m = resolution(run.x_m) if foreign else 0.0
        by_steps = ripple.total_m_s <= np.hypot(largest, step_m / 2 / BLOCK_S)
        cause = f", as the steps of {1e3 * step_m:.2g} mm in the position cause" if by_steps else ""
        yield (
            f"not_steady: speed over 0.1 s varies by {1e3 * ripple.total_m_s:.2f} mm/s (standard "
            f"deviation){cause}; limit {1e3 * limit:.2f} mm/s and {1e3 * ripple.noise_m_s:.2f} "
            "mm/s noise"
        )


def _too_short(run: Run, section: slice, window: slice, rules: Screening) -> str:
    limit = f"limit {rules.min_window:g} s"
    reached = run.t_s[section]
    if not len(reached):
        return f"too_short: the reference speed was never reached, so there is no window; {limit}"
    return (
        f"too_short: the steady window has {window_length_s(run, window):.2f} s of "
        f"{reached[-1] - reached[0]:.2f} s at the reference, after settling for "
        f"{rules.settle_time:g} s and {1e3 * rules.settle_travel:g} mm; {limit}"
    )


def window_means(run: Run, window: slice) -> SteadyMeans:
    """Average a window of steady speed: friction by 5.1, which is 2.12 without acceleration."""
    t = run.t_s[window]
    v = mean_speed(t, run.x_m[window])
    means = {name: _mean(getattr(run, name), window) for name in friction_channels(run)}
    p_tp, p_tr, f_applied = means.get("p_tp_pa"), means.get("p_tr_pa"), means["f_applied_n"]
    missing = missing_friction_channels(run)
    driven = not {"p_tp_pa", "p_tr_pa"} & set(missing)
    f_test = float(np.mean(test_force(run, window))) if driven else None
    friction = efficiency = None
    far = Outliers(0, 0.0)
    if f_test is not None and f_applied is not None:
        friction = f_test - f_applied
        specimen = run.plan.specimen
        efficiency = efficiency_of(SteadyForces(v, f_applied, p_tp, p_tr, specimen, f_test))
        far = far_samples(run, window, friction)
    return SteadyMeans(
        t_start_s=float(t[0]),
        t_stop_s=float(t[-1]),
        n=len(t),
        v_m_s=v,
        friction_n=friction,
        f_test_n=f_test,
        f_applied_n=f_applied,
        p_tp_pa=p_tp,
        p_tr_pa=p_tr,
        efficiency=efficiency,
        v_ripple_m_s=speed_ripple(t, run.x_m[window]).total_m_s or None,
        u_steps={} if friction is None else rounding_errors(run, window, friction),
        far_samples=far.samples,
        far_shift_n=far.shift,
        **{name: _known_mean(getattr(run, name), window) for name in TEMPERATURES},
    )


def _stroke_work(run: Run, rules: Screening) -> float | None:
    """Return the work against friction [J] over the whole stroke, the integral of F_fT dx.

    F_T - F_applied contains the inertia too, whose work is zero from rest to rest. None if the log
    of the stroke is not complete.
    """
    whole = slice(0, None)
    if any(_integrity(run, whole, rules)):
        return None
    return _work(run)


def _work(run: Run) -> float:
    """Return the integral of F_T - F_applied over the distance of a run [J]."""
    force = friction_with_inertia(run)
    return float((force[1:] + force[:-1]) @ np.diff(run.x_m) / 2)


def _mean(values: np.ndarray | None, window: slice) -> float | None:
    return None if values is None else float(np.mean(values[window]))


def _known_mean(values: np.ndarray | None, window: slice) -> float | None:
    """Return the mean of the samples with a value; None if there are none."""
    known = np.zeros(0) if values is None else values[window][np.isfinite(values[window])]
    return float(np.mean(known)) if len(known) else None
