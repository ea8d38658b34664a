"""The first thing a reader sees: friction at the working speed, breakaway, efficiency."""

import math
from dataclasses import dataclass
from statistics import median_low, stdev

from hbench.records import Curve, CurvePoint, EfficiencyCurve, EfficiencyPoint, Results
from hbench.report.campaign.page_tables import WHO, table, who
from hbench.report.campaign.quality import RULE, checks, worst
from hbench.report.campaign.rod_side import told_apart
from hbench.report.render.document import Section, Tile
from hbench.report.render.numbers import K95, alike, number, significant, span, with_interval
from hbench.report.render.word_tables import Cell, Table

NEAR = 0.2  # a measured speed stands for the working speed if it is no further off than this part
_LONG = 12  # rows; more start folded


@dataclass(frozen=True)
class Number:
    """A number with the half-width of its 95 % interval of trials and instruments together."""

    value: float
    u95: float | None  # of the trials alone where the instruments are not known
    flag: str = ""
    trials: float | None = None  # half-width of the trials' own interval
    se: float | None = None  # standard error of the trials' mean


@dataclass(frozen=True)
class Glance:
    """What matters of one direction and load."""

    curve: Curve
    v_m_s: float | None  # measured, next to the working speed
    friction_n: Number | None
    breakaway_n: Number | None
    efficiency: Number | None


def working_speed_m_s(results: Results) -> float | None:
    """Return the middle one of the speeds at which steady friction was measured, if any was."""
    speeds = [abs(p.v_m_s) for c in results.curves if c.kind == "steady" for p in c.points]
    return median_low(speeds) if speeds else None


def glances(results: Results, speed_m_s: float | None = None) -> tuple[Glance, ...]:
    """Return what matters of each steady curve, or of each ramp if there is no steady one."""
    speed = working_speed_m_s(results) if speed_m_s is None else speed_m_s
    steady = [curve for curve in told_apart(results.curves) if curve.kind == "steady"]
    found, seen = [], set()
    for curve in steady or [c for c in told_apart(results.curves) if c.kind == "ramp"]:
        if _series(curve) in seen:  # ramps of other accelerations
            continue
        seen.add(_series(curve))
        point = _nearest(curve.points, speed) if steady else None
        found.append(
            Glance(
                curve,
                None if point is None else abs(point.v_m_s),
                None if point is None else _friction(point),
                _breakaway(curve, results),
                _efficiency(curve, point, results),
            )
        )
    return tuple(found)


def summary_section(results: Results, speed_m_s: float | None = None) -> Section:
    """Return the page's first section: tiles, a row for each direction and load, the checks."""
    found = glances(results, speed_m_s)
    tables = (_table(found),) if found else ()
    each = "Each direction and load" if tables else ""
    fold = True if tables and len(found) > _LONG else None
    graded = checks(results)
    quality = Table(
        ("Check", "Verdict", "Found", "Limits"),
        tuple((Cell(c.name), _verdict(c.grade), Cell(c.found), Cell(c.rule)) for c in graded),
        frozenset({"Check", "Verdict", "Found", "Limits"}),
    )
    return Section(
        "Summary",
        paragraphs=(_done(results),),
        tiles=_tiles(results, found),
        parts=(
            *([Section(each, tables=tables, folded=fold)] if tables else []),
            Section("Quality of the data", (RULE,), tables=(quality,), anchor="quality"),
        ),
    )


def _tiles(results: Results, found: tuple[Glance, ...]) -> tuple[Tile, ...]:
    speeds = [one.v_m_s for one in found if one.v_m_s is not None]
    at = f"friction at {number(1e3 * median_low(speeds), 0)} mm/s" if speeds else ""
    tiles = [
        _tile([g.friction_n for g in found], 1.0, "N", at, "working-speed"),
        _tile([g.breakaway_n for g in found], 1.0, "N", "breakaway", "breakaway"),
        _tile([g.efficiency for g in found], 100.0, "%", "efficiency at that speed", "efficiency"),
    ]
    accepted, made = sum(run.accepted for run in results.runs), len(results.runs)
    graded = checks(results)
    holds = sum(check.grade == "good" for check in graded)
    return (
        *(tile for tile in tiles if tile is not None),
        Tile(f"{accepted} of {made}", "runs", "accepted"),
        Tile(worst(graded).capitalize(), "", f"data: {holds} of {len(graded)} checks are good"),
    )


def _tile(
    numbers: list[Number | None], scale: float, unit: str, words: str, how: str
) -> Tile | None:
    known = [one for one in numbers if one is not None]
    if not known:
        return None
    halves = [one.u95 for one in known if one.u95 is not None]
    flags = dict.fromkeys(one.flag for one in known if one.flag)
    partly = "" if all(one.flag for one in known) else "partly "
    words = ", ".join([words, *(partly + flag for flag in flags)])
    anchor = f"method-{how}"
    if len(known) == 1:
        half = scale * halves[0] if halves else None
        return Tile(with_interval(scale * known[0].value, half), unit, words, anchor)
    values = [scale * one.value for one in known]
    points = "percentage points" if unit == "%" else unit  # not per cent of the value
    widest = significant(scale * max(halves), 2) if halves else ""
    most = f"; 95 % interval ±{widest} {points} at most" if halves else ""
    return Tile(alike(values), unit, f"{words}, all loads and directions{most}", anchor)


