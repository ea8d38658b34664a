"""Cutting of a file's channels into the sections that become runs."""

from dataclasses import dataclass

import numpy as np

from hbench.config.import_map import ImportMap
from hbench.errors import DataError
from hbench.motion.plateaus import Plateau, plateau_at, plateaus
from hbench.motion.reversals import (
    LONGEST_STEP_S,
    cut_at_reversals,
    settled_strokes,
    stroke_speed,
)
from hbench.motion.settling import settled
from hbench.motion.speeds import block_speeds
from hbench.records import KINDS
from hbench.store.importing.file_notes import FileNote

_BLOCK_S = 0.1
_AS_FAST = 0.9  # of the top speed: as fast, but for noise
_LEAST_SHARED = 0.2  # of a stroke: positions that both directions cover
_MOST = 0.75  # of these: a stroke that covers less is left out

Positions = tuple[float, float]  # lowest and highest [m]
_NOWHERE: Positions = (np.inf, -np.inf)

_CUT_OFF = (
    "The start or the end of the file cuts its strokes off: leave the file out, or import it as a "
    "whole ('kind: triangle' without 'cut'). Or a unit of x_m or t_s in the map is wrong."
)
_TOO_SHORT = "Check the units of x_m and t_s in the map, or reduce 'min_stroke'."


@dataclass(frozen=True)
class Section:
    """Samples of a file that become a run."""

    samples: slice
    v_m_s: float  # measured, signed; of a run of another kind its top speed
    positions: Positions | None = None  # to average over: those that both directions cover


@dataclass(frozen=True)
class Sections:
    """The sections of a file, and notes on what was left out."""

    sections: tuple[Section, ...]
    notes: tuple[FileNote, ...] = ()


def cut(
    channels: dict[str, np.ndarray], source: str, name: str, rules: ImportMap, speed: float | None
) -> Sections:
    """Cut a file as ``cut`` in the map says. ``speed`` is its nominal speed, without sign.

    Raises ``DataError`` for a file without a run.
    """
    t_s, x_m = channels["t_s"], channels["x_m"]
    if rules.cut == "plateaus":
        return _at_plateaus(t_s, x_m, source, rules)
    if rules.cut == "reversals":
        return _at_reversals(channels, source, name, rules, speed)
    whole = slice(0, len(x_m))
    if not KINDS[rules.kind].has_constant_speed:
        return Sections((Section(whole, _top_speed(channels, rules.kind, speed)),))
    if abs(x_m[-1] - x_m[0]) < rules.min_stroke:
        raise DataError(
            f"{source}: ends {1e3 * abs(x_m[-1] - x_m[0]):.3g} mm from where it began; expected "
            f"one stroke of at least min_stroke = {1e3 * rules.min_stroke:g} mm",
            "For files with strokes in both directions, write 'cut: reversals' in the map; for "
            "several constant speeds 'cut: plateaus'; for triangles or sines as a whole, whose "
            "reversals hbench reconcile uses, 'kind: triangle'.",
        )
    return _whole(t_s, x_m, name, rules, speed)


def _whole(
    t_s: np.ndarray, x_m: np.ndarray, name: str, rules: ImportMap, speed: float | None
) -> Sections:
    """Return the whole file as a run, whose speed is that of its longest plateau."""
    whole = slice(0, len(x_m))
    if speed is not None:
        return Sections((Section(whole, float(np.copysign(speed, x_m[-1] - x_m[0]))),))
    found = plateaus(t_s, x_m, least_m=rules.min_stroke)
    if not found:
        return Sections((Section(whole, stroke_speed(t_s, x_m)),))
    longest = max(found, key=lambda p: t_s[p.section.stop - 1] - t_s[p.section.start])
    notes = []
    if len(found) > 1:
        text = "{count} sections of constant speed; only the longest is used (cut: plateaus)"
        notes.append(FileNote(name, text, {"count": len(found)}))
    return Sections((Section(whole, longest.v_m_s),), tuple(notes))


def _at_plateaus(t_s: np.ndarray, x_m: np.ndarray, source: str, rules: ImportMap) -> Sections:
    """Return a section for each plateau: from the end of the one before to its own end."""
    found: list[Plateau] = plateaus(t_s, x_m, rules.screening.min_window, rules.min_stroke)
    if not found:
        raise DataError(
            f"{source}: holds no constant speed over min_stroke = {1e3 * rules.min_stroke:g} mm "
            f"and min_window = {rules.screening.min_window:g} s",
            "Reduce 'min_stroke' or 'screening.min_window' in the map.",
        )
    starts = [0, *(p.section.stop for p in found[:-1])]
    return Sections(
        tuple(
            Section(slice(start, p.section.stop), p.v_m_s)
            for start, p in zip(starts, found, strict=True)
        )
    )


