"""Repeatability, reproducibility, control charts and wear of a fleet, in words and tables."""

import math
from collections.abc import Iterator

from hbench.records import (
    CYLINDER,
    ChartStep,
    ControlChart,
    Estimate,
    Fleet,
    Precision,
    VarianceSource,
    WearTrend,
    WordTable,
)
from hbench.records.conformity.acceptance import ConformityCheck
from hbench.report.conformity.text import check_words, limit_words
from hbench.report.fleet.names import (
    in_sentence,
    name_of,
    of_change,
    of_side,
    signed,
    without_condition,
)
from hbench.report.render.numbers import NONE, number, significant, with_ends, with_interval
from hbench.report.render.symbols import capital
from hbench.units import from_si

METHOD = (
    (
        "Repeatability and reproducibility",
        "A number is the sum of a mean, an effect of each factor that the plan varies, and "
        "the scatter of the trials. The variances are estimated by REML; their intervals are those "
        "of the profile likelihood, at 95 %. ANOVA (Henderson III) gives the same in a balanced "
        "plan where no estimate is negative. s_r is the standard deviation of the trials of one "
        "campaign, s_R that of single trials under all conditions of the plan: everything but the "
        "cylinders. The limits r = 2.8 s_r and R = 2.8 s_R are exceeded by the difference of two "
        "single trials in 5 % of cases (ISO 5725-6); two campaigns of n trials each may differ by "
        "√(R² − r² (1 − 1/n)). Effects are taken as normal: heavy tails make the intervals too "
        "narrow. A factor with two or three levels has a wide interval. "
        "Mountings are those of one cylinder. Errors of the instruments are common to all "
        "campaigns of a bench and are not included.",
    ),
    (
        "Share of tolerance",
        "%GRR is s_R over the standard deviation of all sources, or 6 s_R over the width of the "
        "tolerance (--tolerance). By the AIAG's rule up to 10 % is good and above 30 % not "
        "acceptable. The number of distinct categories (ndc) is 1.41 times the standard deviation "
        "between cylinders over s_R; at least 5 are asked for.",
    ),
    (
        "Capability",
        "Cpk = min(upper limit − mean, mean − lower limit) / (3 s); s is the standard deviation of "
        "the campaigns, the measurement's scatter included. The 95 % interval is Bissell's, for "
        "normal values. At least 10 campaigns are needed, of the same kind. Values are those "
        "of hbench accept, which measures what a limit applies to; for a limit of all loads at the "
        "working speed, those of the table of campaigns.",
    ),
    (
        "Control charts",
        "Individual values with moving ranges (ISO 7870-2): the limits are the mean ± 3 σ with "
        "σ = mean moving range / 1.128; the limit of the moving range is 3.267 times its mean. "
        "The rules are those of Western Electric (1956) and Nelson (1984), each by its number. "
        "The EWMA is z_i = λ x_i + (1 − λ) z_i−1 with λ = 0.1; its limits are the mean ± L σ "
        "√(λ/(2 − λ) (1 − (1 − λ)²ⁱ)) with L = 2.7 (Montgomery). Where several cylinders "
        "were measured three times or more, the charts show the deviation from their own mean, "
        "scaled by √(n/(n − 1)). At least 10 campaigns with a date are needed. Without any "
        "change a false signal comes in the mean every 370 points beyond 3 σ, every 356 by the "
        "EWMA, and every 78 by any of the individuals chart's rules; more often where few "
        "campaigns determine mean and σ.",
    ),
    (
        "Change points",
        "The most likely step of the mean: the split into two parts with the largest likelihood "
        "ratio, at least three campaigns each. p is that of a permutation test with 1999 random "
        "orders of a fixed seed, corrected after Holm for the number of charts. A steady drift "
        "appears as a step, too. The interval of a step is that at the chosen campaign.",
    ),
    (
        "Wear",
        "Distance and friction work are those of the logged runs of a cylinder's campaigns, summed "
        "in the order of their dates; motion between the runs is not logged and not included. "
        "Rejected runs count with the mean friction of the accepted ones. The "
        "line is a least-squares line, its interval Student's at 95 %, p is corrected after Holm "
        "for the number of lines. At least 4 campaigns of a cylinder are needed. Whatever else "
        "changes with time, such as the oil, appears as wear too.",
    ),
)
_NAMED = 5  # campaigns in a sentence
_AMOUNTS = {
    "distance_m": ("distance", "km", 1e-3),
    "friction_work_j": ("friction work", "MJ", 1e-6),
}


