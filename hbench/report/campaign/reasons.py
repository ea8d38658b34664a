"""Codes of the reasons for rejection: how often each occurs, and the cause to look for."""

import re
from collections import Counter
from collections.abc import Mapping

from hbench.records import KINDS, Results, RunPlan, ScreenedRun
from hbench.report.render.numbers import short

# What to look for, by the code of the reason.
CAUSES = {
    "aborted": "the fault or the stop that its reason states",
    "unfinished": "an interruption or a crash of hbench; hbench run --resume repeats the run",
    "missing": "a log deleted or not copied, to be restored",
    "unreadable": "a damaged log or an incomplete copy, to be restored",
    "truncated": "an incomplete copy of the log, or a lost connection to the board",
    "changed": "a log edited or damaged after its run, to be restored",
    "copy": "a file copied under another name: give the file of each trial",
    "missing_channel": "a sensor that is not logged, or not named in the map",
    "gapped": "a connection too slow for the log (--baud), or a logger that loses samples; for one "
    "that samples slowly state a larger screening.max_gap",
    "sensor_saturated": "a sensor whose range is too small, a broken wire, or a wrong zero",
    "too_short": "too little travel or acceleration for this speed",
    "incomplete": "too little travel, or too small a force, for the motion to end as planned",
    "end_stop": "a travel too near an end of the stroke, or a wrong zero of the position sensor",
    "stalled": "an obstruction inside the cylinder, an end stop of unknown position, or too little "
    "force",
    "valve_saturated": "too low a supply pressure, or too small a valve, for this speed and load",
    "off_reference": "gains of the velocity controller (hbench design), or a low supply pressure",
    "not_steady": "air in the oil, stick-slip, or gains of the controllers that are too high",
}
_AT_REST = {  # of runs with closed valves
    "off_reference": "valves that leak or are not closed, or a load that moves the piston; where "
    "the leakage itself moves it, state a larger screening.rest_travel",
}
_PUSHED = {  # of a breakaway
    "incomplete": "a friction that did not pass its maximum while the force rose: state a larger "
    "displacement, or a larger rise where the piston did not move; seals whose friction does not "
    "fall after the start have no breakaway to measure",
}
_IMPORTED = {  # of another bench's logs
    "missing_channel": "a sensor that is not logged, or not named in the map; a known value can "
    "replace it under constants (p_tr_pa: 0 bar for a side open to the air), and the force of a "
    "drive without pressures is f_drive_n",
    "sensor_saturated": "a sensor whose range is too small, a broken wire, a wrong zero, or a "
    "number that the logger writes where it has no value, such as -9999: leave these cells empty",
    "too_short": "too little travel for this speed; state a shorter screening.settle_time and "
    "screening.min_window for fast strokes, a shorter screening.settle_travel for short ones",
    "not_steady": "air in the oil, stick-slip, a position that is rounded to few digits, or a load "
    "that comes late or changes along the stroke; if it is meant to, as that of a spring, state a "
    "larger screening.friction_drift_relative in the map",
    "off_reference": "a speed in the map or in the names of the files that is not that of the "
    "motion; where the bench does not keep its speed, state a larger "
    "screening.low_speed_error_relative (default 3 %) in the map",
}
_ABORTED, _UNFINISHED = "aborted", "unfinished"  # codes of the reasons
_NO_REASON = "No fault is recorded: the campaign was interrupted, or is still running."
_BY_OPERATOR = "interrupted by the operator"
_OF_COMPLETED = "All numbers are those of the completed runs."


def reason_counts(results: Results) -> Counter[str]:
    """Count the runs of each reason's code; a run with two reasons counts under both."""
    codes = (dict.fromkeys(map(code_of, run.reasons)) for run in results.runs)
    return Counter(code for run_codes in codes for code in run_codes)


def cause_of(results: Results, code: str) -> str:
    """Return what to look for where runs were rejected for a reason; empty: nothing is known."""
    rejected = [run for run in results.runs if code in map(code_of, run.reasons)]
    if code in _AT_REST and all(KINDS[run.run.plan.kind].is_at_rest for run in rejected):
        return _AT_REST[code]
    if code in _PUSHED and all(
        KINDS[run.run.plan.kind].analysis == "breakaway" for run in rejected
    ):
        return _PUSHED[code]
    if results.provenance.source == "imported" and code in _IMPORTED:
        return _IMPORTED[code]
    return CAUSES.get(code, "")


def code_of(reason: str) -> str:
    """Return the code in "code: words with value and limit"."""
    return reason.partition(":")[0].strip()


def aborted_words(results: Results) -> str:
    """Return why a campaign ended before its plan did; empty if it was completed."""
    complete = results.quality.completeness
    if not complete.not_completed or complete.planned is None:
        return ""
    made = complete.planned - len(complete.not_completed)
    count = f"{made} of {complete.planned} planned runs were completed"
    last = results.runs[-1] if results.runs else None
    if last is not None and _begins_with(last, _UNFINISHED):
        cause = f"hbench ended during run {last.run.plan.run}, or is still making it."
        return f"INCOMPLETE CAMPAIGN: {count}. {cause} {_OF_COMPLETED}"
    if last is None or not is_aborted(last):
        return f"INCOMPLETE CAMPAIGN: {count}. {_NO_REASON} {_OF_COMPLETED}"
    reason = last.reasons[0].partition(":")[2].strip().removeprefix(f"run {last.run.plan.run}: ")
    why = _with_values(reason, results.provenance.settings.get("limits") or {})
    run = f"Run {last.run.plan.run} ({_motion(last.run.plan)})"
    return f"ABORTED CAMPAIGN: {count}. {run} ended early: {why}. {_OF_COMPLETED}"


def stopped_by_fault(results: Results) -> bool:
    """Return whether a fault ended the last run of an incomplete campaign, not the operator."""
    if not aborted_words(results) or not results.runs:
        return False
    last = results.runs[-1]
    return _begins_with(last, _ABORTED) and _BY_OPERATOR not in last.reasons[0]


def _with_values(reason: str, limits: Mapping[str, object]) -> str:
    """Write the value of each limit of the bench file behind its name."""

    def value(found: re.Match[str]) -> str:
        known = limits.get(found[1])
        return found[0] if known is None else f"{known} ({found[0]})"

    return re.sub(r"limits\.(\w+)", value, reason)


def _motion(plan: RunPlan) -> str:
    """Write what a run was to do, such as ``steady, −50 mm/s, −5000 N``."""
    speed = f"{short(1e3 * plan.v_ref_m_s)} mm/s" if plan.v_ref_m_s else ""
    load = "" if plan.f_load_n is None else f"{short(plan.f_load_n)} N"
    return ", ".join(filter(None, (plan.kind, speed, load)))


def is_aborted(run: ScreenedRun) -> bool:
    """Return whether a run was ended before its plan; screening names this reason first."""
    return _begins_with(run, _ABORTED) or _begins_with(run, _UNFINISHED)


def _begins_with(run: ScreenedRun, code: str) -> bool:
    return any(code_of(reason) == code for reason in run.reasons[:1])
