"""A comparison in words and numbers: for the terminal, as JSON, and its page."""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, replace

from hbench.records import (
    CampaignDifferences,
    Difference,
    WordTable,
)
from hbench.report.campaign.quality.completeness import missing_words
from hbench.report.comparison.about import data_facts, identity_facts
from hbench.report.comparison.bands import (
    band_table,
    bands_document,
    slope_table,
)
from hbench.report.comparison.breakaways import breakaway_table, breakaways_document
from hbench.report.comparison.cells import (
    numbers,
    with_names,
)
from hbench.report.comparison.method import (
    SET_UP,
    drift_facts,
    mean_facts,
    method_facts,
    p_fact,
    read_facts,
)
from hbench.report.comparison.settings import (
    plants_words,
    settings_table,
    settings_that_differ,
    settings_words,
)
from hbench.report.comparison.tables import (
    hidden_curves,
    means_tables,
    parameters_table,
    points_table,
    single_points,
    speeds_table,
)
from hbench.report.comparison.verdict import alarm, headline
from hbench.report.json_documents.values import json_text, json_value
from hbench.report.render.document import BANNERS, Document, Section, page
from hbench.report.render.figures import Drawing, of_section
from hbench.report.render.terminal_table import table_lines
from hbench.report.render.terminal_text import plain, wrapped
from hbench.sentences import plural

SCHEMA = "hbench.comparison/1"
_NEGATIVE = re.compile(r"(?<= )-(?=\d)")
_OIL = ("sensor", "mean_k", "low_k", "high_k", "runs")


def differences_text(differences: CampaignDifferences) -> str:
    """Return the verdict and the tables for a terminal."""
    differences = with_names(differences)
    lines = [
        *wrapped(" ".join(filter(None, (alarm(differences), headline(differences))))),
        "",
        *_paragraphs(*identity_facts(differences), *data_facts(differences)),
        *(
            line
            for section, setting, a, b in settings_that_differ(differences)
            for line in wrapped(f"{section}, {setting}: A {a}, B {b}")
        ),
        "",
    ]
    parameters = [p.value for curve in differences.curves for p in curve.parameters]
    friction, efficiency = means_tables(differences)
    tables = (
        band_table(differences),
        slope_table(differences),
        friction,
        speeds_table(differences),
        efficiency,
        breakaway_table(differences),
    )
    for table in tables:
        if table.rows:
            lines += [*table_lines(table), ""]
    strokes = [SET_UP] if differences.bands else []
    facts = [fact for fact in mean_facts(differences) if fact[0] == "Drift"]
    lines += _paragraphs(*read_facts(differences), p_fact(), *facts)
    lines += wrapped(_counted("of fitted parameters", parameters)) if parameters else []
    lines += [line for note in (*strokes, *differences.notes) for line in wrapped(f"note: {note}")]
    return plain("\n".join(lines).rstrip())


def _paragraphs(*facts: tuple[str, str]) -> list[str]:
    """Return named facts in lines of limited width."""
    return [line for name, words in facts for line in wrapped(f"{name}: {words}")]


def differences_json(differences: CampaignDifferences) -> str:
    """Return the text of ``comparison.json``."""
    document = {
        "schema": SCHEMA,
        "a": asdict(differences.a),
        "b": asdict(differences.b),
        "quality": {
            which: {"grade": quality.grade, "missing": missing_words(quality.completeness)}
            for which, quality in zip("ab", differences.qualities, strict=True)
        },
        "same_instruments": differences.same_instruments,
        "oil_temperature": {
            which: oil and {name: getattr(oil, name) for name in _OIL}
            for which, oil in zip("ab", differences.oil_temperatures, strict=True)
        },
        "settings_that_differ": [
            dict(zip(("section", "setting", "a", "b"), row, strict=True))
            for row in settings_that_differ(differences)
        ],
        "curves": [
            {
                "kind": curve.a.kind,
                "direction": curve.direction,
                "f_load_n": curve.a.f_load_n,
                "p_lr_ref_pa": curve.a.p_lr_ref_pa,
                "a_ref_m_s2": curve.a.a_ref_m_s2,
                "label_a": curve.a.label,
                "label_b": curve.b.label,
                "friction_n": numbers(curve.mean_n),
                "efficiency": numbers(curve.efficiency),
                "drift_n": curve.drift_n and asdict(curve.drift_n),
                "points": [
                    {
                        "v_m_s": point.v_m_s,
                        "between": point.between,
                        "friction_n": numbers(point.friction_n),
                    }
                    for point in curve.points
                ],
                "parameters": [
                    {"law": p.law, "name": p.name, "unit": p.unit, **numbers(p.value)}
                    for p in curve.parameters
                ],
            }
            for curve in differences.curves
        ],
        "mean_of_curves": differences.mean_of_curves and asdict(differences.mean_of_curves),
        **bands_document(differences),
        "breakaways": breakaways_document(differences),
        "notes": differences.notes,
    }
    return json_text(json_value(document))


