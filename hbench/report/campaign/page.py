"""Content of the report of a campaign, for the page, Markdown and PDF."""

from collections.abc import Iterable
from dataclasses import replace

from hbench.records import KINDS, Results
from hbench.report.campaign import page_motions, page_tables
from hbench.report.campaign.figures.rejected import has_rejected
from hbench.report.campaign.fit_tables import (
    correlation_table,
    determines_none,
    fit_tables,
    law_words,
    remark_table,
    selection_table,
)
from hbench.report.campaign.method import method_section
from hbench.report.campaign.motion_rows import differs
from hbench.report.campaign.quality import decision_reserve, quality_verdict
from hbench.report.campaign.series_words import common_label, without_common_label
from hbench.report.campaign.settings import aborted_words, identity_facts, settings_section
from hbench.report.campaign.summary import (
    decided_step_words,
    next_step_words,
    summary_section,
)
from hbench.report.drift import drift_reserve
from hbench.report.headline import headline_words
from hbench.report.oil_temperature import temperature_section
from hbench.report.render.document import BANNERS, Document, Section
from hbench.report.render.figures import Drawing
from hbench.report.render.numbers import number, span
from hbench.report.render.word_tables import Table

LONG_LIST = 12  # a longer list of rejected runs or of notes starts folded
_SHEET = 50  # a longer table of points is not printed

_REMARKS = "fit-remarks"
_PREDICTS = (
    "Each speed but the lowest and the highest is held out in turn and predicted from the others. "
    "In parentheses: RMS error of these predictions. The difference is that of their mean squares, "
    "with its standard error (s.e.). Where one speed alone has a large error, it is not "
    "significant, although one RMS error is several times the other."
)
_FEW_RUNS = "These fits are those of an unfinished campaign. They change with the missing runs."
_RAMPS = "Does the acceleration matter, and do ramps differ from steady runs?"
_BREAKAWAY = (
    "The largest friction while a rising force pushes the piston, which has rested under load. "
    "It is a property of the seals, of the rest and of the rate. The piston creeps while the force "
    "rises: the table gives its displacement up to the largest friction."
)
_DISTANCE = (
    "Changes along straight lines with their 95 % intervals: over all values (endurance), and over "
    "the last half of them (run-in). Settled: the interval of the last change lies within 5 % of "
    "the mean. Changing: it is wider and does not contain 0."
)
_ZEROS = (
    "The zeros of the sensors were checked with the supply off and the chambers vented. Their "
    "errors were subtracted, in between as a straight line over time; the error of the reference "
    "pressure and the drift of each zero are limits of errors in u."
)
_NO_ZEROS = (
    "The campaign has no zero checks of the sensors (experiments of kind check): u contains zero "
    "errors only as far as the stated tolerances do."
)
_NOT_PRINTED = (
    "curves.csv and efficiency.csv, beside this page, contain every point. A table of more than "
    f"{_SHEET} points is on the page and not on paper."
)
_TRACES = (
    "A figure for each reason shows the first rejected runs in the channel that it concerns: "
    "velocity with its reference, valve voltages, pressures, or else the position. A reason that "
    "concerns the file alone has none."
)
_TESTED = (
    "Difference of friction over a range of speeds ± half-width of its 95 % interval "
    "over the trials. p is corrected after Holm for the number of tests."
)


def report_document(
    results: Results,
    drawings: Iterable[Drawing],
    more: tuple[Section, ...] = (),
    folder: str = "",
    decision: Section | None = None,
    step: str = "",
) -> Document:
    """Return the report, with the sections ``more`` before the rejected runs.

    ``folder`` is the name of the campaign's folder, which distinguishes campaigns of one schedule.
    ``decision`` is the section of an acceptance and comes first; its paragraphs begin the verdict
    and are not repeated. ``step`` is the next step after it; the summary then has the verdict on
    the data.
    """
    label, results = common_label(results), without_common_label(results)
    figures: dict[str, tuple[Drawing, ...]] = {}
    for drawing in drawings:
        figures[drawing.section] = (*figures.get(drawing.section, ()), drawing)
    provenance = results.provenance
    bench = provenance.bench if provenance.bench != provenance.name else ""
    folder = folder if folder != provenance.name else ""
    imported = "imported " if provenance.source == "imported" else ""
    day = imported + provenance.started[:10]
    subtitle = (folder, "Friction and efficiency of a cylinder", bench, day)
    sections = (
        *((replace(decision, paragraphs=()),) if decision else ()),
        summary_section(results, decision is not None),
        _friction(results, figures.get("friction", ())),
        *_fits(results),
        *temperature_section(results, figures.get("temperature", ())),
        *_moving(results, figures),
        *_budget(results),
        *_efficiency(results, figures.get("efficiency", ())),
        *more,
        _rejected(results, figures.get("rejected", ())),
        *_points(results),
        *_fit_remarks(results),
        settings_section(results, LONG_LIST),
        method_section(results),
    )
    alarm = aborted_words(results)
    return Document(
        provenance.name,
        " · ".join(filter(None, subtitle)),
        sections,
        _verdict(results, decision, step),
        BANNERS[provenance.source],
        provenance.source,
        folder,
        identity_facts(results, label),
        alarm,
    )


