"""The page of a diagnosis."""

from collections.abc import Sequence
from dataclasses import replace

from hbench.records import Diagnosis, WordTable
from hbench.report.diagnosis import text as text
from hbench.report.diagnosis.run_gaps import run_table
from hbench.report.render.document import Section, document
from hbench.report.render.figures import Drawing

_MOST_RUNS = 40  # rows of the page
_SENSOR = (
    "Effects in a sensor are errors of what measures: the bench itself is as the model says. Put "
    "the instrument right rather than the model."
)
_CLOSED = (
    "The balances decide and the closed loop confirms: small errors of all values add up in it, "
    "which its own floor tells. Refitted: the model with its badly known values fitted, and no "
    "effect added."
)
_RUNS = (
    "A single run is compared with the mean of the simulated ones: its own scatter is in its gap, "
    "which is 1 too where the model is right. The last columns are the worst balance and signals "
    "of the run, at the last step. gaps_by_run.csv beside this page has every run and signal."
)
_WHERE = (
    "A balance is a law that the measured signals must obey: continuity of the oil in a chamber, "
    "forces on either side of the load cell, position against velocity, the supply. What it lacks "
    "is compared with what simulated runs of the refitted model lack. p: the probability of such a "
    "gap if the model were right, corrected after Holm."
)
_WHICH = (
    "Score: gain of log-likelihood on operating points left out. Explains: share of the excess gap "
    "that goes there, in the balances that the effect touches. Size: its largest coefficient over "
    "a typical one."
)
_REFITTED = (
    "What a model file knows badly, such as levels of friction, a valve's gain or dead volumes, is "
    "fitted first, so that it is not taken for an effect."
)
_FILES = (
    "Beside this page: model.yaml, the model with what was refitted and added, which hbench run "
    "--plant takes as it is; diagnosis.json; gaps_by_run.csv; the figures as SVG and PNG."
)
_NEXT_FILE = (
    "next.yaml beside this page is that experiment: hbench run next.yaml --bench BENCH -o NEXT."
)


def diagnosis_page(found: Diagnosis, drawings: Sequence[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    made, held = found.provenance, ", ".join(found.heldout_runs)

    def drawn(section: str) -> tuple[Drawing, ...]:
        return tuple(one for one in drawings if one.section == section)

    shape = Section(
        "The shape of what it lacks" if found.verdict == "unknown" else "Residuals of each balance",
        drawings=drawn("shape"),
    )
    gap = Section(
        "The gap before and after" if found.effects else "The gap",
        (_CLOSED, f"Held-out runs: {held}."),
        drawings=drawn("gap"),
        tables=text.gap_tables(found, found.gap_heldout, "held-out runs"),
        parts=_run_part(found),
    )
    where = Section(
        "Where",
        (_WHERE,),
        drawings=drawn("where"),
        tables=_with_rows(text.where_table(found), text.edges_table(found)),
    )
    overlay = Section("Held-out runs, measured and simulated", drawings=drawn("overlay"))
    which = Section(
        "Which effect",
        (_WHICH,),
        drawings=drawn("ranking"),
        tables=_with_rows(text.ranking_table(found)),
    )
    refitted = Section(
        "What was refitted",
        (_REFITTED,),
        drawings=drawn("refitted"),
        tables=_with_rows(text.refitted_table(found)),
    )
    missing = Section("What is missing or left out", items=(*text.caveats(found), *found.notes))
    train = Section(
        "Gaps of the runs that the model was fitted to",
        tables=text.gap_tables(found, found.gap_train, "training runs"),
    )
    evidence = (shape, where, gap) if found.verdict == "unknown" else (gap, where, shape)
    sections = (_answer(found), *evidence, overlay, which, refitted, missing, train)
    return document(
        f"{found.model} against {made.name}",
        f"Campaign {made.name}, {made.source}, {made.started}; bench {made.bench}.",
        tuple(one for one in sections if one is sections[0] or _holds_something(one)),
        _verdict(found),
        made.source,
    )


def _verdict(found: Diagnosis) -> str:
    """Return the terminal's headline as sentences."""
    kind, _, words = text.headline(found).partition(": ")
    names = [effect.name for effect in found.effects] + [one.name for one in found.alternatives]
    for name in names:
        words = words.replace(name, name.replace("_", " "))
    if found.verdict in ("named", "ambiguous"):
        return f"Verdict: {kind}. The model lacks {words}"
    return f"Verdict: {kind}. {words[:1].upper()}{words[1:]}"


def _answer(found: Diagnosis) -> Section:
    """What a reader wants first: why, which effects with their numbers, what to do next."""
    next_ = f"Next experiment: {found.next_experiment}" if found.next_experiment else ""
    paragraphs = (
        found.why,
        text.gap_line(found),
        *text.effect_lines(found),
        _SENSOR if any(one.of_sensor for one in found.effects) else "",
        next_,
        _NEXT_FILE if found.next_schedule else "",
        _FILES,
    )
    return Section(
        paragraphs=tuple(filter(None, paragraphs)),
        tables=_with_rows(text.effects_table(found), text.alternatives_table(found)),
    )


def _run_part(found: Diagnosis) -> tuple[Section, ...]:
    table = run_table(found, _MOST_RUNS)
    part = Section(table.title, (_RUNS,), tables=(replace(table, title=""),), folded=True)
    return (part,) if table.rows else ()


def _with_rows(*tables: WordTable) -> tuple[WordTable, ...]:
    return tuple(table for table in tables if table.rows)


def _holds_something(section: Section) -> bool:
    return bool(section.items or section.drawings or section.tables)