def limit_sentences(fleet: Fleet) -> Iterator[str]:
    """Yield repeatability and reproducibility limits of the main numbers."""
    for study in main_studies(fleet):
        r, limit = study.limits
        scale, unit = study.quantity.scale, study.quantity.unit
        name = f"{without_condition(study.quantity)}{of_side(study.direction)}"
        yield (
            f"{name}: repeatability limit {significant(scale * r, 2)} {unit}, reproducibility "
            f"limit {significant(scale * limit, 2)} {unit}{_tolerance_words(study)}."
        )


def change_sentences(fleet: Fleet) -> Iterator[str]:
    """Yield steps, campaigns beyond the control limits, and significant wear."""
    steps: dict[str, list[str]] = {}
    largest: dict[str, float] = {}
    for chart in fleet.charts:
        if chart.step is not None and chart.step.real:
            scale, unit = chart.quantity.scale, chart.quantity.unit
            before, after = (
                significant(scale * mean, 4) for mean in (chart.step.before, chart.step.after)
            )
            name = f"{in_sentence(chart.quantity)}{of_side(chart.direction)}"
            at = chart.step.name
            size = step_size(chart.step, scale)
            words = f"{name}, by {size} {of_change(unit)} ({before} to {after} {unit})"
            steps.setdefault(at, []).append(words)
            largest[at] = max(largest.get(at, 0.0), chart.step.p_holm)
    for at, changes in steps.items():
        yield (
            f"From {at} on the mean has changed (p at most {significant(largest[at], 2)}): "
            f"{'; '.join(changes[:_NAMED])}"
            f"{f'; and {len(changes) - _NAMED} more' if len(changes) > _NAMED else ''}. "
            "Check what changed there: the cylinders, the bench or its instruments."
        )
    beyond: dict[str, list[str]] = {}
    for chart in fleet.charts:
        for name in chart.outside:
            beyond.setdefault(name, []).append(_side_of_limits(chart, name))
    if beyond:
        names = [f"{name} ({'; '.join(sides)})" for name, sides in beyond.items()]
        yield f"Campaigns beyond the control limits: {_named(tuple(names)[:_NAMED], len(beyond))}."
    for trend in fleet.wear:
        if trend.real:
            yield (
                f"{trend.specimen}: {name_of(trend)} changes with {_AMOUNTS[trend.over][0]} by "
                f"{_slope(trend)} {slope_unit(trend)}."
            )


def _side_of_limits(chart: ControlChart, name: str) -> str:
    """Write of which number a campaign is beyond the limits, and on which side if it is drawn."""
    number = f"{in_sentence(chart.quantity)}{of_side(chart.direction)}"
    value = dict(zip(chart.names, chart.values, strict=True)).get(name)
    if value is None:
        return number
    return f"{number}: {'above' if value > chart.centre else 'below'}"


def main_studies(fleet: Fleet) -> list[Precision]:
    """Return the studies of friction: of the band, or else of each direction."""
    names = ("half_band_n", "friction_n")
    for name in names:
        studies = [study for study in fleet.precision if study.quantity.name == name]
        if studies:
            return studies
    return []


