"""The section of a page on the drift of friction over a campaign."""

from collections.abc import Iterator
from datetime import datetime

from hbench.records import Results
from hbench.report.drift import drift_advice, drift_table, drift_with_oil, drift_words
from hbench.report.render.document import Section
from hbench.report.render.numbers import significant

_NEARLY_ALL = 0.8  # of the campaign's time
_MIXED = "not separated from speed"  # so no test of it alone


def drift_sections(results: Results) -> Iterator[Section]:
    """Yield the folded section on the drift; nothing where it was not estimated."""
    drift = results.drift
    if drift is not None:
        change = f"Steady friction changed by {drift_words(drift)}."
        about = drift_coverage(results), drift_with_oil(drift), drift_advice(drift)
        paragraphs = tuple(filter(None, (change, *about)))
        how = "significant" if drift.significant else "not significant"
        if not drift.separated:
            how = "significant, not separated from speed" if drift.significant else _MIXED
        yield Section(
            f"Drift over the campaign: {how}",
            paragraphs,
            tables=(drift_table(drift),),
            anchor="drift",
            folded=not drift.significant,
        )


def drift_coverage(results: Results) -> str:
    """State how much of the campaign's time the steady runs span; empty if nearly all."""
    drift, provenance = results.drift, results.provenance
    if drift is None or drift.span_s is None or provenance.source == "imported":
        return ""
    try:
        ends = [datetime.fromisoformat(each) for each in (provenance.started, provenance.stopped)]
    except ValueError:
        return ""
    total_s = (ends[1] - ends[0]).total_seconds()
    if drift.span_s > _NEARLY_ALL * total_s:
        return ""
    span, total = (significant(seconds / 60, 2) for seconds in (drift.span_s, total_s))
    return (
        f"These runs span {span} min of the campaign's {total} min: a drift in the rest of it is "
        "not tested."
    )
