"""Content of the report of a campaign, for the page, Markdown and PDF."""

from collections.abc import Iterable
from dataclasses import replace
from functools import partial

from hbench.records import DIRECTIONS, KINDS, Results
from hbench.report.campaign import page_motions, page_tables
from hbench.report.campaign.quality.verdict import decision_reserve, quality_verdict
from hbench.report.campaign.reasons import aborted_words
from hbench.report.campaign.sections.fits import fit_remarks, fit_sections
from hbench.report.campaign.sections.method import method_section
from hbench.report.campaign.sections.motions import motion_sections
from hbench.report.campaign.sections.oil_temperature import temperature_section
from hbench.report.campaign.sections.rejected import has_rejected, rejected_sections
from hbench.report.campaign.sections.settings import (
    identity_facts,
    not_calibrated_words,
    settings_section,
)
from hbench.report.campaign.sections.summary import summary_section
from hbench.report.campaign.series_words import common_label, without_common_label
from hbench.report.creep_words import creep_facts
from hbench.report.drift import drift_reserve
from hbench.report.headline import headline_words, possible_drift_words
from hbench.report.next_step import decided_step_words, next_step_words
from hbench.report.render.document import BANNERS, Document, Section
from hbench.report.render.figures import Drawing, of_section
from hbench.report.render.word_tables import titled
from hbench.report.zero_words import zero_notes

_SHEET = 50  # a longer table of points is not printed
_HALF_BAND = (
    "Half band, middle",
    "Mean of both directions' magnitudes, and half of their difference.",
)
_ZEROS = (
    "The zeros of the sensors in the table were checked with the supply off and the chambers "
    "vented. Their errors were subtracted, in between as a straight line over time; the error of "
    "the reference pressure and the drift of each zero are limits of errors in u."
)
_NOT_PRINTED = (
    "curves.csv and efficiency.csv, beside this page, contain every point. A table of more than "
    f"{_SHEET} points is on the page and not on paper."
)


def report_document(
    results: Results,
    drawings: Iterable[Drawing],
    more: tuple[Section, ...] = (),
    folder: str = "",
    decision: Section | None = None,
    step: str = "",
    complete_u: str = "U",
) -> Document:
    """Return the report, with the sections ``more`` before the rejected runs.

    The rejected runs of poor data come before the summary. ``folder`` is the name of the campaign's
    folder, which distinguishes campaigns of one schedule. ``decision`` is the section of an
    acceptance and comes first; its paragraphs begin the verdict and are not repeated. ``step`` is
    the next step after it; the summary then has the verdict on the data. ``complete_u`` names the
    U of the decision that contain the instruments.
    """
    label, results = common_label(results), without_common_label(results)
    drawn = partial(of_section, tuple(drawings))
    provenance = results.provenance
    bench = provenance.bench if provenance.bench != provenance.name else ""
    folder = folder if folder != provenance.name else ""
    imported = "imported " if provenance.source == "imported" else ""
    day = imported + provenance.started[:10].replace("-", "\N{NON-BREAKING HYPHEN}")
    subject = "Leakage" if _is_of_leakage(results) else "Friction and efficiency"
    subtitle = (folder, f"{subject} of a cylinder", bench, day)
    rejected = rejected_sections(results, drawn("rejected"))
    first = results.quality.grade == "poor" and has_rejected(results)
    curves, others = _leading(drawn("friction"), first or decision is not None)
    sections = (
        *((_decided(results, decision),) if decision else ()),
        *(rejected if first else ()),
        summary_section(results, decision is not None, curves),
        *_friction(results, others, bool(curves)),
        *fit_sections(results),
        *temperature_section(results, drawn("temperature")),
        *motion_sections(results, drawn, decision is not None),
        *_budget(results),
        *_efficiency(results, drawn("efficiency")),
        *more,
        *(() if first else rejected),
        settings_section(results),
        method_section(results),
        *_points(results),
        *fit_remarks(results),
    )
    alarm = aborted_words(results)
    return Document(
        provenance.name,
        " · ".join(filter(None, subtitle)),
        sections,
        _verdict(results, decision, step, complete_u),
        BANNERS[provenance.source],
        provenance.source,
        folder,
        identity_facts(results, label),
        alarm,
    )


def _verdict(results: Results, decision: Section | None, step: str, complete_u: str) -> str:
    """Return the decision with what it rests on, or else the first quantity; and the next step."""
    if decision:
        care = decision_reserve(results.quality, complete_u), not_calibrated_words(results)
        parts = (*decision.paragraphs, *care, decided_step_words(results, step))
    else:
        drift = possible_drift_words(results)
        parts = (
            headline_words(results),
            quality_verdict(results.quality, not aborted_words(results), bool(drift)),
            "" if drift else drift_reserve(results.drift),
            next_step_words(results),
        )
    return " ".join(filter(None, parts))


