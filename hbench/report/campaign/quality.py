"""The verdict on a campaign's data in words: its checks as tables and as a sentence."""

from collections.abc import Sequence

from hbench.records import Completeness, ImplausiblePoint, PointTrials, Quality, QualityCheck
from hbench.report.campaign.page_tables import WHO, table, who
from hbench.report.campaign.series_words import load_words
from hbench.report.drift import drift_finding, drift_words
from hbench.report.quality_words import LIMITS, NAMES, STEPS
from hbench.report.render.numbers import number, short, significant, with_interval
from hbench.report.render.symbols import capital
from hbench.report.render.word_tables import Cell, Table

RULE = (
    "Each check is good, to be used with care, or poor; the verdict is the worst of them. The "
    "limits are hbench's own; no standard sets them. Each fit has its own verdict."
)
_NO_TOLERANCES = "state the tolerances of the sensors in the {file}"
_CONTINUE = (
    "Continue the campaign: repeat its command with --resume, bench file and schedule unchanged"
)
_HEAD = ("Check", "Verdict", "Found", "Limits")
_NAMED = 3  # points in a sentence
_WRONG_SIGN = "friction has the direction of the motion, or the efficiency is above 100 %"


def quality_count(quality: Quality) -> str:
    """Count the checks that are good."""
    good = sum(check.grade == "good" for check in quality.checks)
    return f"{good} of {len(quality.checks)} checks {'is' if good == 1 else 'are'} good"


def next_step(
    quality: Quality,
    parts: str,
    aborted: bool = False,
    imported: bool = False,
    beyond_u: bool = False,
) -> str:
    """Return what improves the worst checks; empty if all are good.

    ``parts`` names the largest parts of the uncertainty and their table, as far as known. An
    ``aborted`` campaign is continued first, which makes its missing runs and trials; --resume
    refuses another bench file or schedule, so what changes them comes afterwards. The tolerances
    of an ``imported`` campaign are stated in its map. With ``beyond_u`` the steps are those of
    what U does not contain.
    """
    missing = ("complete", "trials_per_point") if aborted else ()
    file = "map, then import again" if imported else "bench file"
    if not quality.completeness.not_completed:
        missing = (*missing, "complete")  # no run is missing, but trials are
    steps = [
        _step(check).format(parts=f" ({parts})" if parts else "", file=file)
        for check in _worst(quality)
        if check.grade != "good" and check.name not in missing
        if not (beyond_u and _is_in_u(check))
    ]
    if aborted:
        first = [f"before the next campaign, {step}" for step in steps[:1]]
        steps = [_CONTINUE, *first, *steps[1:]]
    return " ".join(f"{capital(step)}." for step in steps)


def _step(check: QualityCheck) -> str:
    """Return what improves a check; tolerances that are not known are stated first."""
    unknown = check.name == "instruments" and check.value is None
    if check.drift is not None and not check.drift.significant:
        return STEPS["possible_drift"]
    return _NO_TOLERANCES if unknown else STEPS[check.name]


def decision_reserve(quality: Quality, complete_u: str) -> str:
    """State a reservation on the data, and which U contain it; empty without one.

    ``complete_u`` names the U that contain the instruments; empty if none does.
    """
    worst = _worst(quality)
    if quality.grade == "good" or not worst:
        return ""
    outside = [check for check in worst if not _is_in_u(check)]
    if not complete_u or len(outside) == len(worst):
        in_u = "U does not take this into account"
    elif outside:
        in_u = f"{complete_u} takes only a part of this into account"
    else:
        in_u = f"{complete_u} takes this into account"
    if quality.grade == "poor":
        return f"The data is poor ({weak_checks(quality)}); do not rely on the decision. {in_u}."
    return f"Use the data with care ({weak_checks(quality)}); {in_u}."


def weak_checks(quality: Quality) -> str:
    """Name the checks that give the data its grade, with commas between; empty if it is good."""
    worst = _worst(quality) if quality.grade != "good" else []
    return ", ".join(NAMES[check.name].lower() for check in worst)


