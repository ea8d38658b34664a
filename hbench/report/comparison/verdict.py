"""Verdict of a comparison: the significant differences, and whether the data can be relied on."""

from collections.abc import Sequence

from hbench.records import CampaignDifferences, Drift, MeanOfCurves
from hbench.report.comparison.bands import band_verdict
from hbench.report.comparison.breakaways import breakaway_verdict
from hbench.report.comparison.cells import percent, signed
from hbench.report.comparison.difference_words import by_chance, sizes, widest, with_uncertainty
from hbench.report.comparison.tables import hidden_curves, is_beyond_drift, unseparated, who
from hbench.report.render.numbers import (
    half_width,
    number,
    percent_span,
    significant,
    whole_mm_s,
    with_interval,
)

_FEW = 2  # curves that the verdict lists
_MOUNTING = (
    "{interval} does not contain a new mounting: before acting on a difference, mount one of the "
    "two cylinders again and repeat its measurement."
)
_TRIALS = "trials alone"
_MAY_BE = ", which a drift within the campaigns may explain"
_REMEDY = "To compare single curves, measure both again with order: random in the schedule."


def alarm(differences: CampaignDifferences) -> str:
    """Return a sentence on each campaign that was not completed or whose data is poor."""
    sentences = []
    for name, quality in zip("AB", differences.qualities, strict=True):
        faults = (
            "is incomplete" if quality.completeness.not_completed else "",
            "has poor data" if quality.grade == "poor" else "",
        )
        if any(faults):
            sentences.append(f"{name} {' and '.join(filter(None, faults))}.")
    return " ".join((*sentences, "Do not rely on these differences.")) if sentences else ""


def headline(differences: CampaignDifferences) -> str:
    """Return the significant differences, and whose data is to be used with care."""
    careful = [
        name
        for name, quality in zip("AB", differences.qualities, strict=True)
        if quality.grade == "with care"
    ]
    care = f"Use the data of {' and '.join(careful)} with care." if careful else ""
    found = [band_verdict(differences)]
    if differences.curves and not found[0]:
        over = _over_curves(differences)
        sure = bool(over) and bool(unseparated(differences))
        efficiency = "" if sure else _efficiency_verdict(differences)
        found = [over or _verdict(differences), efficiency]
    over_curves = bool(_over_curves(differences)) and not band_verdict(differences)
    drift = "" if over_curves else drift_words(differences)
    differs = _over_curves(differences) or any(b.breakaway_n.real for b in differences.breakaways)
    mounting = _MOUNTING.format(interval=_interval(differences)) if differs else ""
    return " ".join(
        filter(
            None,
            (*found, breakaway_verdict(differences), drift, mounting, _warmer(differences), care),
        )
    )


def _over_curves(differences: CampaignDifferences) -> str:
    """State a significant mean difference over all curves; empty where not all have its sign."""
    mean = differences.mean_of_curves
    if mean is None or not mean.real:
        return ""
    means = [curve.mean_n for curve in differences.curves if curve.mean_n is not None]
    real = [each for each in means if each.real]
    if any((each.value > 0) != (mean.value_n > 0) for each in real):
        return ""
    a, b = differences.names
    way = "higher" if mean.value_n > 0 else "lower"
    size = with_interval(abs(mean.value_n), mean.half_n)
    size += f" N ({'U' if _has_u(mean) else _TRIALS})"
    share = f", or {significant(100 * abs(mean.value_n) / mean.a_n, 2)} %," if mean.a_n > 0 else ""
    words = (
        f"Friction of {b} is {size}{share} {way} than that of {a}, in the mean over all "
        f"{mean.curves} curves."
    )
    if unseparated(differences):
        linear = "This assumes that any drift within the campaigns was linear."
        return f"{words} {linear}{_by_speed(mean, drift=True)}"
    words += _by_speed(mean, drift=False)
    if not real:
        return f"{words} The difference of no single curve is significant."
    return f"{words} It is significant in {len(real)} of {len(means)} curves, by {sizes(real)} N."


