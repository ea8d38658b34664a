"""The page of a diagnosis."""

from collections.abc import Sequence
from dataclasses import replace

from hbench.records import Diagnosis, WordTable
from hbench.report.diagnosis import text as text
from hbench.report.diagnosis.change_words import changes_tables, lookalikes_tables
from hbench.report.diagnosis.run_gaps import run_table
from hbench.report.diagnosis.separability_tables import MATRIX_TEXT, matrix_table
from hbench.report.diagnosis.summary import summary
from hbench.report.render.document import Section, document
from hbench.report.render.figures import Drawing

_MOST_RUNS = 40  # rows of the page
_SENSOR = (
    "An effect of a sensor is an error of the measurement, not of the bench. Correct the "
    "instrument rather than the model."
)
_CHANGES = (
    "What an effect changes: each balance is evaluated with the effect and without it, all else in"
    " the model being the same. The working point is the measured operating point nearest to the "
    "median speed, load and pressures. Its motion is steady; the 95 % interval is that of the "
    "effect's coefficients. Along the logs: at all windows of the measured motion. Flows are into a"
    " chamber, friction is against the motion. The speed changes so at the same commands and "
    "pressures, the pressure of the fed chamber at the same speed and load."
)
_REFITTED_STAGE = "Refitted: the model with its poorly known values fitted and no effect added."
_CLOSED = (
    "The balances decide; the same schedule, simulated in closed loop, confirms. Small errors of "
    "all values add up in the closed loop."
)
_RUNS = (
    "The gap of a single run includes its own scatter and is 1 for a correct model. The last "
    "columns show the worst balance and signals of the run, at the last step. gaps_by_run.csv "
    "beside this page contains every run and signal."
)
_WHERE = (
    "A balance is a law that the measured signals must obey: continuity of the oil in a chamber, "
    "forces on either side of the load cell, position against velocity, the supply. It is "
    "evaluated along the measured logs with the laws of the refitted model. p: the probability of "
    "such a gap for a correct model, corrected after Holm. Deviation: root mean square of the "
    "residual without the noise of single windows; below the next column it does not matter. "
    "Tolerances allow: what sensors within their tolerances may cause in a model that is not "
    "refitted."
)
_WHICH = (
    "Score: gain of log-likelihood at held-out operating points. Explains: share of the excess gap "
    "that it removes there, in the balances that the effect touches. Size: its largest coefficient "
    "relative to a typical one."
)
_REFITTED = (
    "Poorly known values of the model file, such as levels of friction, a valve's gain or dead "
    "volumes, are fitted first, so that their errors are not mistaken for an effect."
)
_FILES = (
    "Beside this page: model.yaml, the model with the refitted values and the added effects, for "
    "hbench run --plant; diagnosis.json; gaps_by_run.csv; the figures as SVG and PNG."
)
_NEXT_FILE = (
    "next.yaml beside this page is that experiment: hbench run next.yaml --bench BENCH -o NEXT."
)


