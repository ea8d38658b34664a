"""A comparison in words and numbers: for the terminal, as JSON, and its page."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, replace

from hbench.records import (
    CampaignDifferences,
    CurveDifference,
    Difference,
    FrictionDifference,
    WordTable,
)
from hbench.report.campaign.fit_tables import label_and_unit, law_words
from hbench.report.campaign.quality import missing_words, quality_verdict
from hbench.report.campaign.series_words import TITLES, kind_words, load_words
from hbench.report.comparison.bands import (
    band_table,
    band_verdict,
    bands_document,
    slope_table,
)
from hbench.report.comparison.cells import (
    cells,
    difference_table,
    label_of,
    numbers,
    percent,
    signed,
    with_names,
)
from hbench.report.comparison.settings import (
    settings_table,
    settings_that_differ,
    settings_words,
)
from hbench.report.json_documents.values import json_value
from hbench.report.render.document import BANNERS, Document, Section, page
from hbench.report.render.figures import Drawing
from hbench.report.render.numbers import alike, number, significant, with_interval
from hbench.report.render.terminal_table import table_lines
from hbench.units import from_si

SCHEMA = "hbench.comparison/1"
_PLAIN = {"−": "-", "–": "-", "\N{NON-BREAKING HYPHEN}": "-", "±": "+-", "²": "^2", "³": "^3"}


def differences_text(differences: CampaignDifferences) -> str:
    """Return the verdict and the tables for a terminal."""
    differences = with_names(differences)
    lines = [
        *filter(None, (_alarm(differences), _headline(differences))),
        "",
        *(f"{name}: {words}" for name, words in (*_identity(differences), *_data(differences))),
        *(
            f"{section}, {setting}: A {a}, B {b}"
            for section, setting, a, b in settings_that_differ(differences)
        ),
        "",
    ]
    tables = (
        band_table(differences),
        slope_table(differences),
        *_means(differences),
        _parameters(differences),
    )
    for table in tables:
        if table.rows:
            lines += [*table_lines(table), ""]
    strokes = [_SET_UP] if differences.bands else []
    lines += [f"note: {note}" for note in (*strokes, *differences.notes)]
    text = "\n".join(lines).rstrip()
    for sign, plain in _PLAIN.items():
        text = text.replace(sign, plain)
    return text


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
        **bands_document(differences),
        "notes": differences.notes,
    }
    return json.dumps(json_value(document), indent=1, allow_nan=False) + "\n"


def differences_page(differences: CampaignDifferences, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    differences = with_names(differences)
    figures: dict[str, tuple[Drawing, ...]] = {"bands": (), "comparison": ()}
    for drawing in drawings:
        figures[drawing.section] = (*figures[drawing.section], drawing)
    parameters = [p.value for curve in differences.curves for p in curve.parameters]
    sections = [
        Section(facts=_data(differences)),
        Section(
            "Friction bands",
            tables=(band_table(differences), slope_table(differences)),
            drawings=figures["bands"],
        ),
        Section(
            "Differences of mean friction and efficiency",
            (_READ,),
            tables=_means(differences),
            parts=(Section(drawings=figures["comparison"]),),
        ),
        _settings_section(differences),
        Section(
            "Fitted parameters",
            (_counted("fitted parameters", parameters),),
            parts=_folded("Each parameter", _parameters(differences)),
        ),
        Section(
            "Speed by speed",
            (_counted("points", [p.friction_n for p in _single_points(differences)]),),
            parts=_folded("Each speed", _points(differences)),
        ),
        Section("How it was computed", facts=_method(differences)),
    ]
    if differences.notes:
        sections.append(Section("Not compared", items=differences.notes))
    kept = tuple(
        replace(section, tables=tuple(table for table in section.tables if table.rows))
        for section in sections
        if any(table.rows for table in section.tables)
        or section.items
        or section.facts
        or any(part.folded is not None for part in section.parts)
        or section.anchor == _SETTINGS
    )
    banner = _banner(differences)
    return page(
        Document(
            f"{differences.names[1]} against {differences.names[0]}",
            "Friction and efficiency of two campaigns. Differences are B less A.",
            kept,
            " ".join((_headline(differences), settings_words(differences))),
            banner,
            "simulated" if banner else "",
            identity=_identity(differences),
            alarm=_alarm(differences),
        )
    )


def _banner(differences: CampaignDifferences) -> str:
    """State which campaigns are simulated; empty if both were measured."""
    simulated = [
        name
        for name, campaign in (("A", differences.a), ("B", differences.b))
        if campaign.source == "simulated"
    ]
    if len(simulated) == 2:
        return BANNERS["simulated"]
    return f"{simulated[0]} is simulated. The virtual rig made its numbers." if simulated else ""


def _settings_section(differences: CampaignDifferences) -> Section:
    table = settings_table(differences)
    if table.rows:
        table = replace(table, title="Settings of A and B that differ")
        return Section("Settings that differ", (_MAY_CAUSE,), tables=(table,), anchor=_SETTINGS)
    return Section("Settings that differ", (_NONE_DIFFERS,), anchor=_SETTINGS)


def _counted(what: str, differences: Sequence[Difference]) -> str:
    real = sum(difference.real for difference in differences)
    return (
        f"{real} of {len(differences)} differences of {what} are significant. "
        "comparison.json contains each."
    )


def _folded(title: str, table: WordTable) -> tuple[Section, ...]:
    count = len(table.rows)
    if not count:
        return ()
    long = count > _LONG  # comparison.json contains its numbers
    return (Section(f"{title} ({count})", tables=(table,), folded=long, printed=not long),)


_SETTINGS = "settings"
_MAY_CAUSE = (
    "A difference above may come from these settings, not from the cylinders: make them equal and "
    "measure again where that matters."
)
_NONE_DIFFERS = (
    "None. A difference above is one of the cylinders, their mounting or the conditions of the "
    "test, such as the oil."
)
_FEW = 2  # curves that the verdict lists
_LONG = 12  # rows; a longer table starts folded
_READ = (
    "± is the half-width of the 95 % interval by the trials alone; U contains the errors of the "
    "instruments too."
)
_SET_UP = (
    "Where the strokes of one file are trials, their interval does not contain what mounting a "
    "seal again would change."
)
_METHOD = (
    ("Friction", "As a magnitude. A point is the mean of its trials. The interval by the trials is "
     "that of Welch's t; U is the expanded uncertainty for a coverage probability of 95 %."),
    ("p (Holm)", "Probability of a difference this large between equal cylinders, by the trials "
     "alone, corrected after Holm for the number of differences of its kind. A difference is "
     "significant where p is below 0.05 and the difference exceeds its U."),
    ("Speeds", "Those within 2 % count as the same; within 20 % where no speed was set, as in "
     "strokes cut from a cycle. Labels must agree only if a campaign has several."),
    ("Means", "Over the speeds of A that B has or encloses, each speed with the same weight. "
     "Steady runs count as independent in spite of drifts between passes. The points of a ramp or "
     "of steps share their strokes, so that a trial's mean is one value."),
)  # fmt: skip
_BANDS = (
    "Compared at equal loads, or at pressures within 5 %. Half bands, middles and energies are "
    f"tested by their trials, slopes by their standard errors. {_SET_UP}"
)


def _verdict(differences: CampaignDifferences) -> str:
    means = [(each, each.mean_n) for each in differences.curves if each.mean_n is not None]
    real = [(curve, mean) for curve, mean in means if mean.real]
    if not real:
        every = len(differences.curves)
        where = f"any of {every} curves" if every > 1 else "the only curve"
        text = f"No difference of mean friction is significant in {where}"
        largest = max((mean for _, mean in means), key=lambda mean: abs(mean.value), default=None)
        return f"{text}; the largest is {_largest(largest)}." if largest else f"{text}."
    count = f"{len(real)} of {len(differences.curves)} curves"
    values = [mean.value for _, mean in real]
    if len(real) > _FEW and (min(values) > 0 or max(values) < 0):
        way, sizes = "higher" if values[0] > 0 else "lower", [abs(value) for value in values]
        shares = [100 * abs(mean.value / mean.a) for _, mean in real if mean.a]
        share = f", or {_shares(shares)}" if shares else ""
        return (
            f"Mean friction of {differences.names[1]} is {way} than that of {differences.names[0]} "
            f"in {count}, by {alike(sizes)} N{share} ({_widest([mean for _, mean in real])})."
        )
    means_text = "; ".join(
        f"{_who(curve)}: {signed(mean)} N ({percent(mean)})" for curve, mean in real
    )
    return f"Mean friction differs in {count}: {means_text}."


def _efficiency_verdict(differences: CampaignDifferences) -> str:
    """Return the significant differences of efficiency; empty without any."""
    known = [each.efficiency for each in differences.curves if each.efficiency is not None]
    real = [mean for mean in known if mean.real]
    if not real:
        return ""
    count = f"{len(real)} of {len(known)} curves"
    values = [100 * mean.value for mean in real]
    if min(values) < 0 < max(values):
        return f"Efficiency differs in {count}."
    way = "higher" if values[0] > 0 else "lower"
    halves = [100 * mean.u95 for mean in real if mean.u95]
    widest = f" (U up to {significant(max(halves), 2)})" if len(halves) == len(real) else ""
    sizes = dict.fromkeys(significant(f(map(abs, values)), 2) for f in (min, max))
    return f"Efficiency is {way} in {count}, by {'–'.join(sizes)} percentage points{widest}."


def _largest(mean: Difference) -> str:
    """Write a difference with its uncertainty, such as ``−3.1 N (U 9.4 N)``."""
    half = mean.u95 or mean.ci95
    value = with_interval(mean.value, half).partition(" ± ")[0]
    if half is None:
        return f"{value} N (no interval)"
    return f"{value} N ({_widest([mean])})".replace("up to ", "")


def _widest(means: Sequence[Difference]) -> str:
    """Return the largest uncertainty of differences: U, or the interval of the trials."""
    halves = [mean.u95 or mean.ci95 or 0.0 for mean in means]
    name = "U" if all(mean.u95 for mean in means) else "95 % intervals of the trials"
    return f"{name} up to {significant(max(halves), 2)} N"


def _shares(shares: Sequence[float]) -> str:
    return "–".join(dict.fromkeys(significant(f(shares), 2) for f in (min, max))) + " %"


def _method(differences: CampaignDifferences) -> tuple[tuple[str, str], ...]:
    bands = (("Bands", _BANDS),) if differences.bands else ()
    return (*_METHOD, *bands)


def _alarm(differences: CampaignDifferences) -> str:
    """Return a sentence on each campaign that is incomplete or whose data is poor."""
    sentences = []
    for name, quality in zip("AB", differences.qualities, strict=True):
        faults = (
            "is incomplete" if missing_words(quality.completeness) else "",
            "has poor data" if quality.grade == "poor" else "",
        )
        if any(faults):
            sentences.append(f"{name} {' and '.join(filter(None, faults))}.")
    return " ".join((*sentences, "Do not rely on these differences.")) if sentences else ""


def _headline(differences: CampaignDifferences) -> str:
    """Return the significant differences, and whose data is to be used with care."""
    careful = [
        name
        for name, quality in zip("AB", differences.qualities, strict=True)
        if quality.grade == "with care"
    ]
    care = f"Use the data of {' and '.join(careful)} with care." if careful else ""
    found = [band_verdict(differences)]
    if not found[0]:
        found = [_verdict(differences), _efficiency_verdict(differences)]
    return " ".join(filter(None, (*found, care)))


def _identity(differences: CampaignDifferences) -> tuple[tuple[str, str], ...]:
    """Return both campaigns, and whether they share instruments."""
    return (
        ("A", _name(differences, 0)),
        ("B", _name(differences, 1)),
        ("Instruments", _instruments(differences)),
    )


def _data(differences: CampaignDifferences) -> tuple[tuple[str, str], ...]:
    """Return the verdict on the data of each campaign."""
    a, b = (quality_verdict(quality) for quality in differences.qualities)
    return (("Data of A and B", a),) if a == b else (("Data of A", a), ("Data of B", b))


def _instruments(differences: CampaignDifferences) -> str:
    tested = [each.mean_n for each in differences.curves if each.mean_n is not None]
    if all(mean.u95 is None for mean in tested):
        return (
            "No interval contains the instruments: their tolerances are not known, or a point has "
            "one trial."
        )
    if differences.same_instruments:
        return "Same instruments: their errors are in both, and cancel where the readings agree."
    return "Other instruments in each, or not known to be the same: the errors of both count."


def _means(differences: CampaignDifferences) -> tuple[WordTable, WordTable]:
    """Return the means over the speeds of friction and of efficiency."""
    friction = [(curve, curve.mean_n) for curve in differences.curves]
    efficiency = [(curve, curve.efficiency) for curve in differences.curves]
    friction_table, efficiency_table = (
        difference_table(
            f"{title}: means over the speeds, and their differences",
            ("Curve",),
            [(_who(curve), *cells(each, scale)) for curve, each in known if each is not None],
        )
        for title, scale, known in (
            ("Friction (N)", 1.0, friction),
            ("Efficiency (%)", 100.0, efficiency),
        )
    )
    return friction_table, efficiency_table


def _parameters(differences: CampaignDifferences) -> WordTable:
    rows = []
    for curve in differences.curves:
        for p in curve.parameters:
            words, unit = label_and_unit(p.name, p.unit)
            scale = from_si(1.0, unit)
            rows.append(
                (_who(curve), law_words(p.law), f"{words} ({unit})", *cells(p.value, scale))
            )
    return difference_table("Fitted parameters", ("Curve", "Law", "Parameter"), rows)


def _points(differences: CampaignDifferences) -> WordTable:
    rows: list[tuple[str, ...]] = [
        (
            _who(curve),
            number(1e3 * point.v_m_s, 1) + (" *" if point.between else ""),
            *cells(point.friction_n, 1.0),
        )
        for curve in differences.curves
        if len(curve.points) > 1  # a single point is the mean
        for point in curve.points
    ]
    title = "Friction at each speed (N)"
    if any(point.between for each in differences.curves for point in each.points):
        title += "; * between two speeds of B"
    return difference_table(title, ("Curve", "Velocity (mm/s)"), rows)


def _single_points(differences: CampaignDifferences) -> list[FrictionDifference]:
    several = (curve for curve in differences.curves if len(curve.points) > 1)
    return [point for curve in several for point in curve.points]


def _who(pair: CurveDifference) -> str:
    load = load_words(pair.a.f_load_n, pair.a.p_lr_ref_pa)
    words = (label_of(pair), kind_words(pair.a), TITLES[pair.direction].lower(), load)
    return ", ".join(filter(None, words))


def _name(differences: CampaignDifferences, which: int) -> str:
    campaign = (differences.a, differences.b)[which]
    labels = {(curve.a, curve.b)[which].label for curve in differences.curves}
    label = labels.pop() if len(labels) == 1 else ""
    day = campaign.started[:10].replace("-", "\N{NON-BREAKING HYPHEN}")
    schedule = f"schedule {campaign.name}"
    words = (differences.names[which], schedule, label, campaign.source, day)
    return ", ".join(filter(None, words))