def _by_speed(mean: MeanOfCurves, *, drift: bool) -> str:
    """State the differences at the ends of the speeds; empty where their intervals overlap."""
    if not mean.speeds:
        return ""
    ends = mean.speeds[0], mean.speeds[-1]
    halves = [each.ci95_n for each in ends if each.ci95_n is not None]
    if len(halves) < len(ends) or abs(ends[1].value_n - ends[0].value_n) <= sum(halves):
        return ""
    slow, fast = (
        f"{with_interval(each.value_n, each.ci95_n)} N at {whole_mm_s(each.v_m_s)} mm/s"
        for each in ends
    )
    if drift:
        return (
            f" The difference seems to depend on speed, from {slow} to {fast} ({_TRIALS}), which "
            "such a drift may cause."
        )
    return f" The difference depends on speed, from {slow} to {fast} ({_TRIALS})."


def _has_u(mean: MeanOfCurves) -> bool:
    """Return whether the half-width of a mean difference is its expanded uncertainty."""
    return mean.u95_a is not None and mean.u95_b is not None


def _interval(differences: CampaignDifferences) -> str:
    """Name the half-width of the differences."""
    mean = differences.mean_of_curves
    known = [each.breakaway_n.u95 is not None for each in differences.breakaways]
    known += [_has_u(mean)] if mean is not None else []
    return "U" if all(known) else "The interval"


def drift_words(differences: CampaignDifferences) -> str:
    """State the drift that the order of the runs does not separate; empty without one."""
    mixed = unseparated(differences)
    if not mixed:
        return ""
    effects = [each.drift_n for each in differences.curves if each.drift_n is not None]
    if not effects:
        return f"{_unknown_part(differences, mixed)} {_REMEDY}"
    largest = f"{half_width(max(each.largest_n for each in effects))} N"
    part = f"may account for up to {largest} of the difference of a curve"
    part += "" if any(drift.significant for drift in mixed) else " and is not part of U"
    if not any_significant(differences):
        return f"A drift may hide a difference: it {part}. {_REMEDY}"
    if _all_beyond_drift(differences):
        return f"A drift {part}; the differences are larger."
    mean = differences.mean_of_curves
    if mean is None or band_verdict(differences) or not _over_curves(differences):
        return (
            f"A drift {part}: the order of the runs does not separate the two. {_mean(differences)}"
            f"{_REMEDY}"
        )
    return (
        f"A linear drift, unlike a warm-up, {_in_mean(mean)}, but may account for up to {largest} "
        f"of the difference of a single curve. {_REMEDY}"
    )


def _mean(differences: CampaignDifferences) -> str:
    """State that the mean over all curves does not differ significantly; empty if not known."""
    mean = differences.mean_of_curves
    if mean is None or mean.real:
        return ""
    size = with_interval(mean.value_n, mean.half_n)
    return (
        f"The mean difference over all {mean.curves} curves, {size} N, is not significant; a "
        f"linear drift {_in_mean(mean)}. "
    )


def _in_mean(mean: MeanOfCurves) -> str:
    if mean.drift_cancels or mean.drift_n is None:
        return "cancels in this mean"
    return f"accounts for at most {half_width(mean.drift_n.largest_n)} N of this mean"


def _unknown_part(differences: CampaignDifferences, mixed: Sequence[Drift]) -> str:
    """State a drift whose part of the differences is not known."""
    if any_significant(differences):
        what = "These runs do not show whether this comes from the cylinders or from a drift"
    else:
        what = "A drift may hide a difference"
    if any(drift.significant for drift in mixed):
        why = "friction drifted, and the order of the runs mixes this with speed"
    else:
        most = number(max(drift.possible_percent for drift in mixed), 0)
        why = f"a drift of up to {most} % within a campaign is possible and is not part of U"
    undated = any(drift.of_unknown_size for drift in mixed)
    times = " The times of the runs are not known, so its size is uncertain." if undated else ""
    return f"{what}: {why}.{times}"


