"""The page's tables of moving and resting runs."""

from collections.abc import Iterable

from hbench.channels import CHANNELS
from hbench.records import DIRECTION_WORDS, Comparison, DwellLaw, Leakage, Results, Zero
from hbench.report.campaign.motion_rows import (
    DISTANCE_QUANTITIES,
    LEAKS,
    differs,
    distance_words,
    series_words,
)
from hbench.report.campaign.table_columns import table
from hbench.report.render.numbers import (
    NONE,
    in_mm_s,
    number,
    short,
    significant,
    span,
    with_interval,
)
from hbench.report.render.word_tables import Cell, Table
from hbench.units import from_si


def comparison_table(results: Results) -> Table:
    """Return the tested differences between ramps, and between ramps and steady runs."""
    head = ("Compared", "Load", "Direction", "Speeds (mm/s)", "Difference (N)", "p", "p after Holm")
    rows = [
        (
            _compared(comparison),
            series_words(comparison.series),
            DIRECTION_WORDS[comparison.direction],
            span([1e3 * comparison.v_low_m_s, 1e3 * comparison.v_high_m_s]),
            with_interval(comparison.effect_n, comparison.ci95_n),
            significant(comparison.p_value, 2),
            Cell(significant(comparison.p_holm, 2), "differs" if differs(comparison) else ""),
            str(comparison.n),
            comparison.message,
        )
        for comparison in results.motions.comparisons
    ]
    return table((*head, "Trials", "Remark"), rows, words=("Compared", "Load"))


def loop_table(results: Results) -> Table:
    """Return energy and widths of the hysteresis loops."""
    head = (
        *(
            "Triangle",
            "Top speed (mm/s)",
            "Cycles averaged",
            "Energy a cycle ± trials (J)",
            "At v (mm/s)",
        ),
        *("Width ± trials (N)", "Width by the board's velocity (N)"),
    )
    rows = [
        (
            series_words(loop.series),
            short(1e3 * loop.v_top_m_s),
            str(loop.cycles),
            with_interval(loop.area_j, loop.area_ci95_j),
            in_mm_s(width.v_m_s),
            with_interval(width.width_n, width.ci95_n),
            number(width.board_n),
        )
        for loop in results.motions.loops
        for width in loop.widths
    ]
    return table(head, rows, words=("Triangle",))


def level_table(results: Results) -> Table:
    """Return the steps of the reference and the friction's response."""
    head = (
        *("Load", "From (mm/s)", "To (mm/s)", "Friction before (N)", "Friction after (N)"),
        *("Overshoot (N)", "Settled after (s), in whole records", "Trials", "Remark"),
    )
    rows = [
        (
            series_words(level.series),
            in_mm_s(level.v_from_m_s),
            in_mm_s(level.v_to_m_s),
            number(level.before_n),
            with_interval(level.after_n, level.after_ci95_n),
            Cell(
                with_interval(level.overshoot_n, level.overshoot_ci95_n),
                "" if level.resolved else "not resolved",
            ),
            number(level.settling_s, 2)
            if level.settling_ci95_s is None
            else with_interval(level.settling_s, level.settling_ci95_s),
            str(level.n),
            level.remark,
        )
        for level in results.motions.levels
    ]
    return table(head, rows, words=("Load",))


def leak_table(results: Results) -> Table:
    """Return the leaks at the highest pressure of their holds, and below them their conditions."""
    rows = []
    for leakage in results.motions.leakages:
        for coefficient, highest, flow in leakage.at_highest_pressure():
            if coefficient.value is None:
                cell = Cell(NONE, "not determined")
            elif flow is None:
                cell = Cell(NONE, "no interval")
            else:
                cell = Cell(with_interval(*(from_si(each, "ml/min") for each in flow)))
            at = number(from_si(highest, "bar"), 1)
            rows.append((leakage.label, LEAKS[coefficient.name], at, cell))
    leakages = results.motions.leakages
    several = len({leakage.label for leakage in leakages}) > 1
    messages = dict.fromkeys(m for leakage in leakages for m in _remarks(leakage, several))
    head = ("Label", "Leak", "At (bar)", "Leakage (ml/min)")
    return table(head, rows, tuple(messages), words=("Leak",))


def _remarks(leakage: Leakage, several: bool) -> Iterable[str]:
    """Yield the remarks on leaks, a sentence each, with the label where there are ``several``."""
    message = leakage.message.replace("beta / V", "β/V")
    for name, words in LEAKS.items():
        message = message.replace(name, f"the leak {words}")
    for remark in filter(None, message.split("; ")):
        text = f"{leakage.label}: {remark}" if several else remark
        yield f"{text[:1].upper()}{text[1:]}."


def hold_table(results: Results) -> Table:
    """Return what each hold measured, without a law of the leaks; not finer than U of the leaks."""
    head = (
        *("Run", "Load", "P_Tp (bar)", "P_Tr (bar)", "Difference (bar)"),
        *("Out of the piston side (ml/min)", "Out of the rod side (ml/min)"),
        "Out of the cylinder (ml/min)",
    )
    flows = [
        from_si(q, "ml/min")
        for leakage in results.motions.leakages
        for decay in leakage.decays
        for q in (decay.out_p_m3_s, decay.out_r_m3_s)
    ]
    decimals = _decimals(max(map(abs, flows), default=1.0))
    if halves := [from_si(half, "ml/min") for half in _half_widths(results) if half > 0]:
        decimals = min(decimals, _decimals(min(halves)))
    rows = [
        (
            decay.run,
            series_words(decay.series),
            *(
                number(from_si(p, "bar"), 1)
                for p in (decay.p_p_pa, decay.p_r_pa, decay.p_p_pa - decay.p_r_pa)
            ),
            *(
                number(from_si(q, "ml/min"), decimals)
                for q in (
                    decay.out_p_m3_s,
                    decay.out_r_m3_s,
                    decay.out_p_m3_s + decay.out_r_m3_s,
                )
            ),
        )
        for leakage in results.motions.leakages
        for decay in leakage.decays
    ]
    return table(head, rows, words=("Load",))


