"""Headline numbers: a sentence of the first quantity that was measured, and tiles of all."""

from collections.abc import Collection, Iterable, Sequence
from statistics import median_low

from hbench.records import DIRECTION_WORDS, Direction, HeadlineNumber, HeadlineSeries, Results
from hbench.report.campaign.distance_verdict import endurance_words, run_in_words
from hbench.report.campaign.motion_rows import LEAKS
from hbench.report.campaign.quality.verdict import quality_count
from hbench.report.campaign.reasons import aborted_words
from hbench.report.drift import possible_words
from hbench.report.render.numbers import (
    alike,
    half_width,
    number,
    percent_span,
    short,
    significant,
    span,
    span_with_intervals,
    whole_mm_s,
    with_interval,
)
from hbench.report.render.word_tables import Tile
from hbench.sentences import listed
from hbench.units import from_si

FLAGS = {  # how a number was determined, by its basis
    "trials": "",
    "one_trial": "one trial",
    "extrapolated": "extrapolated",
    "ramp": "ramp",
    "breakaway": "",
}


def headline_words(results: Results) -> str:
    """Return the first quantity that was measured, such as friction, in a sentence.

    Changes between blocks of cycles follow. Empty without any quantity, and where the data is poor
    or the campaign was aborted. The tiles contain the other quantities.
    """
    series = results.headline.series
    if not _is_reliable(results):
        return ""
    if not series:
        return _leakage_words(results) or run_in_words(results)
    speeds = [each.v_m_s for each in series if each.v_m_s is not None]
    speed = f" at {speed_words(results.headline.v_tolerance, speeds)} mm/s" if speeds else ""
    quantities = (
        (f"friction{speed}", [each.friction_n for each in series], 1.0, "N"),
        (f"breakaway{_after_rest(series)}", [each.breakaway_n for each in series], 1.0, "N"),
        ("efficiency", [each.efficiency for each in series], 100.0, "%"),
    )
    parts = [
        (name, words, numbers)
        for name, numbers, scale, unit in quantities
        if (words := _span_words(numbers, scale, unit, [each.direction for each in series]))
    ]
    if not parts:
        return ""
    name, words, numbers = parts[0]
    where = f", over {_of_series(numbers, series)}" if len(series) > 1 else ""
    both = len({each.direction for each in series}) > 1  # named with their ranges
    if both:
        where = where.replace("all loads and directions", "all loads")
        where = where.removesuffix(", over both directions")
    first = f"{name[:1].upper()}{name[1:]} is {words}{where}{possible_drift_words(results)}."
    return " ".join(filter(None, (first, endurance_words(results))))


def _after_rest(series: Iterable[HeadlineSeries]) -> str:
    """State the time at rest before breakaway, where it was measured after the same one in all."""
    rests = {each.breakaway_dwell_s for each in series if each.breakaway_n is not None}
    rest = rests.pop() if len(rests) == 1 else None
    return "" if rest is None else f" after {short(rest)} s at rest"


def _is_reliable(results: Results) -> bool:
    return results.quality.grade != "poor" and not aborted_words(results)


def _has_headline(results: Results) -> bool:
    return bool(results.headline.series) and _is_reliable(results)


def possible_drift_words(results: Results) -> str:
    """State a possible drift that U does not contain; empty without one, or without a headline."""
    drift = results.drift
    if not _has_headline(results) or drift is None or drift.separated or not drift.hidden:
        return ""
    return f"; U does not contain a possible drift of up to {possible_words(drift)}"


def headline_tiles(results: Results) -> Iterable[Tile]:
    """Yield a tile for each quantity that was measured, the accepted runs and the data's grade.

    Poor data has no tiles of quantities: nobody is to rely on them.
    """
    if results.quality.grade != "poor":
        yield from _quantity_tiles(results)
    yield from _data_tiles(results)


def _quantity_tiles(results: Results) -> Iterable[Tile]:
    series = results.headline.series
    speeds = [each.v_m_s for each in series if each.v_m_s is not None]
    at = f"friction at {speed_words(results.headline.v_tolerance, speeds)} mm/s" if speeds else ""
    weak = _weak_extrapolation(results)
    breakaway = "breakaway by Tustin's law" if weak else f"breakaway{_after_rest(series)}"
    quantities = (
        ([each.friction_n for each in series], 1.0, "N", at, "working-speed"),
        ([each.breakaway_n for each in series], 1.0, "N", breakaway, "breakaway"),
        (
            [each.efficiency for each in series],
            100.0,
            "%",
            "efficiency at that speed",
            "efficiency",
        ),
    )
    for numbers, scale, unit, caption, anchor in quantities:
        where = _of_series(numbers, series) if len(series) > 1 else ""
        yield from _tile(numbers, scale, unit, caption, anchor, where)
    yield from _band_tiles(results)
    yield from _leakage_tile(results)


