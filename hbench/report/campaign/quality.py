"""A verdict on a campaign's data: a few checks, of which the worst counts."""

from collections.abc import Iterator
from dataclasses import dataclass
from statistics import median
from typing import Literal

from hbench.records import Curve, CurvePoint, Results
from hbench.report.campaign.fit_tables import law_words
from hbench.report.render.numbers import number

Grade = Literal["good", "with care", "poor"]
GRADES: tuple[Grade, ...] = ("good", "with care", "poor")

ACCEPTED_GOOD, ACCEPTED_POOR = 95.0, 80.0  # % of the runs
TRIALS_GOOD, TRIALS_POOR = 3, 1  # of the point that has the fewest
SCATTER_GOOD, SCATTER_POOR = 5.0, 15.0  # half of the 95 % interval, % of friction, median
INSTRUMENTS_GOOD = 10.0  # half of the instruments' 95 % interval, % of friction, median

RULE = (
    "Each check is good, to be used with care, or poor; the verdict is the worst of them. The "
    "limits are judged by hbench's makers; no standard sets them."
)


@dataclass(frozen=True)
class Check:
    """One check: what was found, what is good, and the grade."""

    name: str
    found: str
    rule: str
    grade: Grade


def checks(results: Results) -> tuple[Check, ...]:
    """Return the checks that apply to ``results``."""
    return tuple(_checks(results))


def worst(found: tuple[Check, ...]) -> Grade:
    """Return the verdict: the worst grade."""
    return max((check.grade for check in found), key=GRADES.index)


def verdict(results: Results) -> str:
    """Return the verdict in words."""
    found = checks(results)
    grade = worst(found)
    if grade == "good":
        return f"The data is good: all {len(found)} checks of its quality hold."
    reasons = "; ".join(f"{c.name.lower()}: {c.found}" for c in found if c.grade == grade)
    if grade == "poor":
        return f"The data is poor; rely on no number below. {_capital(reasons)}."
    return f"The data is to be used with care. {_capital(reasons)}."


def _checks(results: Results) -> Iterator[Check]:
    accepted, made = sum(run.accepted for run in results.runs), len(results.runs)
    share = 100 * accepted / made if made else 0.0
    yield Check(
        "Runs accepted",
        f"{accepted} of {made}, {number(share)} %",
        f"good from {ACCEPTED_GOOD:g} %, poor below {ACCEPTED_POOR:g} %",
        _grade(-share, -ACCEPTED_GOOD, -ACCEPTED_POOR),
    )
    points = [point for curve in _curves(results) for point in curve.points]
    if not points:
        return
    fewest = min(point.n for point in points)
    yield Check(
        "Trials of a point",
        f"{fewest} at least" if fewest > 1 else "a point has one alone, so no interval",
        f"good from {TRIALS_GOOD}, poor with {TRIALS_POOR}",
        "good" if fewest >= TRIALS_GOOD else "with care" if fewest > TRIALS_POOR else "poor",
    )
    scatter = [100 * p.ci95_n / abs(p.friction_n) for p in points if p.ci95_n and p.friction_n]
    if scatter:
        yield Check(
            "Repeatability",
            f"trials' 95 % interval ±{number(median(scatter))} % of friction (median)",
            f"good to {SCATTER_GOOD:g} %, poor above {SCATTER_POOR:g} %",
            _grade(median(scatter), SCATTER_GOOD, SCATTER_POOR),
        )
    yield _instruments(points)
    fits = [curve.fits[0] for curve in _curves(results) if curve.fits]
    if fits:
        sound = [
            fit.converged and all(p.at_bound is None and p.ci95 for p in fit.parameters.values())
            for fit in fits
        ]
        grade: Grade = "good" if all(sound) else "poor"
        if not all(sound) and sum(sound) >= len(sound) / 2:
            grade = "with care"
        yield Check(
            f"Fits, {law_words(fits[0].law)}",
            f"{sum(sound)} of {len(sound)} converged with every parameter determined",
            "good if all, poor below half",
            grade,
        )


def _instruments(points: list[CurvePoint]) -> Check:
    known = [
        100 * 1.96 * p.sigma_instruments_n / abs(p.friction_n)
        for p in points
        if p.sigma_instruments_n is not None and p.friction_n
    ]
    rule = f"good to {INSTRUMENTS_GOOD:g} %; above, the level is uncertain, differences less so"
    if not known:
        return Check("Instruments", "their tolerances are not known", rule, "with care")
    half = median(known)
    grade: Grade = "good" if half <= INSTRUMENTS_GOOD else "with care"
    found = f"their 95 % interval is ±{number(half)} % of friction (median)"
    return Check("Instruments", found, rule, grade)


def _curves(results: Results) -> list[Curve]:
    """Return the steady curves, or without any all others."""
    steady = [curve for curve in results.curves if curve.kind == "steady"]
    return steady or list(results.curves)


def _grade(value: float, good: float, poor: float) -> Grade:
    return "good" if value <= good else "poor" if value > poor else "with care"


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]