def _worst(quality: Quality) -> list[QualityCheck]:
    return [check for check in quality.checks if check.grade == quality.grade]


def _is_in_u(check: QualityCheck) -> bool:
    """Return whether U contains what a check grades."""
    if check.name == "instruments":
        return check.value is not None
    if check.drift is not None:
        return check.drift.separated
    return check.name == "repeatability"


def instruments_percent(quality: Quality) -> str:
    """Return the uncertainty of friction (95 %) by the instruments alone; empty if not known."""
    known = (check.value for check in quality.checks if check.name == "instruments")
    return "".join(number(value, 0) for value in known if value is not None)


def quality_table(quality: Quality) -> Table:
    """Return a row for each check."""
    rows = tuple(
        (Cell(NAMES[check.name]), _grade(check), Cell(value), Cell(_limits(check)))
        for check, value in ((check, _found(check, quality)) for check in quality.checks)
    )
    return Table(_HEAD, rows, frozenset(_HEAD), title="Checks of the data")


def short_point_table(points: Sequence[PointTrials]) -> Table:
    """Return the operating points with fewer accepted trials than planned."""
    rows = [
        (*who(point), _reference(point), f"{point.accepted} of {point.planned}")
        for point in sorted(points, key=_in_order)
    ]
    return table((*WHO, "Reference (mm/s)", "Accepted trials"), rows)


def _in_order(point: PointTrials) -> tuple:
    """Return the place of a point in a table: by series, then by speed."""
    load, pressure, speed = (
        abs(v or 0.0) for v in (point.f_load_n, point.p_lr_ref_pa, point.v_ref_m_s)
    )
    return point.kind, point.label, point.direction, load, pressure, speed, point.dwell_s or 0.0


def _reference(point: PointTrials) -> str:
    if point.dwell_s is not None:
        return f"after {short(point.dwell_s)} s at rest"
    return number(1e3 * point.v_ref_m_s)


def implausible_table(points: Sequence[ImplausiblePoint]) -> Table:
    """Return the points whose friction or efficiency has an implausible sign."""
    rows = [
        (
            *who(point),
            number(1e3 * point.v_m_s, 2),
            _measured(point),
            "beyond its interval" if point.beyond else "within its interval",
        )
        for point in points
    ]
    return table((*WHO, "Velocity (mm/s)", "Measured", "Remark"), rows, words=("Measured",))


def quality_verdict(quality: Quality, count_runs: bool = True, stated: bool = False) -> str:
    """Return the verdict in a few sentences; an incomplete campaign is reported first.

    Points without enough trials of a complete one are reported after what makes the data poor.

    Without ``count_runs`` it is not, where a page's alarm counts the completed runs and states
    that the numbers are theirs. U and a possible drift that are ``stated`` before are not repeated.
    """
    worst = _worst(quality)
    incomplete = incomplete_words(quality.completeness) if count_runs else ""
    other = "completed runs" if quality.completeness.not_completed else "other points"
    named = [
        check
        for check in worst
        if not (incomplete and _is_without_trial(check))  # not twice
        if count_runs or check.name != "complete"
    ]
    said = [_reason(check, stated) for check in named if not (stated and check.drift is not None)]
    reasons = ". ".join(map(capital, said))
    if quality.grade == "good":
        verdict = f"The data is good: all {len(quality.checks)} checks of its quality pass."
    elif quality.grade == "with care":
        verdict = f"Use the data with care. {reasons}." if reasons else "Use the data with care."
    elif all(check.name == "complete" or _is_without_trial(check) for check in worst):
        why = f"{reasons}." if reasons else ""
        numbers = f"The numbers below are those of the {other}." if count_runs else ""
        verdict = " ".join(filter(None, ("The data is poor.", why, numbers)))
    else:
        why = f" {reasons}." if reasons else ""
        verdict = f"The data is poor; do not rely on the numbers below.{why}"
        if not quality.completeness.not_completed:
            incomplete, verdict = verdict, incomplete  # all runs were made, but rejected
    return " ".join(filter(None, (incomplete, verdict, _contradictions(quality.implausible))))