def _weak_extrapolation(results: Results) -> str:
    """State how many fits determine the law that breakaway is extrapolated by; empty if all do."""
    numbers = [each.breakaway_n for each in results.headline.series]
    if not any(each is not None and each.basis == "extrapolated" for each in numbers):
        return ""
    tustin = next((each for each in results.fit_verdicts if each.law == "tustin"), None)
    if tustin is None or tustin.determined == tustin.fits:
        return ""
    return f"{tustin.determined} of {tustin.fits} Tustin fits determine all their parameters"


def extrapolated_words(results: Results) -> str:
    """State what an extrapolated breakaway rests on where not all fits are determined; else empty.

    Friction may be larger than such a breakaway, which is explained where both agree within U.
    """
    weak = _weak_extrapolation(results)
    if not weak:
        return ""
    pairs = [
        (each.breakaway_n, each.friction_n.value - each.breakaway_n.value)
        for each in results.headline.series
        if each.breakaway_n is not None and each.friction_n is not None
    ]
    above = [(number, more) for number, more in pairs if more > 0]
    within = all(number.u95 is not None and more < number.u95 for number, more in above)
    equal = (
        " Where friction at the working speed is larger, the difference is within U: the data do "
        "not show a breakaway above it."
        if above and within
        else ""
    )
    return (
        f"Extrapolated to rest, which is no measurement. {weak}. Before relying on breakaway, "
        f"measure it with runs of kind breakaway.{equal}"
    )


def _data_tiles(results: Results) -> Iterable[Tile]:
    accepted = sum(run.accepted for run in results.runs)
    planned = results.quality.completeness.planned
    if planned is None:
        yield Tile(f"{accepted} of {len(results.runs)}", "runs", "accepted")
    else:
        yield Tile(f"{accepted} of {planned}", "runs", "accepted, of those planned")
    caption = f"data: {quality_count(results.quality)}"
    yield Tile(results.quality.grade.capitalize(), "", caption)


def _band_tiles(results: Results) -> Iterable[Tile]:
    """Yield the half band over all pressures, and its slope."""
    if results.bands:
        halves = [band.half_ci95_n for band in results.bands if band.half_ci95_n is not None]
        most = f"; 95 % interval ±{half_width(max(halves))} N at most" if halves else ""
        value = alike([band.half_n for band in results.bands])
        caption = f"half band: mean of extending and retracting friction, all pressures{most}"
        yield Tile(value, "N", caption, "method-half-band-and-middle")
    if results.band_trends:
        lines = [trend.half for trend in results.band_trends]
        slopes = [line.slope_n_pa / from_si(1.0, "bar") for line in lines]
        widest = max(line.slope_ci95_n_pa for line in lines) / from_si(1.0, "bar")
        value = with_interval(slopes[0], widest) if len(slopes) == 1 else alike(slopes)
        most = f"; 95 % interval ±{significant(widest, 2)} N/bar at most" if len(slopes) > 1 else ""
        caption = f"slope of the half band over pressure{most}"
        yield Tile(value, "N/bar", caption, "method-lines-over-pressure")


def _leakage_tile(results: Results) -> Iterable[Tile]:
    """Yield the largest leak; beside friction one whose interval does not contain 0."""
    largest = _largest_leak(results)
    if largest and not (largest[2] and results.headline.series):
        flow, where, remark = largest
        caption = ", ".join(filter(None, (f"largest leakage, {where}", remark)))
        yield Tile(flow, "ml/min", caption, "method-leakage")


def _leakage_words(results: Results) -> str:
    if not (largest := _largest_leak(results)):
        return ""
    flow, where, remark = largest
    return f"The largest leakage is {flow} ml/min, {where}{remark and f' ({remark})'}."


