"""Differences of forces in words: size, uncertainty, chance."""

from collections.abc import Sequence

from hbench.records import Difference
from hbench.report.render.numbers import half_width, p_equation, span_with_intervals, with_interval


def with_uncertainty(mean: Difference) -> str:
    """Write a difference with its uncertainty, such as ``−3.1 N (U 9.4 N)``."""
    half = mean.u95 or mean.ci95
    value = with_interval(mean.value, half).partition(" ± ")[0]
    if half is None:
        return f"{value} N (no interval)"
    return f"{value} N ({widest([mean])})".replace("up to ", "")


def sizes(differences: Sequence[Difference], scale: float = 1.0) -> str:
    """Write the range of the sizes of differences, rounded by their uncertainties."""
    return span_with_intervals(
        [
            (scale * abs(each.value), None if half is None else scale * half)
            for each in differences
            for half in (each.u95 or each.ci95,)
        ]
    )


def by_chance(mean: Difference, count: int) -> str:
    """State why a difference beyond its uncertainty is not significant; empty for another one."""
    if mean.p_holm is None or abs(mean.value) <= (mean.u95 or mean.ci95 or 0.0):
        return ""
    tests = f", corrected for {count} tests" if count > 1 else ""
    p = p_equation(mean.p_holm)
    return f", which exceeds its uncertainty but may be chance ({p}{tests})"


def widest(means: Sequence[Difference]) -> str:
    """Return the largest uncertainty of differences: U, or the interval of the trials."""
    halves = [mean.u95 or mean.ci95 or 0.0 for mean in means]
    name = "U" if all(mean.u95 for mean in means) else "95 % intervals of the trials"
    return f"{name} up to {half_width(max(halves))} N"
