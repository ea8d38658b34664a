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
from hbench.report.render.document import Section
from hbench.report.render.word_tables import titled

_REMARKS = "fit-remarks"
_PREDICTS = (
    "Each speed but the lowest and the highest is held out in turn and predicted from the others. "
    "In parentheses: RMS error of these predictions. The difference is that of their mean squares, "
    "with its standard error (s.e.); it is significant where its 95 % interval does not contain 0."
)
_FEW_RUNS = "These fits are those of an unfinished campaign. They change with the missing runs."


def fit_sections(results: Results) -> tuple[Section, ...]:
    """Return the fitted parameters of each law, and which law predicts best.

    Of an aborted campaign, both are folded in one section.
    """
    sections = []
    subsections: list[Section] = []
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
        if correlations.rows:
            text = f"{law_words(law)}: correlation of the parameters"
            untitled = replace(correlations, title="")
            part = Section(text, tables=(untitled,), folded=True, printed=False)
            subsections.append(part)
    if subsections:
        text = (
            "Each value has its 95 % interval by the scatter of the points: errors of the "
            "instruments and a drift over the campaign are not included. Do not use a parameter "
            "that is not determined: very different values fit the measured points as well. The "
            "interval of a hardly determined one contains 0 or is wider than ±50 % of the value. "
            "“Linearised” marks a parameter that is not determined by this interval, which is "
            "wider than the value."
        )
        if any(determines_none(fit) for curve in of_points.curves for fit in curve.fits):
            text += (
                " A row of dashes: the fit determines no parameter, for the reason in its remark."
            )
        if fit_remarks(results):
            text += f" The remarks on the fits are in the appendix, from [[{_REMARKS}]] on."
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
            title = f"{law_words(law)} ({len(table.rows)})"
            parts.append(Section(title, tables=(table,), folded=True))
    title = "Appendix: remarks on the fits"
    return (Section(title, parts=tuple(parts), anchor=_REMARKS),) if parts else ()