def _largest_leak(results: Results) -> tuple[str, str, str] | None:
    """Return the largest leak at the highest pressure of its holds in ml/min, where, and a remark.

    None without a leak that the holds determine.
    """
    known = [
        (flow, f"{LEAKS[leak.name]} at {number(from_si(pressure_pa, 'bar'), 0)} bar", leakage.label)
        for leakage in results.motions.leakages
        for leak, pressure_pa, flow in leakage.at_highest_pressure()
        if flow is not None
    ]
    if not known:
        return None
    (value, half), where, label = max(known)
    if len({each for _, _, each in known}) > 1:
        where = f"{label}, {where}"
    text = with_interval(from_si(value, "ml/min"), from_si(half, "ml/min"))
    return text, where, "" if abs(value) > half else "the interval contains 0"


def _tile(
    numbers: Sequence[HeadlineNumber | None],
    scale: float,
    unit: str,
    caption: str,
    anchor: str,
    where: str,
) -> Iterable[Tile]:
    known = [each for each in numbers if each is not None]
    if not known:
        return
    halves = [each.u95 for each in known if each.u95 is not None]
    caption = ", ".join(filter(None, (caption, *_flag_words(known), where)))
    anchor = f"method-{anchor}"
    if len(known) == 1:
        half = scale * halves[0] if halves else None
        yield Tile(with_interval(scale * known[0].value, half), unit, caption, anchor)
        return
    points = "percentage points" if unit == "%" else unit  # not per cent of the value
    widest = half_width(scale * max(halves)) if halves else ""
    most = f"; U up to {widest} {points}" if halves else ""
    yield Tile(_ends(known, scale, known), unit, f"{caption}{most}", anchor)


def _of_series(numbers: Sequence[HeadlineNumber | None], series: Sequence[HeadlineSeries]) -> str:
    """Count the loads and directions that have a number; labelled ones are series."""
    known = sum(each is not None for each in numbers)
    count = "all" if known == len(numbers) else f"{known} of {len(numbers)}"
    labelled = len({each.label for each in series}) > 1
    if count == "all" and not labelled and len({each.direction for each in series}) == len(series):
        return "both directions"
    return f"{count} {'series' if labelled else 'loads and directions'}"


def _span_words(
    every: Sequence[HeadlineNumber | None],
    scale: float,
    unit: str,
    directions: Sequence[Direction],
) -> str:
    """Return numbers as ranges by direction, with their largest U and how they were determined."""
    sides: dict[Direction, list[HeadlineNumber]] = {}
    for each, direction in zip(every, directions, strict=True):
        if each is not None:
            sides.setdefault(direction, []).append(each)
    numbers = [each for side in sides.values() for each in side]
    if not numbers:
        return ""
    remarks = _flag_words(numbers)
    if halves := [scale * each.u95 for each in numbers if each.u95 is not None]:
        most = "up to " if len(numbers) > 1 else ""
        points = "percentage points" if unit == "%" else unit
        remarks.append(f"U {most}{half_width(max(halves))} {points}{_shares(numbers, unit)}")
    several = len(sides) > 1
    text = listed(
        [
            f"{_ends(side, scale, numbers)} {unit}{f' {DIRECTION_WORDS[way]}' if several else ''}"
            for way, side in sides.items()
        ]
    )
    return f"{text} ({'; '.join(remarks)})" if remarks else text


def _ends(numbers: Iterable[HeadlineNumber], scale: float, every: Iterable[HeadlineNumber]) -> str:
    """Return the smallest and the largest number, rounded alike for all parts of ``every`` one."""
    halves = ((each.value, each.u95) for each in numbers)
    return span_with_intervals(
        [(scale * value, None if half is None else scale * half) for value, half in halves],
        max((scale * each.u95 for each in every if each.u95 is not None), default=None),
    )


def _shares(numbers: Iterable[HeadlineNumber], unit: str) -> str:
    """Return U as a share of each number, both unrounded; empty for efficiencies."""
    shares = [100 * each.u95 / abs(each.value) for each in numbers if each.u95 and each.value]
    return "" if unit == "%" or not shares else f", {percent_span(shares)} of the value"


def _flag_words(numbers: list[HeadlineNumber]) -> list[str]:
    flags = dict.fromkeys(FLAGS[each.basis] for each in numbers if FLAGS[each.basis])
    partly = "" if all(FLAGS[each.basis] for each in numbers) else "partly "
    return [partly + flag for flag in flags]


def speed_words(tolerance: float, speeds_m_s: Collection[float]) -> str:
    """Write the median of speeds that are the same, or else their range."""
    middle = median_low(speeds_m_s)
    if all(abs(v - middle) <= tolerance * middle for v in speeds_m_s):
        return whole_mm_s(middle)
    return span([1e3 * v for v in speeds_m_s])