def _verdict(results: Results, decision: Section | None, step: str) -> str:
    """Return the decision with what it rests on, or else the first quantity; and the next step."""
    if decision:
        rests = decision_reserve(results.quality)
        parts = (*decision.paragraphs, rests, decided_step_words(results, step))
    else:
        parts = (
            headline_words(results),
            quality_verdict(results.quality, not aborted_words(results)),
            drift_reserve(results.drift),
            next_step_words(results),
        )
    return " ".join(filter(None, parts))


def _friction(results: Results, drawings: tuple[Drawing, ...]) -> Section:
    if not any(KINDS[curve.kind].has_constant_speed for curve in results.curves):
        others = any(run.accepted for run in results.runs)
        none = (
            "No steady run was accepted. Results of the other runs follow below."
            if others
            else "No run was accepted, so there is no friction to show."
        )
        return Section("Friction", (none,))
    few = "Too few speeds for a curve. [[points]] contains the points."
    tables = (
        *_titled(
            page_tables.band_table(results),
            "Friction against pressure, with the intervals of the trials",
        ),
        *_titled(page_tables.trend_table(results), "Lines over pressure"),
        *_titled(
            page_tables.balance_table(results), "Coulomb and viscous friction from both directions"
        ),
    )
    return Section("Friction", () if drawings else (few,), drawings=drawings, tables=tables)


def _of_points(results: Results) -> Results:
    """Return the results with the steady curves alone."""
    steady = (curve for curve in results.curves if KINDS[curve.kind].has_constant_speed)
    return replace(results, curves=tuple(steady))


def _fit_remarks(results: Results) -> tuple[Section, ...]:
    """Return the remarks on the fits of steady runs, a table for each law."""
    of_points = _of_points(results)
    parts = []
    for law in fit_tables(of_points):
        table = remark_table(of_points, law)
        if table.rows:
            title = f"{law_words(law)} ({len(table.rows)})"
            parts.append(Section(title, tables=(table,), folded=True))
    return (Section("Remarks on the fits", parts=tuple(parts), anchor=_REMARKS),) if parts else ()


def _fits(results: Results) -> tuple[Section, ...]:
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
            "Each value has its 95 % interval. Do not use a parameter that is not determined: very "
            "different values fit the measured points as well."
        )
        if any(determines_none(fit) for curve in of_points.curves for fit in curve.fits):
            text += (
                " A row of dashes: the fit determines no parameter, for the reason in its remark."
            )
        if _fit_remarks(results):
            text += f" Remarks on the fits are at the end, from [[{_REMARKS}]] on."
        sections.append(
            Section("Fitted parameters", (text,), parts=tuple(subsections), anchor="fits")
        )
    selection = selection_table(results)
    if selection.rows:
        sections.append(
            Section(
                "Which law predicts best",
                (_PREDICTS,),
                tables=_titled(selection, "Errors of the two best laws at held-out speeds"),
                anchor="laws",
            )
        )
    if not sections or not aborted_words(results):
        return tuple(sections)
    parts = tuple(replace(section, folded=True) for section in sections)
    return (Section("Fitted laws", (_FEW_RUNS,), parts=parts, anchor="fitted-laws"),)


