"""First sheet of a workbook: origin, verdict and results, and what the other sheets contain."""

from collections.abc import Iterable

from hbench.records import Results
from hbench.report.campaign.quality.verdict import quality_verdict
from hbench.report.campaign.reasons import aborted_words
from hbench.report.campaign.sections.settings import identity_facts
from hbench.report.campaign.sections.summary import summary_section
from hbench.report.headline import headline_words, possible_drift_words
from hbench.report.render.document import BANNERS
from hbench.report.render.word_tables import Cell

_CONTENTS = {
    "runs": "each run: its settings, whether it was accepted or why not, and its means",
    "curves": "each operating point: friction as the mean of the accepted trials",
    "curves_reduced": "the same at the reference temperature of the oil",
    "fits": "parameters of the fitted friction laws",
    "covariances": "covariances of these parameters",
    "budget": "parts of the standard uncertainty of friction at each operating point",
    "efficiency": "efficiency at each operating point; 1 is 100 %",
    "bands": "half of the friction band between both directions, and its middle",
    "band_trends": "lines through the bands over pressure",
    "comparisons": "differences of friction between ramps, and from steady runs",
    "loops": "hysteresis: energy and width of the loops",
    "loop_traces": "friction over position and velocity in these loops",
    "levels": "friction after each step of the speed",
    "leakage": "leakage coefficients, from pressures that decay with all valves closed",
    "decays": "flows out of both chambers in each of these runs",
    "decay_traces": "oil that has left both chambers over time",
    "breakaways": "largest friction while a force rises on the resting piston",
    "dwell_laws": "breakaway over the time at rest",
    "zeros": "zero errors of the sensors, in SI, with their limits",
    "surface": "friction over speed and pressures",
    "over_distance": "changes of friction over the distance travelled; slopes per metre",
}
_NAMES = (
    "A name ends in its unit: friction_n is in N. ci95: half-width of the 95 % interval of the "
    "trials. u95: expanded uncertainty with the instruments, 95 %. sigma, se: standard uncertainty."
)


def about_rows(results: Results, names: Iterable[str]) -> list[tuple[str, ...]]:
    """Return the first sheet of a workbook: origin, verdict, results, and each sheet of ``names``.

    Results are written as on the page, with their expanded uncertainty U.
    """
    summary = summary_section(results)
    tables = summary.tables or (summary.parts[0].tables if results.headline.series else ())
    verdict = (
        aborted_words(results),
        headline_words(results),
        quality_verdict(results.quality, stated=bool(possible_drift_words(results))),
    )
    about = (
        ("Campaign", results.provenance.name),
        ("Source", BANNERS[results.provenance.source]),
        ("Verdict", " ".join(filter(None, verdict))),
        *identity_facts(results),
    )
    rows: list[tuple[str, ...]] = [*about]
    for table in tables:
        rows += [(), (table.title,), table.head, *map(_texts, table.rows)]
    rows += [(), ("Sheet", "Contents"), *((name, _CONTENTS[name]) for name in names)]
    return [*rows, (), ("Columns", _NAMES)]


def _texts(row: Iterable[str | Cell]) -> tuple[str, ...]:
    return tuple(f"{c.text} {c.flag}".strip() if isinstance(c, Cell) else c for c in row)