def _table(found: tuple[Glance, ...]) -> Table:
    rows: list[tuple[str | Cell, ...]] = [
        (
            *who(one.curve)[:1],
            *who(one.curve)[2:],
            number(None if one.v_m_s is None else 1e3 * one.v_m_s),
            _cell(one.friction_n),
            _trials(one.friction_n),
            _cell(one.breakaway_n),
            _cell(one.efficiency, 100.0),
        )
        for one in found
    ]
    head = ("At (mm/s)", "Friction (N)", "Trials alone (N)", "Breakaway (N)", "Efficiency (%)")
    return table((WHO[0], *WHO[2:], *head), rows)


def _cell(one: Number | None, scale: float = 1.0) -> Cell:
    if one is None:
        return Cell("–")
    half = None if one.u95 is None else scale * one.u95
    return Cell(with_interval(scale * one.value, half), one.flag)


def _trials(one: Number | None) -> str:
    return "" if one is None or one.trials is None else f"±{number(one.trials)}"


def _verdict(grade: str) -> Cell:
    return Cell("good") if grade == "good" else Cell("", grade)


def _nearest(points: tuple[CurvePoint, ...], speed: float | None) -> CurvePoint | None:
    if speed is None or not points:
        return None
    best = min(points, key=lambda point: abs(abs(point.v_m_s) - speed))
    return best if abs(abs(best.v_m_s) - speed) <= NEAR * speed else None


def _breakaway(curve: Curve, results: Results) -> Number | None:
    """Return the slowest ramp's friction as the seals begin to slide; else the fit's at rest."""
    ramps = [
        c
        for c in told_apart(results.curves)
        if c.kind == "ramp" and c.fits and _series(c) == _series(curve)
    ]
    for ramp in sorted(ramps, key=lambda c: c.a_ref_m_s2 or math.inf):
        first = min((abs(v) for fit in ramp.fits for v, _ in fit.line), default=None)
        slid = [p for p in ramp.points if first is not None and abs(p.v_m_s) >= first - 1e-9]
        if slid:
            return _friction(slid[0])
    for fit in curve.fits:
        stiction = fit.parameters.get("f_stiction_n")
        if stiction is None or stiction.ci95 is None or not fit.converged:
            continue
        low, high = stiction.ci95
        half = max(stiction.value - low, high - stiction.value)
        slowest = min(curve.points, key=lambda point: abs(point.v_m_s))
        sigma = slowest.sigma_instruments_n or 0.0
        u95 = math.hypot(half, K95 * sigma)
        return Number(stiction.value, u95, "extrapolated", half, stiction.se)
    return None


def _friction(point: CurvePoint) -> Number:
    se = stdev(point.trials_n) / math.sqrt(point.n) if len(point.trials_n) > 1 else None
    u95 = point.u95_n or point.ci95_n
    flag = "one trial" if point.n == 1 else ""
    return Number(abs(point.friction_n), u95, flag, trials=point.ci95_n, se=se)


def _efficiency(curve: Curve, point: CurvePoint | None, results: Results) -> Number | None:
    if point is None:
        return None
    for own in told_apart(results.efficiency):
        if own.kind == curve.kind and _series(own) == _series(curve):
            at: EfficiencyPoint = min(own.points, key=lambda p: abs(p.v_m_s - point.v_m_s))
            if at.efficiency is not None:
                return Number(at.efficiency, at.u95 or at.ci95, se=at.sigma_trials)
    return None


def _series(curve: Curve | EfficiencyCurve) -> tuple:
    return curve.label, curve.direction, curve.f_load_n, curve.p_lr_ref_pa


def _done(results: Results) -> str:
    """Say in a sentence what was measured."""
    kinds: dict[str, int] = {}
    for run in results.runs:
        kinds[run.run.plan.kind] = kinds.get(run.run.plan.kind, 0) + 1
    made = ", ".join(f"{count} {kind}" for kind, count in kinds.items()) or "none"
    words = [f"{len(results.runs)} runs ({made})"]
    curves = [curve for curve in results.curves if curve.kind == "steady"]
    points = [point for curve in curves for point in curve.points]
    if points:
        words.append(f"steady at {span([1e3 * abs(p.v_m_s) for p in points])} mm/s")
        loads = {abs(c.f_load_n) for c in curves if c.f_load_n is not None}
        if loads:
            count = "1 load" if len(loads) == 1 else f"{len(loads)} loads"
            words.append(f"{count} of {span(loads)} N")
        both = len({curve.direction for curve in curves}) == 2
        words.append("both directions" if both else "one direction")
        if not any(curve.over_velocity for curve in curves):
            words.append(f"chamber pressure {span([p.p_tp_pa / 1e5 for p in points])} bar")
    return ", ".join(words) + "."