def _at_reversals(
    channels: dict[str, np.ndarray],
    source: str,
    name: str,
    rules: ImportMap,
    speed: float | None,
) -> Sections:
    t_s, x_m = channels["t_s"], channels["x_m"]
    found = cut_at_reversals(t_s, x_m, rules.min_stroke)
    if not found.pieces:
        low, high = 1e3 * float(np.min(x_m)), 1e3 * float(np.max(x_m))
        raise DataError(
            f"{source}: no stroke between two reversals, or from or to a rest, is longer than "
            f"min_stroke = {1e3 * rules.min_stroke:g} mm; the file has positions from {low:.4g} to "
            f"{high:.4g} mm in {t_s[-1] - t_s[0]:.4g} s",
            _no_stroke_hint(
                t_s, cut_off=bool(found.partial) and high - low > 1e3 * rules.min_stroke
            ),
        )
    pieces = settled_strokes(t_s, x_m, found.pieces)
    left_out = {
        "{count} sections without a known start or end left out": found.partial,
        f"{{count}} strokes shorter than {1e3 * rules.min_stroke:g} mm left out": found.short,
        "run-in: the first {count} strokes differ in length or duration and are left out": (
            found.pieces.index(pieces[0])
        ),
        "run-out: the last {count} strokes differ in length or duration and are left out": (
            len(found.pieces) - 1 - found.pieces.index(pieces[-1])
        ),
    }
    notes = [FileNote(name, text, {"count": n}) for text, n in left_out.items() if n]
    if not KINDS[rules.kind].has_constant_speed:
        return Sections(
            tuple(
                Section(p, _top_speed({k: y[p] for k, y in channels.items()}, rules.kind, speed))
                for p in pieces
            ),
            tuple(notes),
        )
    speeds = [stroke_speed(t_s[p], x_m[p]) for p in pieces]
    covered = [
        _covered(t_s[piece], x_m[piece], v, rules) for piece, v in zip(pieces, speeds, strict=True)
    ]
    travel = float(np.median([np.ptp(x_m[piece]) for piece in pieces]))
    shared = _shared_positions(covered, speeds, _LEAST_SHARED * travel)
    if shared is None:
        if min(speeds) < 0 < max(speeds):
            text = "extending and retracting share too few positions after settling: not compared"
            notes.append(FileNote(name, text))
        return Sections(tuple(map(Section, pieces, speeds)), tuple(notes))
    whole = [low <= shared[0] and high >= shared[1] for low, high in covered]
    if few := whole.count(False):
        text = "{count} strokes cover too few of the positions of the others and are left out"
        notes.append(FileNote(name, text, {"count": few}))
    kept = (Section(p, v, shared) for p, v, k in zip(pieces, speeds, whole, strict=True) if k)
    return Sections(tuple(kept), tuple(notes))


def _no_stroke_hint(t_s: np.ndarray, *, cut_off: bool) -> str:
    step_s = float(np.median(np.diff(t_s)))
    if step_s > 1.01 * LONGEST_STEP_S:
        return (
            f"The log has {1 / step_s:.3g} Hz, and a rest is found from {1 / LONGEST_STEP_S:g} Hz "
            "on: log faster, or check the unit of t_s in the map."
        )
    return _CUT_OFF if cut_off else _TOO_SHORT


def _shared_positions(
    covered: list[Positions], speeds: list[float], least_m: float
) -> Positions | None:
    """Return the positions that the settled strokes of both directions cover; None if few.

    Only strokes that cover at least three quarters of the positions common to the median strokes of
    both directions count.
    """
    directions = [
        [positions for positions, v in zip(covered, speeds, strict=True) if (v > 0) == extends]
        for extends in (True, False)
    ]
    settled_ones = [[each for each in own if each != _NOWHERE] for own in directions]
    if not all(settled_ones):
        return None
    common = _intersection(*(np.median(np.array(own), axis=0).tolist() for own in settled_ones))
    most = [
        [each for each in own if _width(_intersection(common, each)) >= _MOST * _width(common)]
        for own in settled_ones
    ]
    if _width(common) < least_m or not all(most):
        return None
    return _intersection(*most[0], *most[1])


def _covered(t_s: np.ndarray, x_m: np.ndarray, v_m_s: float, rules: ImportMap) -> Positions:
    """Return the positions of a stroke's settled part."""
    limits = rules.screening
    part = settled(t_s, x_m, plateau_at(t_s, x_m, v_m_s), limits.settle_time, limits.settle_travel)
    x = x_m[part]
    return (float(x.min()), float(x.max())) if len(x) > 1 else _NOWHERE


def _width(positions: Positions) -> float:
    return positions[1] - positions[0]


def _intersection(*positions: Positions) -> Positions:
    return max(low for low, _ in positions), min(high for _, high in positions)


def _top_speed(channels: dict[str, np.ndarray], kind: str, speed: float | None) -> float:
    """Return the top speed [m/s] of a non-steady run, with the sign of its reference or motion.

    If it moves equally fast in both directions, the sign is that of the first.
    """
    v_ref = channels.get("v_ref_m_s")
    if KINDS[kind].is_at_rest:
        return 0.0
    if v_ref is not None and np.isfinite(v_ref).any():
        return float(v_ref[np.nanargmax(np.abs(v_ref))])
    measured = block_speeds(channels["t_s"], channels["x_m"], _BLOCK_S).v_m_s
    top = np.abs(measured).max(initial=0.0)
    first = np.flatnonzero(np.abs(measured) >= _AS_FAST * top)[:1]
    fastest = float(np.copysign(top, measured[first[0]])) if len(first) else 0.0
    return float(f"{fastest:.3g}") if speed is None else float(np.copysign(speed, fastest))