def _is_without_trial(check: QualityCheck) -> bool:
    """Return whether a point has no accepted trial."""
    return check.name == "trials_per_point" and check.value == 0


def incomplete_words(complete: Completeness) -> str:
    """Report planned runs that were not completed and points without a trial; empty without any."""
    missing = missing_words(complete)
    resume = " Continue it with --resume." if complete.not_completed else ""
    what = "The campaign is incomplete" if complete.not_completed else "Accepted trials are missing"
    return f"{what}: {missing}.{resume}" if missing else ""


def missing_words(complete: Completeness) -> str:
    """Count the runs not completed and the points without enough trials; empty if complete."""
    missing, points = len(complete.not_completed), complete.short_points
    none = sum(point.accepted == 0 for point in points)
    parts = []
    if missing:
        most = "at most " if complete.at_most else ""
        parts.append(
            f"{most}{missing} of {complete.planned} planned runs {_were(missing)} not completed"
        )
    if none:
        parts.append(f"{none} of {complete.points} points {_have(none)} no accepted trial")
    few = len(points) - none
    if parts and few:
        parts.append(f"{few} {_have(few)} fewer accepted trials than planned")
    return "; ".join(parts)


def _contradictions(points: Sequence[ImplausiblePoint]) -> str:
    """Report the points whose sign contradicts the motion beyond its interval, by name."""
    beyond = [point for point in points if point.beyond]
    if not beyond:
        return ""
    named = [f"{_where(point)}: {_measured(point)}" for point in beyond[:_NAMED]]
    more = [f"{len(beyond) - _NAMED} more"] if len(beyond) > _NAMED else []
    return (
        "Friction opposes the motion, so the instruments, their zero or an area are in error, or a "
        "load was not measured: "
        f"{'; '.join([*named, *more])}."
    )


def grade_words(quality: Quality) -> str:
    """Write the grade of the data, and what the worst checks found."""
    worst = map(_reason, _worst(quality))
    return f"data rated '{quality.grade}'; {'; '.join(worst)}"


def _reason(check: QualityCheck, stated: bool = False) -> str:
    """Write what a check found, for a sentence."""
    if check.name == "instruments" and check.value is not None:
        if stated:
            return (
                f"the tolerances of the instruments alone give ±{number(check.value, 0)} % (median)"
            )
        return f"the tolerances of the instruments{_value(check).removeprefix('their tolerances')}"
    if check.name == "complete" and check.value is not None and check.count != check.of:
        limit = f" (poor below {check.poor:g} %)" if check.grade == "poor" else ""
        return f"{number(check.value, 0)} % of the planned runs were completed{limit}"
    if _is_without_trial(check):
        return f"{check.count} {_points(check.count)} {_have(check.count or 0)} no accepted trial"
    if check.name == "runs_accepted":
        return f"{check.count} of {check.of} runs {_were(check.count or 0)} accepted"
    if check.drift is not None:
        return drift_finding(check.drift)
    return f"{NAMES[check.name].lower()}: {_value(check)}"


def _found(check: QualityCheck, quality: Quality) -> str:
    """Write what a check found, for the table; the points without a trial are counted."""
    points = quality.completeness.short_points
    none, single = (sum(point.accepted == count for point in points) for count in (0, 1))
    if check.name == "trials_per_point" and _is_without_trial(check) and single:
        return f"{_value(check)}, one at {single} {_points(single)}"
    if check.name != "complete" or not none:
        return _value(check)
    return f"{_value(check)}; {none} {_points(none)} {_have(none)} no accepted trial"


