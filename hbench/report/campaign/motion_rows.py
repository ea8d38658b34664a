"""Results of moving and resting runs as lines of text."""

from collections.abc import Iterator

from hbench.records import Comparison, DistanceTrend, Leakage, Level, Loop, Motions, Series, Surface
from hbench.records.numbers import SIGNIFICANCE
from hbench.report.campaign.series_words import load_words
from hbench.report.render.numbers import number, short, significant, span, whole_mm_s, with_interval
from hbench.units import from_si

LEAKS = {
    "across_piston": "across the piston",
    "piston_side_out": "from the piston side outwards",
    "rod_side_out": "from the rod side outwards",
}


DISTANCE_QUANTITIES = {  # name and unit
    "friction_n": ("Friction", "N"),
    "breakaway_n": ("Breakaway", "N"),
    "leakage_m3_s": ("Leakage", "ml/min"),
}


def series_words(series: Series) -> str:
    """Write a series, such as ``seal A, 500 N``."""
    return ", ".join(filter(None, (series.label, load_words(series.f_load_n, None))))


def motion_lines(motions: Motions) -> list[str]:
    """Return a line or a few for each kind of experiment, for a terminal."""
    return [
        *_of_comparisons(motions.comparisons),
        *map(_of_loop, motions.loops),
        *_of_levels(motions.levels),
        *(line for leakage in motions.leakages for line in _of_leakage(leakage)),
        *map(_of_surface, motions.surfaces),
        *map(_of_distance, motions.over_distance),
    ]


def comparison_words(comparison: Comparison) -> str:
    """Write the series and speeds of a comparison, such as ``500 N, extend, 10–70 mm/s``."""
    speeds = span([1e3 * comparison.v_low_m_s, 1e3 * comparison.v_high_m_s])
    return ", ".join(
        filter(None, (series_words(comparison.series), comparison.direction, f"{speeds} mm/s"))
    )


def differs(comparison: Comparison) -> bool:
    """Return whether a difference is significant after the correction for the number of tests."""
    return comparison.p_holm is not None and comparison.p_holm < SIGNIFICANCE


def distance_words(trend: DistanceTrend) -> str:
    """Write the series of a trend, such as ``run-in, 0 N, cycles up to 60 mm/s``."""
    speed = "" if trend.v_m_s is None else f"{whole_mm_s(trend.v_m_s)} mm/s"
    if speed and trend.direction is None:
        speed = f"cycles up to {speed}"
    rest = "" if trend.dwell_s is None else f"after {short(trend.dwell_s)} s"
    words = (series_words(trend.series), trend.direction or "", speed, rest)
    return ", ".join(filter(None, words))


def _of_distance(trend: DistanceTrend) -> str:
    name, unit = DISTANCE_QUANTITIES[trend.quantity]
    mean, change, half = (
        from_si(each, unit) for each in (trend.last_mean, trend.last_change, trend.last_change_ci95)
    )
    level = number(mean, 0 if unit == "N" else 3)
    return (
        f"{name.lower()} over {number(trend.distance_m[-1], 1)} m ({distance_words(trend)}): "
        f"{trend.verdict}, {level} {unit} and {_signed(change, half)} {unit} "
        f"from {number(trend.last_from_m, 1)} m on"
    )


def _of_comparisons(comparisons: tuple[Comparison, ...]) -> Iterator[str]:
    for what, title in (("acceleration", "ramps' acceleration"), ("steady", "ramp against steady")):
        chosen = [comparison for comparison in comparisons if comparison.what == what]
        tested = [comparison for comparison in chosen if comparison.p_holm is not None]
        if not tested:
            if chosen:
                yield f"{title}: not tested, {chosen[0].message}"
            continue
        clearest = min(
            tested, key=lambda comparison: (comparison.p_holm, -abs(comparison.effect_n))
        )
        p = significant(clearest.p_holm, 2)
        # No interval: that of one comparison is too narrow for the largest of many.
        yield (
            f"{title}: {sum(map(differs, tested))} of {len(tested)} comparisons differ "
            f"(p < {SIGNIFICANCE:g} after Holm); the clearest: "
            f"{_signed(clearest.effect_n, None)} N, p {p} ({comparison_words(clearest)})"
        )


def _signed(value: float, half: float | None) -> str:
    return ("+" if value > 0 else "") + with_interval(value, half).replace("±", "+-")


def _of_loop(loop: Loop) -> str:
    text = (
        f"hysteresis ({series_words(loop.series)}, up to {short(1e3 * loop.v_top_m_s)} mm/s): "
        f"{with_interval(loop.area_j, loop.area_ci95_j).replace('±', '+-')} J of friction work a "
        "cycle"
    )
    if loop.unit == "cycle":
        text += f" over {loop.cycles} cycles of 1 trial"
    return f"{text} (+-: trials alone)"


def _of_levels(levels: tuple[Level, ...]) -> Iterator[str]:
    if not levels:
        return
    seen = [
        (level.overshoot_n, level.resolved) for level in levels if level.overshoot_n is not None
    ]
    over = [overshoot_n for overshoot_n, resolved in seen if resolved]
    settled = [level.settling_s for level in levels if level.settling_s is not None]
    step = f" in steps of {short(levels[0].settling_step_s)} s" if levels[0].settling_step_s else ""
    hidden = len(seen) - len(over)
    yield (
        f"steps: {len(levels)} levels"
        + (f", friction overshoots by up to {short(max(over))} N" if over else "")
        + (f", {hidden} overshoots that the log does not resolve" if hidden else "")
        + (f", settled after {span(settled)} s{step}" if settled else "")
    )


def _of_leakage(leakage: Leakage) -> Iterator[str]:
    holds = f"leakage ({len(leakage.decays)} holds)"
    for coefficient, highest, flow in leakage.at_highest_pressure():
        where = f"{holds} {LEAKS[coefficient.name]}"
        if flow is None:
            known = coefficient.value is not None
            yield f"{where}: {'no interval' if known else 'not determined'}"
        else:
            value, half = (from_si(each, "ml/min") for each in flow)
            text = with_interval(value, half).replace("±", "+-")
            note = ", the interval contains 0" if abs(value) <= half else ""
            yield f"{where}: {text} ml/min at {number(from_si(highest, 'bar'), 1)} bar{note}"


def _of_surface(surface: Surface) -> str:
    label = f"{surface.label}, " if surface.label else ""
    return (
        f"friction over velocity and load ({label}{surface.direction}): "
        f"{len(surface.f_load_n)} loads {span(surface.f_load_n)} N, {len(surface.v_m_s)} speeds"
    )
