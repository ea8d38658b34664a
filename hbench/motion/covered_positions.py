"""Positions that the settled strokes of both directions cover, so that both are averaged there."""

from collections.abc import Iterable, Sequence

import numpy as np

from hbench.motion.plateaus import plateau_at
from hbench.motion.settling import settled

Positions = tuple[float, float]  # lowest and highest [m]

_NOWHERE: Positions = (np.inf, -np.inf)
_LEAST_SHARED = 0.2  # of a stroke: positions that both directions cover
_MOST = 0.75  # of these: a stroke that covers less is left out


def covered_positions(
    t_s: np.ndarray, x_m: np.ndarray, v_m_s: float, settle_s: float, settle_m: float
) -> Positions:
    """Return the positions of a stroke at ``v_m_s`` after it has settled; none if it does not."""
    x = x_m[settled(t_s, x_m, plateau_at(t_s, x_m, v_m_s), settle_s, settle_m)]
    return (float(x.min()), float(x.max())) if len(x) > 1 else _NOWHERE


def shared_positions(
    covered: Sequence[Positions], speeds: Sequence[float], travel_m: float
) -> Positions | None:
    """Return the positions that both directions cover; None if less than 20 % of ``travel_m``.

    ``covered`` are those of each stroke, ``speeds`` its signed speed. Only strokes that cover at
    least three quarters of the positions common to the median strokes of both directions count.
    """
    directions = [
        [stroke for stroke, v in zip(covered, speeds, strict=True) if (v > 0) == extends]
        for extends in (True, False)
    ]
    settled_strokes = [[stroke for stroke in each if stroke != _NOWHERE] for each in directions]
    if not all(settled_strokes):
        return None
    medians = (np.median(np.array(strokes), axis=0).tolist() for strokes in settled_strokes)
    common = _intersection(medians)
    least_m = _MOST * _width(common)
    chosen = [
        [stroke for stroke in strokes if _width(_intersection([common, stroke])) >= least_m]
        for strokes in settled_strokes
    ]
    if _width(common) < _LEAST_SHARED * travel_m or not all(chosen):
        return None
    return _intersection(chosen[0] + chosen[1])


def _width(positions: Positions) -> float:
    return positions[1] - positions[0]


def _intersection(positions: Iterable[Positions]) -> Positions:
    lows, highs = zip(*positions, strict=True)
    return max(lows), min(highs)