def _moving(results: Results, figures: dict[str, tuple[Drawing, ...]]) -> Iterable[Section]:
    if drawings := figures.get("ramps"):
        table = page_motions.comparison_table(results)
        differing = sum(map(differs, results.motions.comparisons))
        verb = "is" if differing == 1 else "are"
        said = f"{differing} of {len(table.rows)} differences {verb} significant."
        subsections = (
            (
                Section(
                    f"{_RAMPS} {said}",
                    (_TESTED,),
                    tables=_titled(table, "Differences between ramps, and from steady runs"),
                    folded=True,
                ),
            )
            if table.rows
            else ()
        )
        yield Section("Ramps", drawings=drawings, parts=subsections)
    if drawings := figures.get("breakaway"):
        yield Section(
            "Breakaway",
            (_BREAKAWAY,),
            drawings=drawings,
            tables=(
                *_titled(page_motions.breakaway_table(results), "Measured breakaway force"),
                *_titled(page_motions.dwell_table(results), "Laws over the time at rest"),
            ),
        )
    holds = _titled(page_motions.hold_table(results), "Each hold")
    for name, table, more, words in (
        ("hysteresis", page_motions.loop_table(results), (), "Width and energy of the loops"),
        ("steps", page_motions.level_table(results), (), "Friction after each step"),
        ("leakage", page_motions.leak_table(results), holds, "Leakage at the highest pressure"),
    ):
        if drawings := figures.get(name):
            parts = (Section(items=table.messages),) if table.messages else ()
            title, tables = name.capitalize(), (replace(table, title=words), *more)
            if name in _FOLDED:
                inside = Section(
                    "Details", drawings=drawings, tables=tables, parts=parts, folded=True
                )
                yield Section(title, (_FOLDED[name](results),), parts=(inside,))
            else:
                yield Section(title, drawings=drawings, tables=tables, parts=parts)
    if drawings := figures.get("over-distance"):
        table = page_motions.distance_table(results)
        tables = _titled(table, "Changes over the distance")
        yield Section("Over the distance", (_DISTANCE,), drawings=drawings, tables=tables)


def _loop_words(results: Results) -> str:
    loops = results.motions.loops
    energy = span([loop.area_j for loop in loops])
    return f"{_count(len(loops), 'triangle')} with {energy} J of friction work a cycle."


def _step_words(results: Results) -> str:
    levels = results.motions.levels
    speeds = span([1e3 * abs(level.v_to_m_s) for level in levels])
    known = [level.settling_s for level in levels if level.settling_s is not None]
    slowest = (
        f" The longest settling time of friction is {number(max(known), 2)} s." if known else ""
    )
    return f"{_count(len(levels), 'level')} of {speeds} mm/s.{slowest}"


_FOLDED = {"hysteresis": _loop_words, "steps": _step_words}  # by the section's name


def _count(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def _budget(results: Results) -> tuple[Section, ...]:
    table = page_tables.friction_budget_table(results)
    zeros = page_motions.zero_table(results)
    if not table.rows and not zeros.rows:
        return ()
    text = (
        "Friction at the working speed with the standard uncertainty of each input (JCGM 100). "
        "u is the combined standard uncertainty, ν its effective degrees of freedom, and k the "
        "coverage factor: U = k u.",
        _ZEROS if zeros.rows else _NO_ZEROS,
    )
    tables = (
        *_titled(table, "Friction at the working speed and the parts of its uncertainty"),
        *_titled(zeros, "Zero errors, corrected"),
    )
    return (Section("Uncertainty of friction", text, tables=tables, anchor="uncertainty"),)


def _efficiency(results: Results, drawings: tuple[Drawing, ...]) -> tuple[Section, ...]:
    if not drawings:
        return ()
    budget = page_tables.budget_table(results)
    title = "Mean over the speeds, and the parts of its standard uncertainty u"
    return (Section("Efficiency", drawings=drawings, tables=_titled(budget, title)),)


def _rejected(results: Results, drawings: tuple[Drawing, ...]) -> Section:
    subsections = []
    if has_rejected(results):
        table = page_tables.rejected_table(results)
        title = f"Rejected runs and why ({len(table.rows)})"
        causes = _titled(page_tables.cause_table(results), "Reasons, and what to look for")
        subsections.append(Section(tables=causes))
        subsections.append(Section(title, tables=(table,), folded=len(table.rows) > LONG_LIST))
        traces = (_TRACES,) if drawings[1:] else ()
        subsections.append(Section(paragraphs=traces, drawings=drawings))
    remarks = page_tables.remark_table(results)
    if remarks.rows:
        title = f"Remarks on accepted runs ({len(remarks.rows)})"
        subsections.append(Section(title, tables=(remarks,), folded=True))
    none = () if has_rejected(results) else ("None.",)
    return Section("Rejected runs", none, parts=tuple(subsections), anchor="rejected")


def _points(results: Results) -> tuple[Section, ...]:
    subsections = [
        Section(
            f"Points of the {name} curves ({len(table.rows)})",
            tables=_titled(table, f"{name.capitalize()} at each speed, direction and load"),
            folded=True,
            printed=len(table.rows) <= _SHEET,
        )
        for name, table in (
            ("friction", page_tables.point_table(results)),
            ("efficiency", page_tables.efficiency_table(results)),
        )
        if table.rows
    ]
    if not subsections:
        return ()
    note = () if all(part.printed for part in subsections) else (_NOT_PRINTED,)
    return (Section("All points", note, parts=tuple(subsections), anchor="points"),)


def _titled(table: Table, title: str) -> tuple[Table, ...]:
    return (replace(table, title=title),) if table.rows else ()
