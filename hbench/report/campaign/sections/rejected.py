"""Section of a campaign's page on the rejected runs, and the remarks on accepted ones."""

from hbench.records import Results
from hbench.report.campaign import page_tables
from hbench.report.campaign.reasons import reason_counts
from hbench.report.render.document import Section
from hbench.report.render.figures import Drawing
from hbench.report.render.word_tables import titled
from hbench.sentences import counted

LONG_LIST = 12  # a longer list of rejected runs or of notes starts folded

_TRACES = (
    "A figure for each reason shows the first rejected runs in the channel that it concerns: "
    "velocity with its reference, valve voltages, pressures, or else the position. A reason that "
    "concerns the file alone has none."
)


def has_rejected(results: Results) -> bool:
    """Return whether a run was rejected."""
    return not all(run.accepted for run in results.runs)


def rejected_sections(results: Results, drawings: tuple[Drawing, ...]) -> tuple[Section, ...]:
    """Return the rejected runs with ``drawings`` of some, and remarks on accepted runs, if any."""
    sections = []
    if has_rejected(results):
        table = page_tables.rejected_table(results)
        title = f"Rejected runs and why ({len(table.rows)})"
        causes = titled(page_tables.cause_table(results), "Reasons, and what to look for")
        parts = (
            Section(tables=causes),
            Section(title, tables=(table,), folded=len(table.rows) > LONG_LIST),
            Section(paragraphs=(_TRACES,) if drawings else (), drawings=drawings),
        )
        words = tuple(filter(None, (_cause_words(results),)))
        sections.append(Section("Rejected runs", words, parts=parts, anchor="rejected"))
    remarks = page_tables.remark_table(results)
    if remarks.rows:
        runs = sum(run.accepted and bool(run.notes) for run in results.runs)
        title = f"Remarks on accepted runs ({runs})"
        folded = len(remarks.rows) > LONG_LIST or None
        sections.append(Section(title, tables=(remarks,), folded=folded, anchor="run-remarks"))
    return tuple(sections)


def _cause_words(results: Results) -> str:
    """Return how many reasons the rejected runs have, where it is more than one each."""
    runs = sum(not run.accepted for run in results.runs)
    reasons = sum(reason_counts(results).values())
    if reasons == runs:
        return ""
    return (
        f"The {reasons} reasons belong to {counted(runs, 'run')}: a run counts under each of its "
        "reasons. results.json contains each in full."
    )
