"""The section of a page on the drift of friction over a campaign."""

from collections.abc import Iterator

from hbench.records import Drift
from hbench.report.drift import drift_advice, drift_table, drift_with_oil, drift_words
from hbench.report.render.document import Section

_MIXED = "not separated from speed"  # so no test of it alone


def drift_sections(drift: Drift | None) -> Iterator[Section]:
    """Yield the folded section on the drift; nothing where it was not estimated."""
    if drift is not None:
        said = f"Steady friction changed by {drift_words(drift)}."
        paragraphs = tuple(filter(None, (said, drift_with_oil(drift), drift_advice(drift))))
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
