"""Verdict on a campaign's data, its meaning for a decision, and what improves the data."""

from hbench.records import Quality, QualityCheck
from hbench.report.campaign.quality.completeness import incomplete_words
from hbench.report.campaign.quality.finding import is_without_trial, reason
from hbench.report.campaign.quality.plausibility import contradictions
from hbench.report.quality_words import NAMES, STEPS
from hbench.report.render.numbers import number
from hbench.sentences import capital, plural

RULE = (
    "Each check is good, to be used with care, or poor; the verdict is the worst of them. The "
    "limits are hbench's own; no standard sets them. Each fit has its own verdict."
)
_OF_FORCES = frozenset(
    "plausible_signs load_direction load_balance equal_directions constant_force".split()
)
_NO_TOLERANCES = "state the tolerances of the sensors in the {file}"
_ALL_IMPLAUSIBLE = (
    "if the position falls while the cylinder extends, turn its sign (scale: -1 in a map); if not, "
    "check which pressure is that of the piston side, the sign of the load cell, the zeros and the "
    "areas of the cylinder"
)
_CONTINUE = (
    "Continue the campaign: repeat its command with --resume, bench file and schedule unchanged"
)


def quality_verdict(
    quality: Quality, count_runs: bool = True, stated: bool = False, below: bool = True
) -> str:
    """Return the verdict in a few sentences; an incomplete campaign is reported first.

    Points without enough trials of a complete one are reported after what makes the data poor.

    Without ``count_runs`` it is not, where a page's alarm counts the completed runs and states
    that the numbers are theirs. U and a possible drift that are ``stated`` before are not repeated.
    ``below`` refers to the campaign's numbers, which follow.
    """
    worst = _worst(quality)
    incomplete = incomplete_words(quality.completeness) if count_runs else ""
    other = "completed runs" if quality.completeness.not_completed else "other points"
    named = [
        check
        for check in worst
        if not (incomplete and is_without_trial(check))  # not twice
        if count_runs or check.name != "complete"
    ]
    faults = [reason(check, stated) for check in named if not (stated and check.drift is not None)]
    reasons = ". ".join(map(capital, faults))
    if quality.grade == "good":
        count = "both" if len(quality.checks) == 2 else f"all {len(quality.checks)}"
        verdict = f"The data is good: {count} checks of its quality pass."
        if len(quality.checks) == 1:
            name = NAMES[quality.checks[0].name].lower()
            verdict = f"Only one check of quality applies to these runs, and it passes: {name}."
    elif quality.grade == "with care":
        verdict = f"Use the data with care. {reasons}." if reasons else "Use the data with care."
    elif all(check.name == "complete" or is_without_trial(check) for check in worst):
        why = f"{reasons}." if reasons else ""
        numbers = f"The numbers below are those of the {other}." if count_runs and below else ""
        doubts = _doubts(quality)
        care = f"Use these with care. {'. '.join(capital(reason(c)) for c in doubts)}."
        parts = "The data is poor.", why, numbers, care if numbers and doubts else ""
        verdict = " ".join(filter(None, parts))
    else:
        why = f" {reasons}." if reasons else ""
        rely = "; do not rely on the numbers below" if below else ""
        verdict = f"The data is poor{rely}.{why}"
        if not quality.completeness.not_completed:
            incomplete, verdict = verdict, incomplete  # all runs were made, but rejected
    return " ".join(filter(None, (incomplete, verdict, contradictions(quality.implausible))))


def quality_count(quality: Quality) -> str:
    """Count the checks that are good."""
    good = sum(check.grade == "good" for check in quality.checks)
    return f"{good} of {len(quality.checks)} checks {plural(good, 'is', 'are')} good"


def grade_words(quality: Quality) -> str:
    """Write the grade of the data, and what the worst checks found."""
    worst = map(reason, _worst(quality))
    return f"data rated '{quality.grade}'; {'; '.join(worst)}"


def weak_checks(quality: Quality) -> str:
    """Name the checks that give the data its grade, with commas between; empty if it is good."""
    worst = _worst(quality) if quality.grade != "good" else []
    return ", ".join(NAMES[check.name].lower() for check in worst)


def _worst(quality: Quality) -> list[QualityCheck]:
    return [check for check in quality.checks if check.grade == quality.grade]


def _doubts(quality: Quality) -> list[QualityCheck]:
    """Return errors of the forces that may be the cause of rejected runs, where these make it poor.

    Limits of screening are shares of friction, which such an error changes.
    """
    if quality.completeness.not_completed or not all(map(is_without_trial, _worst(quality))):
        return []
    return [c for c in quality.checks if c.grade == "with care" and c.name in _OF_FORCES]


def instruments_percent(quality: Quality) -> str:
    """Return the uncertainty of friction (95 %) by the instruments alone; empty if not known."""
    known = (check.value for check in quality.checks if check.name == "instruments")
    return "".join(number(value, 0) for value in known if value is not None)


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


def _is_in_u(check: QualityCheck) -> bool:
    """Return whether U contains what a check grades."""
    if check.name == "instruments":
        return check.value is not None
    if check.drift is not None:
        return check.drift.separated
    return check.name == "repeatability"


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
    largest = f"with the largest parts of the uncertainty ({parts})"
    sensors = largest if parts else "of pressure and force"  # parts of breakaway are not known
    steps = [
        _step(check).format(sensors=sensors, file=file)
        for check in (*_doubts(quality), *_worst(quality))
        if check.grade != "good" and check.name not in missing
        if not (beyond_u and _is_in_u(check))
    ]
    if aborted:
        first = [f"before the next campaign, {step}" for step in steps[:1]]
        steps = [_CONTINUE, *first, *steps[1:]]
    return " ".join(f"{capital(step)}." for step in steps)


def _step(check: QualityCheck) -> str:
    """Return what improves a check; tolerances that are not known are stated first.

    Friction that drives at all points is that of a position of the wrong sign.
    """
    unknown = check.name == "instruments" and check.value is None
    if check.name == "plausible_signs" and check.count == check.of:
        return _ALL_IMPLAUSIBLE
    if check.drift is not None and not check.drift.significant:
        return STEPS["possible_drift"]
    return _NO_TOLERANCES if unknown else STEPS[check.name]