def _decimals(value: float) -> int:
    """Return the decimals of a number with two significant digits."""
    return len(significant(value, 2).partition(".")[2])


def _half_widths(results: Results) -> Iterable[float]:
    """Yield U [m^3/s] of each leak at the highest pressure of its holds."""
    for leakage in results.motions.leakages:
        for _, _, flow in leakage.at_highest_pressure():
            if flow is not None:
                yield flow[1]


def breakaway_table(results: Results) -> Table:
    """Return breakaway of each direction, load, rest and rate."""
    known = any(each.u95_n is not None for each in results.motions.breakaways)
    of = "U" if known else "trials"
    head = (
        *("Load", "Direction", "At rest (s)", "Rate (N/s)"),
        *(f"Breakaway ± {of} (N)", f"Breakaway ± {of} (bar)"),
        *("Trials alone (N)", "Trials", "Creep (mm)"),
    )
    rows = [
        (
            series_words(each.series),
            DIRECTION_WORDS[each.direction],
            "" if each.dwell_s is None else short(each.dwell_s),
            "" if each.rate_n_s is None else short(each.rate_n_s),
            with_interval(each.breakaway_n, each.u95_n or each.ci95_n),
            "" if each.breakaway_pa is None else _in_bar(each.breakaway_pa, each.u95_pa),
            "" if each.ci95_n is None else f"±{significant(each.ci95_n, 2)}",
            str(each.n),
            number(1e3 * each.displacement_m, 2),
        )
        for each in results.motions.breakaways
    ]
    return table(head, rows, words=("Load",))


def dwell_table(results: Results) -> Table:
    """Return the laws of breakaway over the time at rest, the better one of each load first."""
    head = (*("Load", "Direction", "Law", "After 1 s (N)", "Growth", "RMS error (N)", "Trials"),)
    rows = [
        (
            series_words(law.series),
            DIRECTION_WORDS[law.direction],
            law.law,
            with_interval(law.f_1s_n, law.f_1s_ci95_n),
            _growth(law),
            number(law.rmse_n, 1),
            str(law.n),
        )
        for law in results.motions.dwell_laws
    ]
    return table(head, rows, words=("Load", "Law"))


def distance_table(results: Results) -> Table:
    """Return trends over the distance, and whether each quantity has settled."""
    head = (
        *("Quantity", "Of", "Distance (m)", "Change over the distance", "p after Holm"),
        *("Mean of the last half", "Change over the last half", "Verdict"),
    )
    rows = []
    for trend in results.motions.over_distance:
        name, unit = DISTANCE_QUANTITIES[trend.quantity]
        scale = from_si(1.0, unit)
        over = scale * (trend.distance_m[-1] - trend.distance_m[0])
        rows.append(
            (
                f"{name} ({unit})",
                distance_words(trend),
                number(trend.distance_m[-1] - trend.distance_m[0], 1),
                with_interval(over * trend.slope, over * trend.slope_ci95),
                significant(trend.p_holm, 2),
                number(scale * trend.last_mean, 0 if unit == "N" else 3),
                with_interval(scale * trend.last_change, scale * trend.last_change_ci95),
                trend.verdict,
            )
        )
    return table(head, rows, words=("Quantity", "Of", "Verdict"))


def zero_table(results: Results) -> Table:
    """Return the zero errors of each sensor in each check, in bar or N."""
    checks = results.motions.zero_checks
    head = ("Sensor", *(f"Run {check.run}" for check in checks), "Tolerance at full scale")
    rows: list[tuple[str | Cell, ...]] = []
    for channel in dict.fromkeys(zero.channel for check in checks for zero in check.zeros):
        of = {c.run: zero for c in checks for zero in c.zeros if zero.channel == channel}
        unit = "N" if channel == "f_applied_n" else "bar"
        limit = next(iter(of.values())).limit
        rows.append(
            (
                f"{CHANNELS[channel].symbol} ({unit})",
                *(_zero(of.get(check.run), unit) for check in checks),
                short(from_si(limit, unit)),
            )
        )
    return table(head, rows, words=("Sensor",))


def _in_bar(value_pa: float, half_pa: float | None) -> str:
    half = None if half_pa is None else from_si(half_pa, "bar")
    return with_interval(from_si(value_pa, "bar"), half)


def _zero(zero: Zero | None, unit: str) -> Cell:
    if zero is None:
        return Cell(NONE)
    return Cell(number(from_si(zero.error, unit), 3), "lowest value" if zero.clipped else "")


def _growth(law: DwellLaw) -> str:
    if law.law == "logarithmic":
        return with_interval(law.growth, law.growth_ci95) + " N a decade"
    return "exponent " + with_interval(law.growth, law.growth_ci95)


def _compared(comparison: Comparison) -> str:
    a = [short(value) for value in comparison.a_m_s2]
    if comparison.what == "acceleration":
        return f"ramps of {', '.join(a)} m/s²: the last less the first"
    return f"ramp of {a[0]} m/s² less steady"