def _leading(
    drawings: tuple[Drawing, ...], other_first: bool
) -> tuple[tuple[Drawing, ...], tuple[Drawing, ...]]:
    """Return the curves of friction that the summary shows, and the other figures of friction.

    It shows those of a single label, unless a decision or rejected runs come ``other_first``.
    """
    curves = tuple(each for each in drawings if each.name.startswith("stribeck"))
    if other_first or len(curves) > len(DIRECTIONS):
        return (), drawings
    return curves, tuple(each for each in drawings if each not in curves)


def _friction(results: Results, drawings: tuple[Drawing, ...], led: bool) -> Iterable[Section]:
    """Yield the section of friction.

    Nothing where the summary has ``led`` with all of it, or where other sections have all results.
    """
    if _is_of_leakage(results):
        return
    if not any(KINDS[curve.kind].has_constant_speed for curve in results.curves):
        others = any(run.accepted for run in results.runs)
        steady = any(KINDS[run.run.plan.kind].has_constant_speed for run in results.runs)
        follow = results.curves or any(vars(results.motions).values())
        if others and follow and not steady:
            return  # sections of their own contain all that was measured
        where = (
            "Results of the other runs follow below."
            if follow
            else "The notes of the analysis, under Instruments and settings, state what the other "
            "runs need."
        )
        none = (
            f"No steady run was {'accepted' if steady else 'made'}. {where}"
            if others
            else "No run was accepted, so there is no friction to show."
        )
        yield Section("Friction", (none,))
        return
    few = "Too few speeds for a curve. [[points]] contains the points."
    tables = (
        *titled(
            page_tables.band_table(results),
            "Friction against pressure, with the intervals of the trials",
        ),
        *titled(page_tables.trend_table(results), "Lines over pressure"),
        *titled(
            page_tables.balance_table(results), "Coulomb and viscous friction from both directions"
        ),
    )
    facts = (_HALF_BAND,) if results.bands else ()
    if tables or drawings or not led:
        text = () if drawings or led else (few,)
        yield Section("Friction", text, drawings=drawings, tables=tables, facts=facts)


def _is_of_leakage(results: Results) -> bool:
    """Return whether all runs are holds, which have leakage and no friction."""
    kinds = {KINDS[run.run.plan.kind].analysis for run in results.runs}
    return kinds == {"leakage"} and bool(results.motions.leakages)


def _decided(results: Results, decision: Section) -> Section:
    """Return the decision without its paragraphs, which begin the verdict.

    It explains a breakaway below the friction of a slow run, which a reader would doubt.
    """
    return replace(decision, paragraphs=(), facts=(*decision.facts, *creep_facts(results)))


def _budget(results: Results) -> tuple[Section, ...]:
    table = page_tables.friction_budget_table(results)
    zeros = page_motions.zero_table(results)
    if not table.rows and not zeros.rows:
        return ()
    if not table.rows:
        shown = titled(zeros, "Zero errors, corrected")
        return (Section("Zeros of the sensors", (_ZEROS, *zero_notes(results)), tables=shown),)
    text = (
        "Friction at the working speed with the standard uncertainty of each input (JCGM 100). "
        "u is the combined standard uncertainty, ν its effective degrees of freedom, and k the "
        "coverage factor: U = k u. Parts below 1 % of u are not listed.",
        *([_ZEROS] if zeros.rows else []),
        *zero_notes(results),
    )
    tables = (
        *titled(table, "Friction at the working speed and the parts of its uncertainty"),
        *titled(zeros, "Zero errors, corrected"),
    )
    return (Section("Uncertainty of friction", text, tables=tables, anchor="uncertainty"),)


def _efficiency(results: Results, drawings: tuple[Drawing, ...]) -> tuple[Section, ...]:
    if not drawings:
        return ()
    budget = page_tables.budget_table(results)
    title = "Mean over the speeds, and the parts of its standard uncertainty u"
    return (Section("Efficiency", drawings=drawings, tables=titled(budget, title)),)


def _points(results: Results) -> tuple[Section, ...]:
    parts = [
        Section(
            items=table.messages,
            tables=titled(table, f"{name} at each speed, direction and load"),
            printed=len(table.rows) <= _SHEET,
        )
        for name, table in (
            ("Friction", page_tables.point_table(results)),
            ("Efficiency", page_tables.efficiency_table(results)),
        )
        if table.rows
    ]
    if not parts:
        return ()
    note = () if all(part.printed for part in parts) else (_NOT_PRINTED,)
    title = "Appendix: all points"
    return (Section(title, note, parts=tuple(parts), anchor="points", folded=True),)
