"""Deviations of forces that arise at rest, where the motion does not determine friction."""

from typing import NamedTuple

import numpy as np

from hbench.records import Diagnosis, Gap, ResidualMap
from hbench.records.diagnosis import MOTION_BALANCE, REST_M_S
from hbench.report.diagnosis.names import in_sentence, in_unit
from hbench.report.render.numbers import number, significant
from hbench.report.render.symbols import capital

_FORCES = ("force_test", "force_load", MOTION_BALANCE)
_STANDSTILL_M = 1e-5  # travel: far less than the sliding distance of a seal
_NO_EVIDENCE = (
    "The friction that holds a piston at rest can have any value up to the static friction. The "
    "model infers it from the measured velocity, whose noise alone can make it drift. "
    "Such a ramp is no evidence of a missing effect."
)


class AtRest(NamedTuple):
    """Deviation of a force, in the unit of its gap, by windows at rest and in motion."""

    gap: Gap
    rest: float
    motion: float
    travel_m: float  # largest travel during a stop


def deviation_in_motion(diagnosis: Diagnosis, gap: Gap) -> float:
    """Return the deviation of a quantity in the windows in motion, as ``gap.deviation`` of all.

    nan where the residuals have no windows at rest, or none in motion.
    """
    side = diagnosis.residuals_before
    resting = np.abs(side.v_m_s) < REST_M_S
    if resting.all() or not resting.any():
        return float("nan")
    return _deviation(side, gap, ~resting)


def at_rest(diagnosis: Diagnosis, gap: Gap) -> AtRest | None:
    """Return the parts of a force's deviation if only the one at rest is large enough to matter."""
    side = diagnosis.residuals_before
    motion = deviation_in_motion(diagnosis, gap)
    if gap.name not in _FORCES or not motion <= gap.material < gap.deviation:
        return None
    resting = np.abs(side.v_m_s) < REST_M_S
    return AtRest(gap, _deviation(side, gap, resting), motion, _travel_m(side, resting))


def _deviation(side: ResidualMap, gap: Gap, chosen: np.ndarray) -> float:
    """Return the root mean square of some residuals, without the noise of single windows."""
    if gap.name not in side.names:
        return float("nan")
    value = side.value[chosen, side.names.index(gap.name)]
    value = value[np.isfinite(value)]
    if not len(value):
        return float("nan")
    noise = gap.gap**2 - (gap.deviation / gap.scatter) ** 2
    return float(gap.scatter * np.sqrt(max(np.mean(value**2) - noise, 0.0)))


def _travel_m(side: ResidualMap, resting: np.ndarray) -> float:
    """Return the largest travel in a stretch of windows at rest of one run."""
    begins = np.diff(side.t_s, prepend=np.inf) <= 0  # of a run
    stops = np.split(side.x_m, np.flatnonzero(begins | np.diff(resting, prepend=False)))
    moving = np.split(~resting, np.flatnonzero(begins | np.diff(resting, prepend=False)))
    return max(
        float(np.ptp(x)) for x, moves in zip(stops, moving, strict=True) if len(x) and not moves[0]
    )


def rest_clause(part: AtRest) -> str:
    """Return where a deviation arises, as the end of a sentence that begins with its size."""
    motion = in_unit(part.gap, part.motion)
    if part.travel_m > _STANDSTILL_M:
        return f"arises at rest and below {1e3 * REST_M_S:g} mm/s; above, it is {motion}"
    return f"arises at rest, where the motion does not determine friction; in motion it is {motion}"


def rest_caption(diagnosis: Diagnosis, name: str) -> str:
    """Return the end of the caption of a balance's residuals, on those at rest; empty for none."""
    for part in (at_rest(diagnosis, gap) for gap in diagnosis.where if gap.name == name):
        if part:
            rest, motion = (in_unit(part.gap, value) for value in (part.rest, part.motion))
            return f" The points at zero velocity ({rest} RMS) are at rest; in motion {motion}."
    return ""


def rest_words(diagnosis: Diagnosis) -> str:
    """Return the deviations that arise at rest, and why they are no evidence; empty for none."""
    parts = [part for gap in diagnosis.where if (part := at_rest(diagnosis, gap))]
    if not parts:
        return ""
    sizes = [
        f"{in_sentence(part.gap.name)} deviates by {in_unit(part.gap, part.rest)} RMS at rest and "
        f"by {in_unit(part.gap, part.motion)} in motion"
        for part in parts
    ]
    travel = max(part.travel_m for part in parts)
    why = ""
    if travel <= _STANDSTILL_M:
        why = f" The piston moves by up to {significant(1e3 * travel, 1)} mm there. {_NO_EVIDENCE}"
    side = diagnosis.residuals_before
    resting = int((np.abs(side.v_m_s) < REST_M_S).sum())
    return (
        f"{capital('; '.join(sizes))}. At rest are the {number(resting, 0)} of "
        f"{number(len(side.v_m_s), 0)} windows with less than {1e3 * REST_M_S:g} mm/s.{why}"
    )
