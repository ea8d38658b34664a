"""Rules for patterns on a control chart of individual values, each by its name and number.

The zone tests of the Western Electric Company (Statistical Quality Control Handbook, 1956) and test
3 of Nelson (Journal of Quality Technology 16, 1984). z is the distance from the centre in sigma:

    Western Electric 1, Nelson 1   one point with |z| > 3
    Western Electric 2, Nelson 5   two of three points in a row with z > 2, or with z < -2
    Western Electric 3, Nelson 6   four of five points in a row with z > 1, or with z < -1
    Western Electric 4             eight points in a row on one side of the centre (Nelson 2: nine)
    Nelson 3                       six points in a row that all rise, or all fall

Each signal is at the last point of its pattern. With known centre and sigma, the first false signal
comes after 370 points in the mean by the first rule alone, and after 91.75 by the four rules of
Western Electric together (Champ and Woodall, Technometrics 29, 1987).
"""

from collections.abc import Callable

import numpy as np

_RISING = 6  # points of Nelson's test 3


def run_rules(z: np.ndarray) -> dict[str, np.ndarray]:
    """Return for each rule, by its name, whether it signals at each point of ``z`` (n,)."""
    return {name: rule(np.asarray(z, dtype=float)) for name, rule in RULES.items()}


def _of_several(needed: int, length: int, beyond: float) -> Callable[[np.ndarray], np.ndarray]:
    """Return the rule that ``needed`` of ``length`` points are beyond a distance on one side."""

    def rule(z: np.ndarray) -> np.ndarray:
        return _side(z > beyond) | _side(z < -beyond)

    def _side(inside: np.ndarray) -> np.ndarray:
        counts = np.concatenate([[0], np.cumsum(inside)])
        first = np.maximum(np.arange(len(inside)) - length + 1, 0)
        # The pattern ends with a point that belongs to it.
        return inside & (counts[1:] - counts[first] >= needed)

    return rule


def _monotone(z: np.ndarray) -> np.ndarray:
    signals = np.zeros(len(z), dtype=bool)
    steps = np.sign(np.diff(z))
    for sign in (1.0, -1.0):
        counts = np.concatenate([[0], np.cumsum(steps == sign)])
        if len(z) >= _RISING:
            inside = counts[_RISING - 1 :] - counts[: len(counts) - _RISING + 1]
            signals[_RISING - 1 :] |= inside == _RISING - 1
    return signals


SHEWHART = "Western Electric 1, Nelson 1: beyond 3 σ"
RULES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    SHEWHART: _of_several(1, 1, 3.0),
    "Western Electric 2, Nelson 5: two of three beyond 2 σ": _of_several(2, 3, 2.0),
    "Western Electric 3, Nelson 6: four of five beyond 1 σ": _of_several(4, 5, 1.0),
    "Western Electric 4: eight on one side": _of_several(8, 8, 0.0),
    "Nelson 3: six rising or falling": _monotone,
}
