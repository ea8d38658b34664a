"""Screening rules of non-steady runs, for each kind.

    ramp, verification  the speed followed its reference; no valve at its limit, so that the load
                        was controlled
    triangle            the speed followed its reference over a whole cycle at least. A load valve
                        may be fully open: the source connects the load cylinder to the tank
                        (section 5.2)
    steps               each level was reached and kept in the second half of its time; the step
                        itself drives the valve to its limit
    hold                the piston was at rest
    check               the piston was at rest with the supply off, and the pressures were level
    breakaway           the piston moved off before the push ended, and friction passed a maximum

The reference is compared with the position's speed over 0.1 s, as for steady runs.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from hbench.analysis.rounding import ROUNDING, exceeds
from hbench.analysis.screening.friction_channels import (
    friction_with_inertia,
    missing_friction_channels,
)
from hbench.analysis.screening.push_peak import first_peak, least_fall
from hbench.analysis.screening.reference_sections import level_windows, whole_cycles
from hbench.analysis.screening.saturation import saturated_valves, saturation_reasons
from hbench.analysis.screening.steadiness import speeds_over_tenths
from hbench.analysis.screening.zero_check import CHAMBERS, closed_part
from hbench.config.schedule import Screening
from hbench.motion.speeds import mean_speed
from hbench.records import KINDS, SIGNS, Run

_REACHED = 0.98  # of a ramp's top speed
_NEAR_END_M = 0.005
_LAST_S = 0.03  # a push that takes the whole time but this has not moved the piston
_LEVEL_PA = 1e4  # change of a vented chamber's pressure
# Of a supply that is off, with the tank's pressure and a zero error; the board's limit too, as
# venting begins (firmware/core/vent.c).
SUPPLY_OFF_PA = 10e5


def motion_reasons(run: Run, rules: Screening) -> list[str]:
    """Return the reasons to reject a non-steady run, except those of its log's integrity."""
    if len(run.t_s) < 2:
        return ["too_short: the log has fewer than 2 records; limit 2"]
    rule = RULES[KINDS[run.plan.kind].screening]
    return [*end_stop_reasons(run.x_m, run, rules), *rule(run, rules)]


def motion_notes(run: Run) -> list[str]:
    """Return the notes on a non-steady run."""
    kind, notes = KINDS[run.plan.kind], []
    if run.v_ref_m_s is None and not kind.is_at_rest:
        notes.append("the reference was not logged: deviations from it are not checked")
    count = 0 if run.valve_saturated is None else int(run.valve_saturated.sum())
    if count and kind.valve_may_saturate:
        notes.append(f"a valve was at its limit in {count} of {len(run.t_s)} records")
    return notes


def near_end(x_m: np.ndarray, stroke_m: float, margin_m: float) -> float | None:
    """Return the position [m] nearest to an end of the stroke, where it is within the margin."""
    low, high, least = float(x_m.min()), float(x_m.max()), margin_m + ROUNDING * stroke_m
    if low <= least:
        return low
    return high if stroke_m - high <= least else None


def end_stop_reasons(x_m: np.ndarray, run: Run, rules: Screening) -> Iterator[str]:
    """Yield the reason for positions of a run near an end of its stroke, if it is known."""
    stroke, margin = run.plan.specimen.stroke_m, rules.end_stop_margin
    if not len(x_m) or stroke is None:
        return
    if (nearest := near_end(x_m, stroke, margin)) is not None:
        yield (
            f"end_stop: the piston is at {1e3 * nearest:.1f} mm of a stroke of "
            f"{1e3 * stroke:g} mm; limit {1e3 * margin:g} mm from either end"
        )


def _follows_reference(run: Run, rules: Screening) -> Iterator[str]:
    if run.v_ref_m_s is None:
        return
    t = run.t_s
    reference_m = np.concatenate(
        ([0.0], np.cumsum(np.diff(t) * (run.v_ref_m_s[1:] + run.v_ref_m_s[:-1]) / 2))
    )
    error = speeds_over_tenths(t, run.x_m).v_m_s - speeds_over_tenths(t, reference_m).v_m_s
    if not len(error):
        return
    rms = float(np.sqrt(np.mean(error**2)))
    limit = max(rules.tracking_error, rules.tracking_error_relative * np.abs(run.v_ref_m_s).max())
    if exceeds(rms, limit):
        yield (
            f"off_reference: the speed over 0.1 s deviates from its reference by "
            f"{1e3 * rms:.2f} mm/s (root mean square); limit {1e3 * limit:.2f} mm/s"
        )


def _valve_limits(run: Run) -> Iterator[str]:
    whole = slice(0, None)
    valves = saturated_valves(run, whole)
    yield from saturation_reasons("valve_saturated", run.valve_saturated, whole, valves, "run")