def components_table(fleet: Fleet) -> WordTable:
    """Return the standard deviation of each source, and its share of the variance."""
    rows = []
    for study in fleet.precision:
        total = sum(source.variance.value for source in study.sources)
        for source in study.sources:
            rows.append(
                (
                    name_of(study) if source is study.sources[0] else "",
                    source_words(source),
                    _levels(source),
                    _root(source.variance, study.quantity.scale),
                    f"{number(100 * source.variance.value / total)} %",
                    _anova(source, study.quantity.scale),
                )
            )
    head = ("Number", "Source", "Levels", "σ (95 %)", "Share of variance", "σ by ANOVA")
    return WordTable("Variance components", head, tuple(rows))


def limits_table(fleet: Fleet) -> WordTable:
    """Return repeatability and reproducibility of each number, and %GRR."""
    rows = []
    for study in fleet.precision:
        scale = study.quantity.scale
        r, limit = study.limits
        rows.append(
            (
                name_of(study),
                _interval(study.repeatability, scale),
                _interval(study.reproducibility, scale),
                significant(scale * r, 2),
                significant(scale * limit, 2),
                f"{significant(scale * study.critical_difference, 2)} (n = {study.trials:.3g})",
                _percent(study.share_of_total),
                _share(study.share_of_tolerance),
                NONE
                if study.distinct_categories is None
                else significant(study.distinct_categories, 2),
            )
        )
    head = (
        "Number",
        "s_r",
        "s_R",
        "Limit r",
        "Limit R",
        "Of two campaigns",
        "%GRR of all",
        "%GRR of tolerance",
        "ndc",
    )
    kept = [i for i in range(len(head)) if i < 6 or any(row[i] != NONE for row in rows)]
    return WordTable(
        "Repeatability and reproducibility",
        tuple(head[i] for i in kept),
        tuple(tuple(row[i] for i in kept) for row in rows),
    )


def chart_table(fleet: Fleet) -> WordTable:
    """Return the control limits of each number, and the campaigns beyond them."""
    rows = []
    for chart in fleet.charts:
        scale = chart.quantity.scale
        low, high = (significant(scale * limit, 4) for limit in chart.limits)
        rows.append(
            (
                name_of(chart),
                str(chart.n),
                significant(scale * chart.centre, 4),
                f"{low} to {high}",
                _named(chart.outside, chart.beyond),
                str(chart.moved),
            )
        )
    head = ("Number", "Campaigns", "Mean", "Limits", "Beyond them", "Moving ranges beyond")
    return WordTable("Control charts", head, tuple(rows))


def signal_table(fleet: Fleet) -> WordTable:
    """Return each rule that signals on a control chart, with the first campaigns."""
    rows = tuple(
        (name_of(chart), signal.rule, str(signal.count), _named(signal.names, signal.count))
        for chart in fleet.charts
        for signal in chart.signals
    )
    return WordTable("Signals of the control charts", ("Number", "Rule", "Points", "At"), rows)


def step_table(fleet: Fleet) -> WordTable:
    """Return the most likely step of the mean of each number."""
    rows = []
    for chart in fleet.charts:
        if (step := chart.step) is None:
            continue
        scale = chart.quantity.scale
        before, after = (significant(scale * mean, 4) for mean in (step.before, step.after))
        rows.append(
            (
                name_of(chart),
                step.name,
                before,
                after,
                step_size(step, scale),
                significant(step.p_holm, 2),
                "step" if step.real else "not significant",
            )
        )
    head = ("Number", "From campaign", "Mean before", "After", "Step (95 %)", "p (Holm)", "Verdict")
    return WordTable("Change points", head, tuple(rows))


def step_size(step: ChartStep, scale: float) -> str:
    """Write the size of a step with its 95 % interval."""
    return signed(with_interval(scale * (step.after - step.before), scale * step.ci95))


def capability_table(fleet: Fleet) -> WordTable:
    """Return Cpk of each limited quantity, with its interval."""
    rows = []
    for each in fleet.capabilities:
        unit = each.requirement.unit
        measured = ConformityCheck(each.requirement, each.series, None, "NOT TESTED")
        rows.append(
            (
                capital(check_words(measured)),
                str(each.n),
                limit_words(each.requirement),
                f"{significant(from_si(each.series.value, unit), 4)} {unit}",
                significant(from_si(each.sigma, unit), 2),
                with_ends(each.cpk.value, each.cpk.low, each.cpk.high or each.cpk.value),
                str(each.outside),
            )
        )
    head = ("Quantity", "Campaigns", "Limit", "Mean", "s", "Cpk", "Beyond the limit")
    return WordTable("Capability", head, tuple(rows))


