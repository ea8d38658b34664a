"""Parabolas through a log, along which laws are evaluated.

A sample is the mean over its interval, as the board's records are. Within the interval a signal is
a parabola with this mean and, at each end, the mean of both neighbours.
"""

from collections.abc import Sequence

from hbench.model.compiled import inlined


@inlined
def parabola(before: float, mean: float, after: float) -> tuple[float, float, float]:
    """Coefficients a, b, c of a + b s + c s^2 over an interval, 0 <= s <= 1.

    From its mean and those of its neighbours, which give the values at its ends.
    """
    first, final = 0.5 * (before + mean), 0.5 * (mean + after)
    bend = 6.0 * (mean - 0.5 * (first + final))
    return first, final - first + bend, -bend


@inlined
def value_at(curve: Sequence[float], s: float) -> float:
    """Value of the parabola with coefficients a, b, c at a part ``s`` of its interval."""
    return curve[0] + s * (curve[1] + s * curve[2])


@inlined
def within(before: float, mean: float, after: float, s: float) -> float:
    """Value of ``parabola`` at a part ``s`` of the interval."""
    return value_at(parabola(before, mean, after), s)
