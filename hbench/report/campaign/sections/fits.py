"""Sections of a campaign's page on the fitted friction laws, and the remarks on the fits."""

from dataclasses import replace

from hbench.records import KINDS, Results
from hbench.report.campaign.fit_tables import (
    correlation_table,
    determines_none,
    fit_tables,
    law_words,
    remark_table,
    selection_table,
    selection_words,
)
from hbench.report.campaign.reasons import aborted_words
from hbench.report.fit_intervals import fit_interval_words
from hbench.report.render.document import Section
from hbench.report.render.word_tables import Table, titled

_REMARKS = "fit-remarks"
_PREDICTS = (
    "In parentheses: RMS error at held-out speeds. The difference is that of their mean squares, "
    "with its standard error (s.e.)."
)
_FEW_RUNS = "These fits are those of an unfinished campaign. They change with the missing runs."


def fit_sections(results: Results) -> tuple[Section, ...]:
    """Return the fitted parameters of each law, and which law predicts best.

    Of an aborted campaign, both are folded in one section.
    """
    sections = []
    subsections: list[Section] = []
    correlated: list[Table] = []
    moving = [curve for curve in results.curves if not KINDS[curve.kind].has_constant_speed]
    of_points = _of_points(results)
    of_motions = replace(results, curves=tuple(moving), joint_fits=())
    of_steady, of_moving = fit_tables(of_points), fit_tables(of_motions)
    for law in dict.fromkeys((*of_steady, *of_moving)):
        if law in of_steady:
            subsections.append(Section(tables=(of_steady[law],)))
        if law in of_moving:
            table = of_moving[law]
            text = f"{law_words(law)}: fits of moving runs ({len(table.rows)})"
            remarks = remark_table(of_motions, law)
            tables = (table, *([remarks] if remarks.rows else []))
            subsections.append(Section(text, tables=tables, folded=True, printed=False))
        correlations = correlation_table(results, law)
        correlated += titled(correlations, law_words(law))
    if correlated:
        text = "Correlations of the parameters"
        part = Section(text, tables=tuple(correlated), folded=True, printed=False)
        subsections.append(part)
    if subsections:
        text = (
            f"{fit_interval_words(results)} Do not use a parameter that is not determined: very "
            "different values fit the measured points as well."
        )
        if any(determines_none(fit) for curve in of_points.curves for fit in curve.fits):
            text += (
                " A row of dashes: the fit determines no parameter, for the reason in its remark."
            )
        if fit_remarks(results):
            text += f" [[{_REMARKS}]] and those after it have remarks on the fits."
        sections.append(
            Section("Fitted parameters", (text,), parts=tuple(subsections), anchor="fits")
        )
    selection = selection_table(results)
    if selection.rows:
        sections.append(
            Section(
                "Which law predicts best",
                (selection_words(results), _PREDICTS),
                tables=titled(selection, "Errors of the two best laws at held-out speeds"),
                anchor="laws",
            )
        )
    if not sections or not aborted_words(results):
        return tuple(sections)
    parts = tuple(replace(section, folded=True) for section in sections)
    return (Section("Fitted laws", (_FEW_RUNS,), parts=parts, anchor="fitted-laws"),)


def _of_points(results: Results) -> Results:
    """Return the results with the steady curves alone."""
    steady = (curve for curve in results.curves if KINDS[curve.kind].has_constant_speed)
    return replace(results, curves=tuple(steady))


def fit_remarks(results: Results) -> tuple[Section, ...]:
    """Return the remarks on the fits of steady runs, a table for each law."""
    of_points = _of_points(results)
    parts = []
    for law in fit_tables(of_points):
        table = remark_table(of_points, law)
        if table.rows:
            parts.append(table)
    title = "Appendix: remarks on the fits"
    return (Section(title, tables=tuple(parts), anchor=_REMARKS, folded=True),) if parts else ()