def differences_page(differences: CampaignDifferences, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    differences = with_names(differences)
    drawings = tuple(drawings)
    friction, efficiency = means_tables(differences)
    terms = (*read_facts(differences), *mean_facts(differences), *drift_facts(differences))
    settings = settings_table(differences)
    sections = [
        Section(
            "Friction bands",
            tables=(band_table(differences), slope_table(differences)),
            drawings=of_section(drawings, "bands"),
        ),
        Section(
            "Difference of friction over speed",
            drawings=of_section(drawings, "speeds"),
            tables=(speeds_table(differences),),
        ),
        Section(
            "Differences of mean friction and efficiency",
            tables=(friction, efficiency),
            parts=(
                Section("What the columns contain", facts=terms, folded=True),
                Section(drawings=of_section(drawings, "comparison")),
            ),
        ),
        Section(
            "Breakaway",
            (_BREAKAWAY,),
            drawings=of_section(drawings, "breakaway"),
            tables=(breakaway_table(differences),),
            facts=() if differences.curves else read_facts(differences),
        ),
        Section(
            "Settings that differ",
            (_MAY_CAUSE,),
            tables=(replace(settings, title="Settings of A and B that differ"),),
        ),
        Section(
            "Further checks",
            facts=tuple(_checks(differences, bool(settings.rows))),
            parts=(
                *_folded("Each parameter", parameters_table(differences)),
                *_folded("Each speed", points_table(differences)),
            ),
        ),
        Section("How it was computed", facts=method_facts(differences), folded=True),
    ]
    if differences.notes:
        notes = (_NEGATIVE.sub("\N{MINUS SIGN}", note) for note in differences.notes)
        sections.append(Section("Not compared", items=tuple(notes)))
    kept = tuple(
        replace(section, tables=tuple(table for table in section.tables if table.rows))
        for section in sections
        if any(table.rows for table in section.tables) or section.items or section.facts
    )
    banner = _banner(differences)
    return page(
        Document(
            f"{differences.names[1]} against {differences.names[0]}",
            f"{_subjects(differences)} of two campaigns. Differences are B minus A.",
            kept,
            " ".join(filter(None, (headline(differences), settings_words(differences)))),
            banner,
            "simulated" if banner else "",
            identity=identity_facts(differences),
            alarm=alarm(differences),
        )
    )


def _subjects(differences: CampaignDifferences) -> str:
    """Return what is compared."""
    if not differences.curves:
        return "Breakaway"
    if differences.breakaways:
        return "Friction, hydro-mechanical efficiency and breakaway"
    return "Friction and hydro-mechanical efficiency"


def _banner(differences: CampaignDifferences) -> str:
    """State which campaigns are simulated; empty if both were measured."""
    simulated = [
        name
        for name, campaign in (("A", differences.a), ("B", differences.b))
        if campaign.source == "simulated"
    ]
    if len(simulated) == 2:
        return BANNERS["simulated"]
    return f"{simulated[0]} is simulated. A simulation made its numbers." if simulated else ""


def _checks(differences: CampaignDifferences, settings: bool) -> Iterator[tuple[str, str]]:
    """Yield the checks beside the means: settings, parameters, single speeds, quality."""
    if not settings:
        plants = (_PLANTS_DIFFER,) if plants_words(differences) else ()
        yield "Settings that differ", " ".join((_NONE_DIFFERS, *plants))
    parameters = [p.value for curve in differences.curves for p in curve.parameters]
    points = [p.friction_n for p in single_points(differences.curves)]
    hidden = sum(p.friction_n.real for p in single_points(hidden_curves(differences)))
    for name, counted, each, why in (
        ("Fitted parameters", _counted("of fitted parameters", parameters), parameters, _SPREAD),
        ("Single speeds", _counted("at single speeds", points, hidden), points, _MEANS_OF),
    ):
        if each:
            yield name, " ".join((counted, *_why(differences, each, why)))
    yield from data_facts(differences)


def _counted(what: str, differences: Sequence[Difference], hidden: int = 0) -> str:
    """Count the significant differences, without the ``hidden`` ones: they may come from drift."""
    real = sum(difference.real for difference in differences) - hidden
    verb = plural(real, "is", "are")
    beyond = plural(hidden, "exceeds its uncertainty", "exceed their uncertainty")
    drift = f"; {hidden} {beyond}, but may come from a drift" if hidden else ""
    return (
        f"{real} of {len(differences)} differences {what} {verb} significant{drift}. "
        "comparison.json contains each."
    )


def _why(
    differences: CampaignDifferences, parts: Sequence[Difference], words: str
) -> tuple[str, ...]:
    """Return why significant means need not have significant parts, where most have not."""
    means = any(curve.mean_n is not None and curve.mean_n.real for curve in differences.curves)
    few = sum(part.real for part in parts) < len(parts) / 2
    return (words,) if means and few else ()


def _folded(title: str, table: WordTable) -> tuple[Section, ...]:
    count = len(table.rows)
    if not count:
        return ()
    long = count > _LONG  # comparison.json contains its numbers
    return (Section(f"{title} ({count})", tables=(table,), folded=long, printed=not long),)


_BREAKAWAY = (
    "Breakaway is the largest friction while a rising force pushes the piston, which has rested "
    "under load. Each case is a direction, load, time at rest and rate of the force that both "
    "campaigns have."
)
_MAY_CAUSE = (
    "A difference above may come from these settings, not from the cylinders: make them equal and "
    "measure again where that matters."
)
_NONE_DIFFERS = (
    "None: bench file, instruments, schedule and software of both campaigns agree. A difference "
    "above is one of the cylinders, their mounting or the conditions of the test, such as the oil, "
    "or a drift."
)
_PLANTS_DIFFER = (
    "The simulated plants differ (see the top of the page). A plant takes the place of a "
    "cylinder and is no setting of the bench."
)
_SPREAD = (
    "The means above can differ significantly although the parameters do not: a fit distributes a "
    "difference over several parameters, each with a wider interval than the mean."
)
_MEANS_OF = (
    "The mean over all speeds has a smaller uncertainty than a single speed, and fewer tests to be "
    "corrected for."
)
_LONG = 12  # rows; a longer table starts folded
