"""Cutting of a file's channels into the sections that become runs."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from hbench.config.import_map import ImportMap
from hbench.errors import DataError
from hbench.motion.covered_positions import Positions, covered_positions, shared_positions
from hbench.motion.plateaus import SAME_SPEED, Plateau, plateaus
from hbench.motion.reversals import (
    LONGEST_STEP_S,
    SAME_LENGTH,
    cut_at_reversals,
    settled_strokes,
    stroke_speed,
)
from hbench.motion.similar_values import similar_values
from hbench.motion.speeds import block_speeds
from hbench.records import KINDS
from hbench.store.importing.file_notes import FileNote

_BLOCK_S = 0.1
_AS_FAST = 0.9  # of the top speed: as fast, but for noise

_VARYING = ("triangle", "ramp")  # kinds of a speed that changes all the time
_MOSTLY = 0.6  # of the travel: more than the top of a sine has
_SLOW_STEPS = 3  # sampling intervals: a gap in a log that samples slowly
_CUT_OFF = (
    "The start or the end of the file cuts its strokes off: leave the file out, or import it as a "
    "whole ('kind: triangle' without 'cut'). Or a unit of x_m or t_s in the map is wrong."
)
_BACK_AND_FORTH = (
    "For files with strokes in both directions, write 'cut: reversals' in the map; for several "
    "constant speeds 'cut: plateaus'; for triangles or sines as a whole, whose reversals hbench "
    "reconcile uses, 'kind: triangle'."
)
_TOO_SHORT = "Check the units of x_m and t_s in the map, or reduce 'min_stroke'."
_APART = "extending and retracting share too few positions after settling: not compared"
_TOO_FEW = "{count} strokes cover too few of the positions of the others and are left out"


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
        return _at_plateaus(t_s, x_m, source, name, rules)
    if rules.cut == "reversals":
        return _at_reversals(channels, source, name, rules, speed)
    whole = slice(0, len(x_m))
    if not KINDS[rules.kind].has_constant_speed:
        notes = tuple(_constant_speed_notes(t_s, x_m, name, rules))
        return Sections((Section(whole, _top_speed(channels, rules.kind, speed)),), notes)
    if abs(x_m[-1] - x_m[0]) < rules.min_stroke:
        raise DataError(
            f"{source}: ends {1e3 * abs(x_m[-1] - x_m[0]):.3g} mm from where it began; expected "
            f"one stroke of at least min_stroke = {1e3 * rules.min_stroke:g} mm",
            _TOO_SHORT if np.ptp(x_m) < rules.min_stroke else _BACK_AND_FORTH,
        )
    return _whole(t_s, x_m, name, rules, speed)


def _constant_speed_notes(
    t_s: np.ndarray, x_m: np.ndarray, name: str, rules: ImportMap
) -> Iterator[FileNote]:
    """Yield a note on strokes of constant speed that are imported as a varying speed.

    Such as triangles of position, whose velocity is no triangle.
    """
    if rules.kind not in _VARYING:
        return
    share = _constant_share(t_s, x_m, plateaus(t_s, x_m, least_m=rules.min_stroke))
    if share > _MOSTLY:
        text = (
            f"{{share}} % of the travel has constant speed, but 'kind: {rules.kind}' is a motion "
            "of varying speed: friction at constant speed is not evaluated. For strokes of "
            "constant speed write 'kind: steady' and 'cut: reversals' in the map"
        )
        yield FileNote(name, text, {"share": round(100 * share)})


def _constant_share(t_s: np.ndarray, x_m: np.ndarray, constant: Sequence[Plateau]) -> float:
    """Return the share of the travel that has constant speed; 0 without motion."""
    way_m = _BLOCK_S * float(np.abs(block_speeds(t_s, x_m, _BLOCK_S).v_m_s).sum())
    constant_m = sum(abs(x_m[p.section.stop - 1] - x_m[p.section.start]) for p in constant)
    return min(1.0, float(constant_m) / way_m) if way_m > 0 else 0.0


def _whole(
    t_s: np.ndarray, x_m: np.ndarray, name: str, rules: ImportMap, speed: float | None
) -> Sections:
    """Return the whole file as a run, whose speed is that of its longest plateau."""
    whole = slice(0, len(x_m))
    if speed is not None:
        v_m_s = float(np.copysign(speed, x_m[-1] - x_m[0]))
        return Sections((Section(whole, v_m_s),), tuple(_unused(t_s, x_m, name, rules, v_m_s)))
    constant = plateaus(t_s, x_m, least_m=rules.min_stroke)
    if not constant:
        return Sections((Section(whole, stroke_speed(t_s, x_m)),))
    longest = max(constant, key=lambda p: t_s[p.section.stop - 1] - t_s[p.section.start])
    notes = []
    if len(constant) > 1:
        text = "{count} sections of constant speed; only the longest is used (cut: plateaus)"
        notes.append(FileNote(name, text, {"count": len(constant)}))
    return Sections((Section(whole, longest.v_m_s),), tuple(notes))


def _unused(
    t_s: np.ndarray, x_m: np.ndarray, name: str, rules: ImportMap, v_m_s: float
) -> Iterator[FileNote]:
    """Yield a note on sections at the nominal speed beside the one that is used."""
    found = plateaus(t_s, x_m, rules.screening.min_window, rules.min_stroke)
    ratios = [plateau.v_m_s / v_m_s for plateau in found]
    along = sum(abs(ratio - 1) < SAME_SPEED for ratio in ratios)
    if any(abs(ratio + 1) < SAME_SPEED for ratio in ratios):
        used = "extending" if v_m_s > 0 else "retracting"
        text = f"moves both ways at the nominal speed; only {used} is used (cut: reversals)"
        yield FileNote(name, text)
    elif along > 1:
        text = (
            "{count} sections at the nominal speed; only one is used. If each is a run, write "
            "'cut: plateaus' in the map"
        )
        yield FileNote(name, text, {"count": along})


def _at_plateaus(
    t_s: np.ndarray, x_m: np.ndarray, source: str, name: str, rules: ImportMap
) -> Sections:
    """Return a section for each plateau: from the end of the one before to its own end."""
    constant = plateaus(t_s, x_m, rules.screening.min_window, rules.min_stroke)
    if not constant:
        raise DataError(
            f"{source}: holds no constant speed over min_stroke = {1e3 * rules.min_stroke:g} mm "
            f"and min_window = {rules.screening.min_window:g} s; it travels "
            f"{1e3 * np.ptp(x_m):.3g} mm in {t_s[-1] - t_s[0]:.3g} s",
            "Check the units of t_s and x_m in the map, or reduce 'min_stroke' or "
            "'screening.min_window'.",
        )
    starts = [0, *(plateau.section.stop for plateau in constant[:-1])]
    sections = tuple(
        Section(slice(start, plateau.section.stop), plateau.v_m_s)
        for start, plateau in zip(starts, constant, strict=True)
    )
    share = _constant_share(t_s, x_m, constant)
    if share >= _MOSTLY:
        return Sections(sections)
    text = (
        "{share} % of the travel has no constant speed: friction there is not evaluated. A speed "
        f"is constant if it stays within {100 * SAME_SPEED:g} % for at least "
        f"{rules.screening.min_window:g} s and {1e3 * rules.min_stroke:g} mm"
    )
    return Sections(sections, (FileNote(name, text, {"share": round(100 * (1 - share))}),))


def _at_reversals(
    channels: dict[str, np.ndarray],
    source: str,
    name: str,
    rules: ImportMap,
    speed: float | None,
) -> Sections:
    """Return a section for each stroke between two reversals, without run-in and run-out."""
    t_s, x_m = channels["t_s"], channels["x_m"]
    strokes, notes = _strokes(t_s, x_m, source, name, rules)
    if KINDS[rules.kind].has_constant_speed:
        sections, on_positions = _with_shared_positions(t_s, x_m, strokes, name, rules)
        return Sections(sections, (*notes, *on_positions))
    parts = ({key: y[stroke] for key, y in channels.items()} for stroke in strokes)
    speeds = (_top_speed(part, rules.kind, speed) for part in parts)
    return Sections(tuple(map(Section, strokes, speeds)), notes)


def _strokes(
    t_s: np.ndarray, x_m: np.ndarray, source: str, name: str, rules: ImportMap
) -> tuple[tuple[slice, ...], tuple[FileNote, ...]]:
    """Return the strokes of a file, and notes on those left out. Raises ``DataError``."""
    cuts = cut_at_reversals(t_s, x_m, rules.min_stroke)
    step_s = float(np.median(np.diff(t_s))) if len(t_s) > 1 else 0.0
    gap_s = max(rules.screening.max_gap, _SLOW_STEPS * step_s)
    logged = [piece for piece in cuts.pieces if not _jumps(t_s, x_m, piece, gap_s)]
    if not logged:
        low, high = 1e3 * float(np.min(x_m)), 1e3 * float(np.max(x_m))
        cut_off = bool(cuts.partial) and high - low > 1e3 * rules.min_stroke
        raise DataError(
            f"{source}: no stroke between two reversals, or from or to a rest, is longer than "
            f"min_stroke = {1e3 * rules.min_stroke:g} mm; the file has positions from {low:.4g} to "
            f"{high:.4g} mm in {t_s[-1] - t_s[0]:.4g} s",
            _no_stroke_hint(step_s, cut_off=cut_off),
        )
    strokes = settled_strokes(t_s, x_m, logged)
    run_in = logged.index(strokes[0])
    run_out = len(logged) - 1 - logged.index(strokes[-1])
    differ = "strokes differ in length or duration and are left out"
    left_out = {
        "{count} sections without a known start or end left out": cuts.partial,
        "strokes within a gap of the log, left out: {count}": len(cuts.pieces) - len(logged),
        f"{{count}} strokes shorter than {1e3 * rules.min_stroke:g} mm left out": cuts.short,
        f"run-in: the first {{count}} {differ}": run_in,
        f"run-out: the last {{count}} {differ}": run_out,
    }
    notes = (FileNote(name, text, {"count": n}) for text, n in left_out.items() if n)
    return strokes, tuple(notes)


def _jumps(t_s: np.ndarray, x_m: np.ndarray, stroke: slice, gap_s: float) -> bool:
    """Return whether most of a stroke was made while nothing was logged, as between two runs."""
    whole = slice(stroke.start, stroke.stop + 1)  # it ends at the next reversal
    in_gaps = np.abs(np.diff(x_m[whole]))[np.diff(t_s[whole]) > gap_s]
    return bool(in_gaps.sum() > _MOSTLY * np.ptp(x_m[whole]))


def _with_shared_positions(
    t_s: np.ndarray, x_m: np.ndarray, strokes: Sequence[slice], name: str, rules: ImportMap
) -> tuple[tuple[Section, ...], tuple[FileNote, ...]]:
    """Return the strokes as sections, with the positions to average over, and notes.

    Strokes of one length share positions. Those that do not cover these, such as fast strokes
    that settle late, share others among each other, or are sections as they are where both
    directions are left. Other strokes are left out, such as those of a sensor's noise. Where no
    strokes at all share positions, all are sections.
    """
    settle = rules.screening.settle_time, rules.screening.settle_travel
    speeds = [stroke_speed(t_s[stroke], x_m[stroke]) for stroke in strokes]
    covered = [
        covered_positions(t_s[stroke], x_m[stroke], v, *settle)
        for stroke, v in zip(strokes, speeds, strict=True)
    ]
    lengths = np.array([np.ptp(x_m[stroke]) for stroke in strokes])
    sections: dict[int, Section] = {}
    apart = False
    for group in similar_values(lengths, SAME_LENGTH):
        rest, travel_m = group.tolist(), float(np.median(lengths[group]))
        while shared := shared_positions(
            [covered[i] for i in rest], [speeds[i] for i in rest], travel_m
        ):
            chosen = [i for i in rest if _covers(covered[i], shared)]
            sections |= {i: Section(strokes[i], speeds[i], shared) for i in chosen}
            rest = [i for i in rest if i not in chosen]
        if len(rest) < len(group) and len({speeds[i] > 0 for i in rest}) == 2:
            sections |= {i: Section(strokes[i], speeds[i]) for i in rest}
            apart = True
    if not sections:
        sections = {i: Section(strokes[i], speeds[i]) for i in range(len(strokes))}
        apart = min(speeds) < 0 < max(speeds)
    few = len(strokes) - len(sections)
    notes = []
    if apart:
        notes.append(FileNote(name, _APART))
    if few:
        notes.append(FileNote(name, _TOO_FEW, {"count": few}))
    return tuple(sections[i] for i in sorted(sections)), tuple(notes)


def _covers(covered: Positions, shared: Positions) -> bool:
    return covered[0] <= shared[0] and covered[1] >= shared[1]


def _no_stroke_hint(step_s: float, *, cut_off: bool) -> str:
    if step_s > 1.01 * LONGEST_STEP_S:
        return (
            f"The log has {1 / step_s:.3g} Hz, and a rest is found from {1 / LONGEST_STEP_S:g} Hz "
            "on: log faster, or check the unit of t_s in the map."
        )
    return _CUT_OFF if cut_off else _TOO_SHORT


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
