"""Signs and scales of channels that contradict each other, or the file's name or series."""

from collections.abc import Iterator, Mapping

import numpy as np

from hbench.store.importing.file_matches import FileMatch
from hbench.store.importing.file_notes import FileNote

_WRONG_SIGN = 0.2  # of the nominal load: a measured load beyond it has a sign
_OPPOSITE = -0.5  # correlation of velocity and motion: below it their signs differ
_BLOCKS = 50  # of a run, over which the velocity is integrated
_SAME_SPEED = 5.0  # largest ratio of the position's speed to the nominal one, and 1 over the least
_SAME_SCALE = 1.25  # largest ratio of the velocity to that of the position, and 1 over the least


def contradicting_signs(match: FileMatch, channels: Mapping[str, np.ndarray]) -> Iterator[FileNote]:
    """Yield a note on each sign in a run's channels (n,) that contradicts another one."""
    yield from _load_sign(match, channels.get("f_applied_n"))
    yield from _velocity(match, channels)
    yield from _nominal_speed(match, channels)


def _nominal_speed(match: FileMatch, channels: Mapping[str, np.ndarray]) -> Iterator[FileNote]:
    """Yield a note if the fastest motion over a block of the run has another scale than stated."""
    nominal, t, x = match.speed_m_s, channels["t_s"], channels["x_m"]
    if not nominal or len(t) < 2:
        return
    edges = np.linspace(0, len(t) - 1, min(_BLOCKS, len(t) - 1) + 1).astype(int)
    ratio = float(np.max(np.abs(np.diff(x[edges]) / np.diff(t[edges])))) / nominal
    if ratio > 0 and not 1 / _SAME_SPEED <= ratio <= _SAME_SPEED:
        text = (
            "the speed of x_m is {ratio} times the nominal speed: check the units of x_m and t_s, "
            "and the speed in 'files' with speed_unit, or in 'speed'"
        )
        yield FileNote(match.name, text, {"ratio": ratio})


def _velocity(match: FileMatch, channels: Mapping[str, np.ndarray]) -> Iterator[FileNote]:
    """Yield a note if the velocity has another sign or scale than the position's motion.

    Its distances over blocks of the run are compared with those of the position: noise counts less.
    """
    v, t, x = channels.get("v_m_s"), channels["t_s"], channels["x_m"]
    if v is None or len(t) < 3:
        return
    moved, way = np.diff(x), np.diff(t) * (v[1:] + v[:-1]) / 2
    known = np.isfinite(way)
    if not known.any():
        return
    blocks = np.linspace(0, known.sum(), min(_BLOCKS, known.sum()), endpoint=False).astype(int)
    moved, way = (np.add.reduceat(each[known], blocks) for each in (moved, way))
    square, common = float(moved @ moved) * float(way @ way), float(moved @ way)
    if square == 0:
        return
    ratio = float(np.sqrt((way @ way) / (moved @ moved)))
    if common < _OPPOSITE * np.sqrt(square):
        text = (
            "v_m_s has the sign opposite to that of the motion of x_m: turn the one that is not "
            "positive when the cylinder extends (scale: -1)"
        )
        yield FileNote(match.name, text)
    elif not 1 / _SAME_SCALE <= ratio <= _SAME_SCALE:
        text = (
            "v_m_s is {ratio} times the speed of x_m: check its column, its unit and its scale in "
            "the map"
        )
        yield FileNote(match.name, text, {"ratio": ratio})


def _load_sign(match: FileMatch, f_applied_n: np.ndarray | None) -> Iterator[FileNote]:
    """Yield a note if the load cell contradicts the sign of the load in the file's name."""
    load = match.f_load_n
    if load and f_applied_n is not None and np.isfinite(f_applied_n).any():
        mean = float(np.nanmean(f_applied_n))
        if mean * np.sign(load) < -_WRONG_SIGN * abs(load):
            text = (
                "the load in the name, {load} N, has the other sign than the load cell's mean, "
                "{mean} N; positive opposes extension (scale: -1 turns a column)"
            )
            yield FileNote(match.name, text, {"load": load, "mean": mean})
