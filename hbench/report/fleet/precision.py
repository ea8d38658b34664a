"""Repeatability and reproducibility of a fleet, in words and tables."""

import math
from collections.abc import Iterator

from hbench.records import (
    CYLINDER,
    Estimate,
    Fleet,
    Precision,
    VarianceSource,
    WordTable,
)
from hbench.report.fleet.names import (
    name_of,
    of_side,
    without_condition,
)
from hbench.report.render.numbers import NONE, number, significant
from hbench.report.render.word_tables import with_columns


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


def main_studies(fleet: Fleet) -> list[Precision]:
    """Return the studies of friction: of the band, or else of each direction."""
    names = ("half_band_n", "friction_n")
    for name in names:
        studies = [study for study in fleet.precision if study.quantity.name == name]
        if studies:
            return studies
    return []


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
        "Quantity",
        "Repeatability s_r (95 %)",
        "Reproducibility s_R (95 %)",
        "Limit r",
        "Limit R",
        "Limit for two campaigns",
        "%GRR of all",
        "%GRR of tolerance",
        "ndc",
    )
    kept = [i for i in range(len(head)) if i < 6 or any(row[i] != NONE for row in rows)]
    return with_columns(WordTable("Repeatability and reproducibility", head, tuple(rows)), kept)


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
    head = ("Quantity", "Source", "Levels", "σ (95 %)", "Share of variance", "σ by ANOVA")
    return WordTable("Variance components", head, tuple(rows))


def source_words(source: VarianceSource) -> str:
    """Return the name of a source of variance."""
    return {
        "mounting": "mounting, in a cylinder",
        "campaign": "campaign, all else equal",
        "trials": "trials of a campaign",
        CYLINDER: "cylinder",
    }.get(source.name, source.name)


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