def diagnosis_page(diagnosis: Diagnosis, drawings: Sequence[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    provenance, held = diagnosis.provenance, ", ".join(diagnosis.heldout_runs)

    def drawn(section: str) -> tuple[Drawing, ...]:
        return tuple(drawing for drawing in drawings if drawing.section == section)

    closed = (_CLOSED,) if diagnosis.gap_heldout.signals else ()
    shape = Section(
        "Shape of the residuals" if diagnosis.verdict == "unknown" else "Residuals of each balance",
        drawings=drawn("shape"),
    )
    unnamed = Section(
        "Unnamed laws in the revised model",
        items=text.law_lines(diagnosis),
        drawings=drawn("unnamed"),
    )
    gap = Section(
        "The gap before and after" if diagnosis.effects else "The gap",
        (text.gap_line(diagnosis), *closed, _REFITTED_STAGE, f"Held-out runs: {held}."),
        drawings=drawn("gap"),
        parts=(*_table_part(diagnosis), *_run_part(diagnosis)),
    )
    where = Section(
        "Where",
        (_WHERE,),
        drawings=drawn("where"),
        tables=_with_rows(text.where_table(diagnosis), text.edges_table(diagnosis)),
    )
    overlay = Section("Held-out runs, measured and simulated", drawings=drawn("overlay"))
    which = Section(
        "Which effect",
        (diagnosis.why, _WHICH),
        drawings=drawn("ranking"),
        tables=_with_rows(text.ranking_table(diagnosis)),
        parts=_matrix_part(diagnosis),
    )
    refitted = Section(
        "Refitted values",
        (_REFITTED,),
        drawings=drawn("refitted"),
        tables=_with_rows(text.refitted_table(diagnosis)),
    )
    effects = Section(
        "The effects" if diagnosis.effects else "The candidates that remain",
        (
            *text.effect_lines(diagnosis),
            _CHANGES if diagnosis.practice else "",
            _SENSOR if any(effect.of_sensor for effect in diagnosis.effects) else "",
        ),
        tables=_with_rows(
            text.effects_table(diagnosis),
            text.alternatives_table(diagnosis),
            *changes_tables(diagnosis),
            *lookalikes_tables(diagnosis),
        ),
    )
    missing = Section(
        "Missing data and runs left out", items=(*text.caveats(diagnosis), *diagnosis.notes)
    )
    train = Section(
        "Gaps of the runs that the model was fitted to",
        tables=text.gap_tables(diagnosis, diagnosis.gap_train, "training runs"),
    )
    if diagnosis.verdict == "unknown":
        evidence = (shape, where, gap, overlay, effects)
    else:
        evidence = (gap, overlay, effects, where, shape)
    sections = (_answer(diagnosis), unnamed, *evidence, which, refitted, missing, train)
    return document(
        f"{diagnosis.model} against {provenance.name}",
        f"Campaign {provenance.name}, {provenance.source}, {provenance.started[:10]}; "
        f"bench {provenance.bench}.",
        tuple(
            section for section in sections if section is sections[0] or _holds_something(section)
        ),
        _verdict(diagnosis),
        provenance.source,
    )


def _verdict(diagnosis: Diagnosis) -> str:
    """Return the terminal's headline as sentences."""
    kind, _, finding = text.verdict_sentence(diagnosis).partition(": ")
    names = [effect.name for effect in diagnosis.effects] + [
        candidate.name for candidate in diagnosis.alternatives
    ]
    for name in names:
        finding = finding.replace(name, name.replace("_", " "))
    if diagnosis.verdict == "named":
        return f"The missing effect is identified: {finding}"
    if diagnosis.verdict == "ambiguous":
        return f"The missing effect is ambiguous: {finding}"
    if diagnosis.verdict == "none":
        return f"No effect is missing: {finding}"
    return f"Verdict: {kind}. {finding[:1].upper()}{finding[1:]}"


def _answer(diagnosis: Diagnosis) -> Section:
    """Return the first section: the engineer's paragraph, and the files beside the page."""
    files = f"{_NEXT_FILE} {_FILES}" if diagnosis.next_schedule else _FILES
    return Section(paragraphs=(summary(diagnosis), files))


def _table_part(diagnosis: Diagnosis) -> tuple[Section, ...]:
    tables = text.gap_tables(diagnosis, diagnosis.gap_heldout, "held-out runs")
    part = Section("Gap of held-out runs in numbers", tables=tables, folded=True)
    return (part,) if tables else ()


def _matrix_part(diagnosis: Diagnosis) -> tuple[Section, ...]:
    table = matrix_table(diagnosis)
    part = Section(table.title, (MATRIX_TEXT,), tables=(replace(table, title=""),))
    return (part,) if table.rows else ()


def _run_part(diagnosis: Diagnosis) -> tuple[Section, ...]:
    table = run_table(diagnosis, _MOST_RUNS)
    part = Section(table.title, (_RUNS,), tables=(replace(table, title=""),), folded=True)
    return (part,) if table.rows else ()


def _with_rows(*tables: WordTable) -> tuple[WordTable, ...]:
    return tuple(table for table in tables if table.rows)


def _holds_something(section: Section) -> bool:
    return bool(section.items or section.drawings or section.tables or section.parts)