def _complete_ramp(run: Run, rules: Screening) -> Iterator[str]:
    yield from _follows_reference(run, rules)
    yield from _valve_limits(run)
    motion, top = run.plan.motion, abs(run.plan.v_ref_m_s)
    if run.v_ref_m_s is None or motion is None:
        return
    reached = np.abs(run.v_ref_m_s).max()
    end = motion.x_max_m if run.plan.v_ref_m_s > 0 else motion.x_min_m
    if reached < _REACHED * top and abs(run.x_m[-1] - end) > _NEAR_END_M:
        yield (
            f"incomplete: the ramp ended at {1e3 * reached:.1f} of {1e3 * top:.1f} mm/s and at "
            f"{1e3 * run.x_m[-1]:.1f} mm, before the end of its travel; limit "
            f"{100 * _REACHED:g} % or {1e3 * _NEAR_END_M:g} mm"
        )


def _tracking(run: Run, rules: Screening) -> Iterator[str]:
    yield from _follows_reference(run, rules)
    yield from _valve_limits(run)


def _whole_cycles(run: Run, rules: Screening) -> Iterator[str]:
    yield from _follows_reference(run, rules)
    if run.v_ref_m_s is not None and not whole_cycles(run.v_ref_m_s):
        yield "incomplete: the triangle ended within its first cycle; limit 1 cycle"


def _settled_levels(run: Run, rules: Screening) -> Iterator[str]:
    if run.v_ref_m_s is None:
        return
    for number, (level, settled) in enumerate(level_windows(run), start=1):
        if settled.stop - settled.start < 3:
            yield f"incomplete: level {number} has fewer than 3 settled records; limit 3"
            continue
        v, limit = mean_speed(run.t_s[settled], run.x_m[settled]), rules.speed_limit(level)
        if abs(v - level) > limit + ROUNDING * abs(level):
            yield (
                f"off_reference: level {number} has {1e3 * v:.2f} mm/s instead of "
                f"{1e3 * level:.2f} mm/s; limit {1e3 * limit:.2f} mm/s"
            )
        if run.valve_saturated is not None and run.valve_saturated[settled].any():
            valves = saturated_valves(run, settled)
            where = ", ".join(filter(None, (valves, f"in the settled half of level {number}")))
            yield f"valve_saturated: {where} (no record allowed)"


def _rest(run: Run, rules: Screening) -> Iterator[str]:
    moved = float(np.ptp(run.x_m))
    if exceeds(moved, rules.rest_travel):
        yield (
            f"off_reference: the piston moved by {1e3 * moved:.2f} mm with its valves closed; "
            f"limit {1e3 * rules.rest_travel:g} mm"
        )
    length = run.t_s[-1] - run.t_s[0] - rules.settle_time
    if length < rules.min_window - ROUNDING:
        yield f"too_short: {max(length, 0):.2f} s at rest; limit {rules.min_window:g} s"


def _moved_off(run: Run, rules: Screening) -> Iterator[str]:
    yield from _valve_limits(run)
    forward = SIGNS[run.plan.direction]
    moved_mm = 1e3 * forward * float(run.x_m[-1] - run.x_m[0])
    segments = run.plan.motion.segments if run.plan.motion else ()
    for push in segments[:1]:
        if run.t_s[-1] - run.t_s[0] > push.duration_s - _LAST_S:
            yield (
                f"incomplete: the piston moved by {moved_mm:.2f} mm while the force rose by "
                f"{abs(push.force_rate_n_s) * push.duration_s:.6g} N, its limit (rise); it should "
                f"move by {1e3 * push.displacement_m:g} mm"
            )
            return
    if not missing_friction_channels(run):
        friction = forward * (friction_with_inertia(run))
        if first_peak(friction) is None:
            yield (
                f"incomplete: friction had not fallen from a maximum when the piston had moved by "
                f"{moved_mm:.2f} mm; it must fall by {least_fall(friction):.3g} N (increase "
                "displacement)"
            )


def _levelled(run: Run, rules: Screening) -> Iterator[str]:
    closed = closed_part(run)
    if len(run.t_s[closed]) < 2:
        yield "too_short: fewer than 2 records with settled, closed valves; limit 2"
        return
    yield from _rest(replace(run, x_m=run.x_m[closed]), rules)
    supply = None if run.p_s_pa is None else float(run.p_s_pa[closed].mean())
    if supply is not None and supply > SUPPLY_OFF_PA:
        yield (
            f"not_steady: the supply was on, {supply / 1e5:.1f} bar; limit "
            f"{SUPPLY_OFF_PA / 1e5:g} bar"
        )
    for channel in CHAMBERS:
        if (values := getattr(run, channel)) is None:
            continue
        change = float(values[closed][-1] - values[closed][0])
        if abs(change) > _LEVEL_PA:
            yield (
                f"not_steady: {channel.removesuffix('_pa')} changed by {change / 1e5:.2f} bar with "
                f"the valves closed; limit {_LEVEL_PA / 1e5:g} bar (vent longer)"
            )


RULES: dict[str, Callable[[Run, Screening], Iterator[str]]] = {
    "complete_ramp": _complete_ramp,
    "tracking": _tracking,
    "whole_cycles": _whole_cycles,
    "settled_levels": _settled_levels,
    "rest": _rest,
    "moved_off": _moved_off,
    "levelled": _levelled,
}