def _all_beyond_drift(differences: CampaignDifferences) -> bool:
    """Return whether each significant difference exceeds its uncertainty and its drift together."""
    return all(
        is_beyond_drift(curve)
        for curve in differences.curves
        if curve.mean_n is not None and curve.mean_n.real
    )


def any_significant(differences: CampaignDifferences) -> bool:
    """Return whether a mean, a half band or a slope differs significantly."""
    tested = [each for curve in differences.curves for each in (curve.mean_n, curve.efficiency)]
    return bool(band_verdict(differences)) or any(each is not None and each.real for each in tested)


def _warmer(differences: CampaignDifferences) -> str:
    """State how much warmer the oil was in one campaign; empty where their ranges overlap."""
    a, b = differences.oil_temperatures
    if (
        a is None
        or b is None
        or a.sensor != b.sensor
        or b.low_k <= a.high_k
        and a.low_k <= b.high_k
    ):
        return ""
    warmer = "A" if a.mean_k > b.mean_k else "B"
    return f"The oil was {number(abs(b.mean_k - a.mean_k))} K warmer in {warmer}."


def _verdict(differences: CampaignDifferences) -> str:
    means = [(each, each.mean_n) for each in differences.curves if each.mean_n is not None]
    real = [(curve, mean) for curve, mean in means if mean.real]
    if not real:
        every = len(differences.curves)
        where = f"any of {every} curves" if every > 1 else "the only curve"
        causes = dict.fromkeys(mean.untested for _, mean in means)
        text = (
            f"No difference of mean friction could be tested in {where} ({'; '.join(causes)})"
            if causes and all(causes)
            else f"No difference of mean friction is significant in {where}"
        )
        largest = max((mean for _, mean in means), key=lambda mean: abs(mean.value), default=None)
        if largest is None:
            return f"{text}."
        return (
            f"{text}; the largest is {with_uncertainty(largest)}{by_chance(largest, len(means))}."
        )
    hidden = {id(curve) for curve in hidden_curves(differences)}
    drift = _MAY_BE if all(id(curve) in hidden for curve, _ in real) else ""
    count = f"{len(real)} of {len(differences.curves)} curves{drift}"
    of_means = [mean for _, mean in real]
    values = [mean.value for mean in of_means]
    if len(real) > _FEW and (min(values) > 0 or max(values) < 0):
        way = "higher" if values[0] > 0 else "lower"
        shares = [100 * abs(mean.value / mean.a) for _, mean in real if mean.a]
        share = f", or {percent_span(shares)}" if shares else ""
        return (
            f"Mean friction of {differences.names[1]} is {way} than that of {differences.names[0]} "
            f"in {count}, by {sizes(of_means)} N{share} ({widest(of_means)})."
        )
    means_text = "; ".join(
        f"{who(curve)}: {signed(mean)} N ({percent(mean)})" for curve, mean in real
    )
    return f"Mean friction differs in {count}: {means_text}."


def _efficiency_verdict(differences: CampaignDifferences) -> str:
    """Return the significant differences of efficiency; empty without any."""
    known = [each.efficiency for each in differences.curves if each.efficiency is not None]
    real = [mean for mean in known if mean.real]
    if not real:
        return ""
    count = f"{len(real)} of {len(known)} curves"
    values = [100 * mean.value for mean in real]
    if min(values) < 0 < max(values):
        return f"Efficiency differs in {count}."
    way = "higher" if values[0] > 0 else "lower"
    halves = [100 * mean.u95 for mean in real if mean.u95]
    widest = f" (U up to {half_width(max(halves))})" if len(halves) == len(real) else ""
    return f"Efficiency is {way} in {count}, by {sizes(real, 100)} percentage points{widest}."