def _value(check: QualityCheck) -> str:
    if check.name == "complete":
        share = "" if check.count == check.of else f", {number(check.value)} %"
        verb = "made" if check.count == check.of else "completed"
        return f"{check.count} of {check.of} planned runs were {verb}{share}"
    if check.name == "runs_accepted":
        return f"{check.count} of {check.of}, {number(check.value)} %"
    if check.name == "trials_per_point":
        if _is_without_trial(check):
            return f"none at {check.count} {_points(check.count)}"
        single = check.value == check.poor
        return (
            "at least one point has a single trial, so no interval"
            if single
            else f"at least {check.value}"
        )
    if check.name == "repeatability":
        return f"95 % interval of the trials is ±{number(check.value)} % of friction (median)"
    if check.drift is not None:
        return drift_words(check.drift)
    if check.name == "plausible_signs":
        return _signs(check)
    if check.name == "load_direction":
        return (
            f"at all {check.count} points the load helps the motion and supplies friction, "
            f"{number(check.value)} % of it (median)"
        )
    if check.name == "load_balance":
        change = (
            f"the mean friction of both directions changes by {number(check.value)} % of the load"
        )
        wrong = ", as it does with a wrong diameter or a wrong scale of a pressure or force"
        return change if check.grade == "good" else f"{change}{wrong}"
    if check.name == "equal_directions":
        return (
            f"at {check.count} of {check.of} speeds and loads one direction has more than twice "
            "the friction of the other"
        )
    if check.name == "constant_force":
        return (
            "the mean friction of both directions is the same at all speeds and loads, "
            f"{number(check.value)} % of friction, as by a constant force that is not measured"
        )
    if check.name == "load_spread":
        return (
            f"at {check.count} of {check.of} points runs of different loads are averaged: no "
            f"nominal load separates them, and those measured differ by up to "
            f"{number(check.value)} %"
        )
    if check.name == "nominal_load":
        return (
            f"in {check.count} of {check.of} runs the load cell differs from the nominal load by "
            f"more than {check.good:g} %, by up to {number(check.value)} %"
        )
    if check.name in ("zeros", "zero_drift"):
        if check.value is None:
            return "a sensor shows its lowest value: the whole error of its zero is not known"
        what = "error" if check.name == "zeros" else "change"
        return (
            f"largest {what} {number(check.value)} % of the tolerance; {check.count} of {check.of} "
            "checked sensors beyond it"
        )
    if check.value is None:
        return "tolerances are not known"
    return (
        f"their tolerances make friction uncertain by ±{significant(check.value, 2)} % (95 %"
        f"{'' if check.of == 1 else ', median over all speeds and loads'})"
    )


def _signs(check: QualityCheck) -> str:
    if not check.value:
        return "friction opposes the motion at all points"
    if not check.count:
        return f"at {check.value} of {check.of} points {_WRONG_SIGN}, within the interval"
    return f"at {check.count} of {check.of} points {_WRONG_SIGN}, beyond the interval"


def _where(point: ImplausiblePoint) -> str:
    load = load_words(point.f_load_n, None)
    speed = f"{number(1e3 * abs(point.v_m_s))} mm/s"
    return ", ".join(filter(None, (point.label, point.direction, load, speed)))


def _measured(point: ImplausiblePoint) -> str:
    if point.quantity == "friction_n":
        return f"friction {with_interval(point.value, point.u95)} N"
    half = None if point.u95 is None else 100 * point.u95
    return f"efficiency {with_interval(100 * point.value, half)} %"


def _limits(check: QualityCheck) -> str:
    return LIMITS[check.name].format(good=check.good, poor=check.poor)


def _grade(check: QualityCheck) -> Cell:
    return Cell("good") if check.grade == "good" else Cell("", check.grade)


def _were(count: int) -> str:
    return "was" if count == 1 else "were"


def _have(count: int) -> str:
    return "has" if count == 1 else "have"


def _points(count: int | None) -> str:
    return "point" if count == 1 else "points"
