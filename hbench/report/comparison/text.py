"""A comparison in words and numbers: for the terminal, as JSON, and its page."""

import json
from collections.abc import Iterable
from dataclasses import asdict, replace
from typing import Any

from hbench.records import (
    CampaignDifferences,
    Curve,
    Difference,
    WordTable,
)
from hbench.report.campaign.fit_tables import label_and_unit, law_words
from hbench.report.campaign.series_words import kind_words
from hbench.report.json_documents.values import json_value
from hbench.report.render.document import Section, document
from hbench.report.render.figures import Drawing
from hbench.report.render.numbers import NONE, force, number, short, significant, with_interval
from hbench.report.render.style import TITLES
from hbench.report.render.terminal_table import table_lines
from hbench.units import from_si

SCHEMA = "hbench.comparison/1"
_REAL, _NOT = "differs", "not significant"


def differences_text(differences: CampaignDifferences) -> str:
    """Return the tables for a terminal."""
    lines = [
        f"A: {_name(differences, 0)}",
        f"B: {_name(differences, 1)}",
        _instruments(differences),
        "",
    ]
    for table in (_means(differences), _parameters(differences)):
        if table.rows:
            lines += [*table_lines(table), ""]
    lines += [f"note: {note}" for note in differences.notes]
    text = "\n".join(lines).rstrip()
    return text.replace("−", "-").replace("–", "-").replace("±", "+-").replace("²", "^2")


def differences_json(differences: CampaignDifferences) -> str:
    """Return the text of ``comparison.json``."""
    document = {
        "schema": SCHEMA,
        "a": asdict(differences.a),
        "b": asdict(differences.b),
        "same_instruments": differences.same_instruments,
        "curves": [
            {
                "kind": curve.a.kind,
                "direction": curve.direction,
                "f_load_n": curve.a.f_load_n,
                "p_lr_ref_pa": curve.a.p_lr_ref_pa,
                "a_ref_m_s2": curve.a.a_ref_m_s2,
                "label_a": curve.a.label,
                "label_b": curve.b.label,
                "friction_n": _numbers(curve.mean_n),
                "efficiency": _numbers(curve.efficiency),
                "points": [
                    {
                        "v_m_s": point.v_m_s,
                        "between": point.between,
                        "friction_n": _numbers(point.friction_n),
                    }
                    for point in curve.points
                ],
                "parameters": [
                    {"law": p.law, "name": p.name, "unit": p.unit, **_numbers(p.value)}
                    for p in curve.parameters
                ],
            }
            for curve in differences.curves
        ],
        "notes": differences.notes,
    }
    return json.dumps(json_value(document), indent=1, allow_nan=False) + "\n"