def capability_notes(fleet: Fleet) -> Iterator[str]:
    """Yield a reservation on Cpk, and the limits that have none, with the reason."""
    stepped = any(chart.step is not None and chart.step.real for chart in fleet.charts)
    if fleet.capabilities and stepped:
        yield "s contains the steps of the mean: Cpk is that of all campaigns, not of the last."
    for name, reason in fleet.without_capability:
        yield f"No Cpk for the limit of {name}: {reason}."


def wear_table(fleet: Fleet) -> WordTable:
    """Return the slope of each cylinder's friction over distance and work."""
    rows = [
        (
            trend.specimen,
            name_of(trend),
            _AMOUNTS[trend.over][0],
            str(len(trend.x)),
            f"{_slope(trend)} {slope_unit(trend)}",
            "< 0.0001" if trend.p_holm < 1e-4 else significant(trend.p_holm, 2),
            "significant" if trend.real else "not significant",
        )
        for trend in fleet.wear
    ]
    head = ("Cylinder", "Number", "Over", "Campaigns", "Slope", "p (Holm)", "Verdict")
    return WordTable("Wear", head, tuple(rows))


def source_words(source: VarianceSource) -> str:
    """Return the name of a source of variance."""
    return {
        "mounting": "mounting, in a cylinder",
        "campaign": "campaign, all else equal",
        "trials": "trials of a campaign",
        CYLINDER: "cylinder",
    }.get(source.name, source.name)


def slope_unit(trend: WearTrend) -> str:
    """Return the unit of a trend's slope."""
    return f"{trend.quantity.unit}/{_AMOUNTS[trend.over][1]}"


def chart_words(chart: ControlChart) -> str:
    """Return what the chart's values are."""
    return "deviation from its cylinder's mean, plus the mean" if chart.of_cylinders else "value"


def _named(names: tuple[str, ...], count: int) -> str:
    more = f" and {count - len(names)} more" if count > len(names) else ""
    return (", ".join(names) or "none") + more


def _slope(trend: WearTrend) -> str:
    factor = trend.quantity.scale / _AMOUNTS[trend.over][2]
    return signed(with_ends(factor * trend.slope, factor * trend.low, factor * trend.high))


def _tolerance_words(study: Precision) -> str:
    share = study.share_of_tolerance
    return "" if share is None else f"; the measurement takes {_share(share)} of the tolerance"


def _levels(source: VarianceSource) -> str:
    if source.name != "trials":
        return str(source.levels)
    return f"{source.levels} dof" if source.levels else NONE


def _anova(source: VarianceSource, scale: float) -> str:
    if source.anova < 0:
        return "negative"
    return significant(scale * math.sqrt(source.anova), 2)


def _root(variance: Estimate, scale: float) -> str:
    high = None if variance.high is None else math.sqrt(variance.high)
    root = Estimate(math.sqrt(variance.value), math.sqrt(variance.low), high)
    return _interval(root, scale)


def _interval(estimate: Estimate, scale: float) -> str:
    """Write an estimate with its interval, both to two digits of the estimate."""
    value, low = scale * estimate.value, scale * estimate.low
    if estimate.high is None:
        return f"{significant(value, 2)} (from {significant(low, 2)})"
    high = significant(scale * estimate.high, 2)
    return f"{significant(value, 2)} ({significant(low, 2)} to {high})"


def _percent(share: Estimate | None) -> str:
    return NONE if share is None else f"{_interval(share, 100.0)} %"


def _share(share: float | None) -> str:
    return NONE if share is None else f"{significant(100 * share, 2)} %"
