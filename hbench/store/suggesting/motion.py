"""What the motion in some files says about how to import them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from hbench.config.import_map import ImportMap
from hbench.motion.noise import position_noise
from hbench.motion.plateaus import Plateau
from hbench.motion.rest import LEAST_REST_S, rest_before_motion
from hbench.motion.reversals import cut_at_reversals, stroke_speed

_ONE_WAY = 0.8  # of the travel: a single stroke ends this far from where it began
_SHORT = 4.0  # times 'min_stroke': a longer travel needs none of its own
_OTHER_SPEED = 0.10  # relative difference of two constant speeds
_FLAT = 0.03  # relative difference of speed along a section of constant speed
_LEAST_SAMPLES = 8
_MOVES = 10.0  # times the noise of the position, whose range at rest is 5 to 9
_DEFAULT_M = ImportMap.model_fields["min_stroke"].default


@dataclass(frozen=True)
class Motion:
    """The motion in some files."""

    cut: Literal["none", "reversals", "plateaus"]
    reason: str
    min_stroke_m: float | None  # where the default does not suit
    rest_s: float  # shortest rest before the motion
    stroke_m: float  # median
    speeds_m_s: tuple[float, float]  # lowest and highest of the strokes
    has_constant_speed: bool
    reverses: bool  # without constant speed: the files are kept whole

    @property
    def kind(self) -> str:
        """Kind of the runs in an import map."""
        return "triangle" if self.reverses else "steady"


def motion_of(
    files: Sequence[Mapping[str, np.ndarray]], steady: Sequence[Sequence[Plateau]]
) -> Motion | None:
    """Return the motion in ``files``: t_s and x_m (n,) each; None if there is none beyond noise.

    ``steady`` are the sections of constant speed of each file.
    """
    steady = [
        [p for p in found if not _is_peak(f["t_s"][p.section], f["x_m"][p.section])]
        for f, found in zip(files, steady, strict=True)
    ]
    moving = [(f["t_s"], f["x_m"]) for f in files if len(f.get("x_m", ())) > 10]
    moving = [(t, x) for t, x in moving if np.ptp(x) > _MOVES * position_noise(t, x)]
    if not moving:
        return None
    travel = float(np.median([np.ptp(x) for _, x in moving]))
    min_stroke = None if travel > _SHORT * _DEFAULT_M else float(f"{travel / _SHORT:.1g}")
    least = min_stroke or _DEFAULT_M
    pieces = [cut_at_reversals(t, x, least).pieces for t, x in moving]
    strokes = [(t[p], x[p]) for (t, x), cut in zip(moving, pieces, strict=True) for p in cut]
    one_way = sum(
        abs(x[-1] - x[0]) > _ONE_WAY * np.ptp(x) and len(cut) < 2
        for (_, x), cut in zip(moving, pieces, strict=True)
    )
    both_ways = sum(map(bool, pieces))
    cut: Literal["none", "reversals", "plateaus"]
    if 2 * one_way > len(moving):
        several = sum(_several(found) for found in steady)
        if 2 * several > len(moving):
            cut, reason = "plateaus", "several constant speeds in a file"
        else:
            cut, reason = "none", "each file is one stroke"
        strokes = moving
    elif 2 * both_ways > len(moving):
        count = "a file" if len(moving) == 1 else f"{len(moving)} files"
        cut, reason = "reversals", f"{len(strokes)} strokes in {count}"
    else:
        cut, reason = "plateaus", "no complete stroke between reversals"
        strokes = moving
    has_constant_speed = 2 * sum(map(bool, steady)) > len(moving)
    reverses = cut == "reversals" and not has_constant_speed
    if reverses:
        cut, reason = "none", f"{reason} without constant speed"
    speeds = [abs(stroke_speed(t, x)) for t, x in strokes if x[-1] != x[0]]
    rests = [rest_before_motion(t, x, None) for t, x in moving]
    rest_s = min(
        float(t[rest][-1] - t[rest][0]) if len(t[rest]) else 0.0
        for (t, _), rest in zip(moving, rests, strict=True)
    )
    return Motion(
        cut=cut,
        reason=reason,
        min_stroke_m=min_stroke,
        rest_s=rest_s if rest_s >= LEAST_REST_S else 0.0,
        stroke_m=float(np.median([np.ptp(x) for _, x in strokes])),
        speeds_m_s=(min(speeds, default=0.0), max(speeds, default=0.0)),
        has_constant_speed=has_constant_speed,
        reverses=reverses,
    )


def _is_peak(t_s: np.ndarray, x_m: np.ndarray) -> bool:
    """Return whether a section of nearly constant speed is the top of a triangle or a sine.

    There the first and the last quarter of its time are both slower than the middle.
    """
    if len(t_s) < _LEAST_SAMPLES:
        return False
    at = np.interp(np.linspace(t_s[0], t_s[-1], 5), t_s, x_m)
    first, second, third, last = np.abs(np.diff(at))
    return max(first, last) < (1 - _FLAT) * (second + third) / 2


def _several(found: Sequence[Plateau]) -> bool:
    """Return whether sections of constant speed have different speeds."""
    speeds = sorted(abs(plateau.v_m_s) for plateau in found)
    return len(speeds) > 1 and speeds[-1] > (1 + _OTHER_SPEED) * speeds[0]
