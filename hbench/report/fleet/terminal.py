"""A fleet for a terminal: its verdict, its campaigns, and what became of each number."""

from hbench.records import Fleet, WordTable
from hbench.report.fleet.charts import capability_notes, capability_table, wear_table
from hbench.report.fleet.overview import interval_facts, overview_table
from hbench.report.fleet.precision import components_table, limit_sentences, limits_table
from hbench.report.fleet.text import campaign_table, shared_intervals, worst_table
from hbench.report.fleet.verdict import fleet_verdict, further_sentences
from hbench.report.render.terminal_table import table_lines
from hbench.report.render.terminal_text import plain, wrapped
from hbench.sentences import plural

_SIGMA = "σ", "s.d."  # in a word that a terminal has
_FEW = 5  # outliers that are listed
_MOST_ROWS = 50  # campaigns that are listed


def fleet_text(fleet: Fleet) -> str:
    """Return the verdict, the main tables with their notes, and the findings.

    The page has the control charts and the tests.
    """
    failed = f", {fleet.failed} failed" if fleet.failed else ""
    lines = [f"{fleet.campaigns} campaigns: {fleet.campaigns - fleet.failed} analysed{failed}"]
    lines += wrapped(fleet_verdict(fleet))
    lines += [f"  {count} failed: {reason}" for reason, count in fleet.reasons]
    if len(fleet.protocols) > 1:
        are = plural(fleet.compared, "is", "are")
        lines.append(
            f"{fleet.compared} of the most frequent kind {are} evaluated: {fleet.protocols[0][0]}"
        )
    if fleet.other_speeds:
        lines.append(f"{fleet.other_speeds} of them at other speeds are left out")
    campaigns = [campaign_table(fleet)] if len(fleet.rows) <= _MOST_ROWS else []
    apart = [f"{name}: {words}" for name, words in interval_facts(fleet)]
    blocks: tuple[tuple[list[WordTable], list[str]], ...] = (
        (campaigns, [shared_intervals(fleet)] if campaigns else []),
        ([overview_table(fleet)], [*apart, *further_sentences(fleet)]),
        ([worst_table(fleet, min(fleet.outliers, _FEW))], []),
        (
            [limits_table(fleet), components_table(fleet)],
            [*fleet.plan_notes, *limit_sentences(fleet)],
        ),
        ([capability_table(fleet)], list(capability_notes(fleet))),
        ([wear_table(fleet)], []),
    )
    for tables, notes in blocks:
        for table in tables:
            if table.rows:
                lines += ["", *table_lines(_without_sigma(table))]
        lines += [line for note in notes for line in wrapped(note)]
    return plain("\n".join(lines).replace(*_SIGMA))


def _without_sigma(table: WordTable) -> WordTable:
    head, *rows = (
        tuple(cell.replace(*_SIGMA) for cell in row) for row in (table.head, *table.rows)
    )
    return WordTable(table.title, head, tuple(rows))