def differences_page(differences: CampaignDifferences, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    sections = [
        Section(
            "Differences of mean friction and efficiency",
            tables=(_means(differences),),
            drawings=tuple(drawings),
        ),
        Section("Fitted parameters", tables=(replace(_parameters(differences), title=""),)),
        Section("Speed by speed", tables=(_points(differences),)),
        Section("How it was computed", items=(_instruments(differences), *_METHOD)),
    ]
    if differences.notes:
        sections.append(Section("Not compared", items=differences.notes))
    return document(
        f"{differences.names[1]} against {differences.names[0]}",
        f"A: {_name(differences, 0)}. B: {_name(differences, 1)}. Differences are B less A.",
        tuple(
            section for section in sections if any(t.rows for t in section.tables) or section.items
        ),
        _verdict(differences),
        "simulated" if "simulated" in (differences.a.source, differences.b.source) else "",
    )


_METHOD = (
    "Friction as magnitude. A point is the mean of its trials; ± is the half-width of the 95 % "
    "interval of B less A, by Welch's t for the trials alone. U95 adds the instruments.",
    "p is the probability of a difference this large between trials of the same cylinder, "
    "corrected after Holm for the number of differences of its kind. A difference is significant "
    "where p is below 0.05 and the difference exceeds its U95.",
    "Means are over the speeds of A that B has or encloses, each speed with the same weight. "
    "Steady runs count as independent in spite of drifts between passes. The points of a ramp or "
    "of steps share their strokes, so that a trial's mean is one value.",
)


def _verdict(differences: CampaignDifferences) -> str:
    means = [(each.a, each.mean_n) for each in differences.curves if each.mean_n is not None]
    real = [(curve, mean) for curve, mean in means if mean.real]
    if not real:
        count = len(differences.curves)
        return f"No difference of mean friction is significant in any of {count} curves."
    means_text = "; ".join(
        f"{_who(curve)}: {_signed(mean)} N ({_percent(mean)})" for curve, mean in real
    )
    return (
        f"Mean friction differs in {len(real)} of {len(differences.curves)} curves: {means_text}."
    )


def _instruments(differences: CampaignDifferences) -> str:
    if differences.same_instruments:
        return "Same instruments: their errors are in both, and cancel where the readings agree."
    return "Other instruments in each, or not known to be the same: the errors of both count."


def _means(differences: CampaignDifferences) -> WordTable:
    rows = []
    for curve in differences.curves:
        for words, scale, difference in (
            ("friction (N)", 1.0, curve.mean_n),
            ("efficiency (%)", 100.0, curve.efficiency),
        ):
            if difference is not None:
                rows.append((_who(curve.a), words, *_cells(difference, scale)))
    return WordTable("Means over the speeds", ("Curve", "Mean of", *_HEAD), tuple(rows))


def _parameters(differences: CampaignDifferences) -> WordTable:
    rows = []
    for curve in differences.curves:
        for p in curve.parameters:
            words, unit = label_and_unit(p.name, p.unit)
            scale = from_si(1.0, unit)
            rows.append(
                (_who(curve.a), law_words(p.law), f"{words} ({unit})", *_cells(p.value, scale))
            )
    return WordTable("Fitted parameters", ("Curve", "Law", "Parameter", *_HEAD), tuple(rows))


def _points(differences: CampaignDifferences) -> WordTable:
    rows = [
        (
            _who(curve.a),
            number(1e3 * point.v_m_s, 1) + (" *" if point.between else ""),
            *_cells(point.friction_n, 1.0),
        )
        for curve in differences.curves
        for point in curve.points
    ]
    title = "Friction (N)"
    if any(point.between for each in differences.curves for point in each.points):
        title += "; * between two speeds of B"
    return WordTable(title, ("Curve", "Velocity (mm/s)", *_HEAD), tuple(rows))


_HEAD = ("A", "B", "B − A", "U95", "p (Holm)", "Verdict")


def _cells(difference: Difference, scale: float) -> tuple[str, ...]:
    half = None if difference.ci95 is None else scale * difference.ci95
    u95 = None if difference.u95 is None else scale * difference.u95
    return (
        significant(scale * difference.a, 4),
        significant(scale * difference.b, 4),
        with_interval(scale * difference.value, half),
        NONE if u95 is None else significant(u95, 2),
        NONE if difference.p_holm is None else _p(difference.p_holm),
        difference.untested or (_REAL if difference.real else _NOT),
    )


def _p(value: float) -> str:
    return "< 0.0001" if value < 1e-4 else significant(value, 2)


def _signed(difference: Difference) -> str:
    text = with_interval(difference.value, difference.u95 or difference.ci95)
    return f"+{text}" if difference.value > 0 else text


def _percent(difference: Difference) -> str:
    if difference.a == 0:
        return NONE
    share = 100 * difference.value / abs(difference.a)
    return f"{'+' if share > 0 else ''}{short(share)} %"


def _numbers(difference: Difference | None) -> Any:
    if difference is None:
        return None
    return {**asdict(difference), "difference": difference.value, "real": difference.real}


def _who(curve: Curve) -> str:
    load = "" if curve.f_load_n is None else force(curve.f_load_n)
    kind = kind_words(curve)
    return ", ".join(filter(None, (curve.label, kind, TITLES[curve.direction].lower(), load)))


def _name(differences: CampaignDifferences, which: int) -> str:
    campaign = (differences.a, differences.b)[which]
    return ", ".join(
        filter(
            None, (differences.names[which], campaign.name, campaign.source, campaign.started[:10])
        )
    )
