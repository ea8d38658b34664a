"""Verdict on identified laws: the best ones, and which to use with which reserve."""

from hbench.records import Identification
from hbench.report.campaign.fit_tables import law_words
from hbench.report.identification.ranking import best_law, equally_good, errors_in_motion
from hbench.report.identification.text import undetermined_words
from hbench.report.render.numbers import significant
from hbench.report.render.symbols import listed


def verdict_words(identification: Identification) -> str:
    """Return the best laws, how they were verified, and the next step."""
    if identification.not_verified:
        return f"{identification.not_verified[0].upper()}{identification.not_verified[1:]}."
    count = len(identification.verification_runs)
    return (
        f"{_closest(identification)}Each law was simulated in a model of the bench, with the "
        f"firmware in closed loop, over {count} verification runs, which were not "
        f"used for the identification.{_next_step(identification)}"
    ).strip()


def _closest(identification: Identification) -> str:
    """Name the laws with the smallest errors of friction in motion."""
    errors = errors_in_motion(identification)
    if not errors:
        return ""
    best = equally_good(errors)
    names = [f"{law_words(law)} ({significant(error, 2)} N)" for law, error in best.items()]
    verb = "predicts" if len(best) == 1 else "predict"
    measured = _range(identification)
    return f"{' and '.join(names)} {verb} friction in motion best, by RMS error{measured}. "


def _range(identification: Identification) -> str:
    """Return the measured steady friction, with which an error compares; empty without curves."""
    curves = [along.curve for along in identification.steady]
    friction = [abs(point.friction_n) for curve in curves for point in curve.points]
    if not friction:
        return ""
    low, high = (significant(end, 3) for end in (min(friction), max(friction)))
    return f"; the measured steady friction is {low} to {high} N"


def _next_step(identification: Identification) -> str:
    """Return how to use the best law, and what the runs do not determine of it."""
    best = best_law(identification)
    if not best:
        return ""
    (fit,) = (law.fit for law in identification.laws if law.law == best)
    unknown = undetermined_words(fit) if fit else []
    reserve = (
        f" These runs do not determine its {listed(unknown)}: use it only for motions like these."
        if unknown
        else ""
    )
    return f" Next step: simulate with hbench run --plant {best}.yaml.{reserve}"
