"""The page of a diagnosis."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import partial

from hbench.records import Diagnosis, WordTable
from hbench.report.diagnosis import definitions
from hbench.report.diagnosis.heading import identity_facts, subtitle_words, title_words
from hbench.report.diagnosis.names import (
    added_words,
    in_words,
    keys_in_words,
    of_strokes,
    of_the_mass,
)
from hbench.report.diagnosis.sentences import predictions_words, reason_words, refused_words
from hbench.report.diagnosis.summary import (
    OF_CANDIDATES,
    OF_DEVIATIONS,
    OF_EFFECTS,
    OF_GAPS,
    OF_NEXT,
    OF_REFIT,
    answers,
    on_method,
)
from hbench.report.diagnosis.tables import effect_tables, gap_tables
from hbench.report.diagnosis.tables.change_tables import candidates_table, changes_tables
from hbench.report.diagnosis.tables.run_gaps import run_table
from hbench.report.diagnosis.tables.separability_tables import (
    MATRIX_TEXT,
    by_reason,
    lookalikes_tables,
    matrix_table,
)
from hbench.report.diagnosis.text import gap_line, in_page_words, law_lines
from hbench.report.diagnosis.verdict import verdict_words
from hbench.report.diagnosis.words.coefficient import keys_as_words
from hbench.report.render.document import Section, document
from hbench.report.render.figures import Drawing, of_section
from hbench.sentences import capital, listed

_MOST_RUNS = 40  # rows of the page


def diagnosis_page(diagnosis: Diagnosis, drawings: Sequence[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    drawn = partial(of_section, drawings)
    unnamed = Section(
        "Unnamed laws in the revised model",
        items=law_lines(diagnosis),
        drawings=drawn("unnamed"),
    )
    gap = _gap_section(diagnosis, drawn("gap"))
    where = _where_section(diagnosis, drawn("where"), drawn("shape"))
    overlay = Section("Runs outside the fit, measured and simulated", drawings=drawn("overlay"))
    which = _which_section(diagnosis, drawn("ranking"))
    effects = _effects_section(diagnosis)
    refitted = Section(
        "Refitted values",
        (_refitted_words(diagnosis),),
        drawings=drawn("refitted"),
        facts=(*_answers(diagnosis, OF_REFIT), *_refused(diagnosis)),
        parts=_numbers("Refitted values in numbers", _refitted_table(diagnosis)),
    )
    sections = (unnamed, gap, effects, where, overlay, refitted, which)
    if diagnosis.verdict == "unknown":
        sections = (unnamed, where, which, gap, overlay, effects, refitted)
    return document(
        title_words(diagnosis),
        subtitle_words(diagnosis),
        (
            _answer(diagnosis),
            *(section for section in sections if _holds_something(section)),
            _about_section(diagnosis),
        ),
        of_the_mass(diagnosis, verdict_words(diagnosis)),
        diagnosis.provenance.source,
        identity_facts(diagnosis),
    )


def _gap_section(diagnosis: Diagnosis, drawings: tuple[Drawing, ...]) -> Section:
    """Return the gap before and after; the numbers of signals and runs are folded."""
    simulated = Section("Simulated signals of runs outside the fit", drawings=drawings[1:])
    of_all = (
        *((simulated,) if simulated.drawings else ()),
        *_held_out_part(diagnosis),
        *_run_part(diagnosis),
        *_numbers("Runs of the fit", *_train_tables(diagnosis)),
    )
    opened = tuple(replace(part, folded=None) for part in of_all)
    every = Section("All gaps: signals, runs, numbers", parts=opened, folded=True, printed=False)
    return Section(
        _title_of_gaps(diagnosis),
        (gap_line(diagnosis),),
        drawings=drawings[:1],
        tables=_with_rows(gap_tables.errors_table(diagnosis), gap_tables.loads_table(diagnosis)),
        facts=_answers(diagnosis, OF_GAPS),
        parts=(
            *_terms("gaps", definitions.of_gaps(diagnosis)),
            *((every,) if opened else ()),
        ),
    )


def _where_section(
    diagnosis: Diagnosis, drawings: tuple[Drawing, ...], shapes: tuple[Drawing, ...]
) -> Section:
    """Return the balances that disagree; ``shapes`` are the figures of their residuals."""
    return Section(
        "Deviations that remain" if diagnosis.verdict == "none" else "Where the model disagrees",
        drawings=drawings,
        tables=_with_rows(gap_tables.where_table(diagnosis), gap_tables.rest_table(diagnosis)),
        parts=(
            *_in_words("Deviations in words", _answers(diagnosis, OF_DEVIATIONS)),
            *_terms("deviations", definitions.of_deviations(diagnosis)),
            *_numbers("Gaps by metering edge", _untitled(gap_tables.edges_table(diagnosis))),
            *_shape(diagnosis, shapes),
        ),
    )


def _which_section(diagnosis: Diagnosis, drawings: tuple[Drawing, ...]) -> Section:
    """Return the candidates by the evidence for each."""
    ranking = _untitled(effect_tables.ranking_table(diagnosis))
    return Section(
        "Effects that were tried" if diagnosis.verdict == "none" else "Which effect",
        (_sentence(reason_words(diagnosis)),),
        drawings=drawings,
        facts=(*_answers(diagnosis, OF_CANDIDATES), *definitions.WHICH),
        parts=(*_numbers("All candidates in numbers", ranking), *_matrix_part(diagnosis)),
    )


def _effects_section(diagnosis: Diagnosis) -> Section:
    """Return the effects, or the candidates that remain: then the detail of each is folded."""
    details = (*changes_tables(diagnosis), *lookalikes_tables(diagnosis))
    folded = _numbers("Each effect in detail", *details) if diagnosis.alternatives else ()
    changes = definitions.of_changes(diagnosis)
    return Section(
        "The effects" if diagnosis.effects else "The candidates that remain",
        (definitions.SENSOR,) if any(effect.of_sensor for effect in diagnosis.effects) else (),
        tables=_with_rows(
            _effects_table(diagnosis),
            effect_tables.alternatives_table(diagnosis),
            candidates_table(diagnosis),
            *([] if diagnosis.alternatives else details),
        ),
        facts=(
            *_answers(diagnosis, set(OF_EFFECTS).intersection(on_method(diagnosis))),
            *definitions.of_laws(diagnosis),
            *definitions.of_effects_gaps(diagnosis),
            *(() if folded else changes),
        ),
        parts=tuple(replace(part, facts=changes) for part in folded),
    )


def _about_section(diagnosis: Diagnosis) -> Section:
    """Return notes, what was left out, and the files beside the page."""
    return Section(
        "Notes and files",
        items=tuple(_effects_in_words(diagnosis, note) for note in diagnosis.notes),
        facts=(*_caveats(diagnosis), ("Files beside this page", _files(diagnosis))),
    )


def _title_of_gaps(diagnosis: Diagnosis) -> str:
    what = "Force error" if diagnosis.held_out_loads else "Gap between model and measurement"
    return f"{what}, before and after" if added_words(diagnosis) else what


def _answer(diagnosis: Diagnosis) -> Section:
    """Return the first section: the engineer's answers, and folded the runs that show more."""
    names = {name for name, _ in answers(diagnosis)}
    known = _answers(diagnosis, names.difference(on_method(diagnosis), OF_NEXT))
    parts = _in_words("Runs that show more: next.yaml", _answers(diagnosis, OF_NEXT))
    return Section("Findings and next steps", facts=known, parts=parts)


def _in_words(title: str, facts: tuple[tuple[str, str], ...]) -> tuple[Section, ...]:
    """Return a folded part of answers that the title names."""
    words = tuple(text for _, text in facts)
    return (Section(title, words, folded=True),) if words else ()


def _refused(diagnosis: Diagnosis) -> tuple[tuple[str, str], ...]:
    """Return why the refit without effects was refused; nothing where it was not."""
    if not diagnosis.refit_refused:
        return ()
    added = added_words(diagnosis)
    fitted = definitions.FITTED_WITH.format(added=added) if added and diagnosis.refitted else ""
    words = refused_words(diagnosis)
    return (("Refit refused", f"{words} {definitions.REFUSED.format(fitted=fitted)}"),)


def _answers(diagnosis: Diagnosis, questions: Collection[str]) -> tuple[tuple[str, str], ...]:
    """Return the answers to some questions in the words of the page."""
    return tuple(
        (question, of_the_mass(diagnosis, keys_in_words(words)))
        for question, words in answers(diagnosis)
        if question in questions
    )


def _files(diagnosis: Diagnosis) -> str:
    """Return which files are beside the page, and what they are for."""
    contents = [
        *(["the effects"] if diagnosis.confirmed else []),
        *(["unnamed laws"] if diagnosis.unnamed else []),
    ]
    if diagnosis.refitted and diagnosis.refit_refused:
        contents.append("values fitted with them")
    elif diagnosis.refitted:
        contents.insert(0, "refitted values")
    model = f"the model with {listed(contents)}" if contents else "the model as given"
    files = [definitions.NEXT_FILE] if diagnosis.next_schedule else []
    whole = not (of_strokes(diagnosis) or diagnosis.errors)  # the plant of a bench
    command = "run --plant" if whole and diagnosis.provenance.firmware else "reconcile"
    use = "; do not predict with it" if predictions_words(diagnosis) else f", for hbench {command}"
    files.append(f"model.yaml is {model}{use}.")
    left_out = [in_words(effect.name) for effect in diagnosis.effects if not effect.confirmed]
    if left_out:
        files.append(f"It does not contain {listed(left_out)}.")
    files.append(
        definitions.NUMBERS if diagnosis.gap_runs else "diagnosis.json is this result as data."
    )
    return " ".join(files)


def _shape(diagnosis: Diagnosis, drawings: tuple[Drawing, ...]) -> tuple[Section, ...]:
    """Return the residuals of each balance, folded unless they are the answer."""
    if diagnosis.verdict == "unknown" or of_strokes(diagnosis):
        return (Section("Shape of the residuals", drawings=drawings),) if drawings else ()
    return _folded("Residuals of each quantity over velocity, position, time and load", drawings)


def _folded(title: str, drawings: tuple[Drawing, ...]) -> tuple[Section, ...]:
    """Return a folded part of figures, which are files beside the page too."""
    return (Section(title, drawings=drawings, folded=True, printed=False),) if drawings else ()


def _held_out_part(diagnosis: Diagnosis) -> tuple[Section, ...]:
    of = f"{'loads' if of_strokes(diagnosis) else 'runs'} outside the fit"
    tables = gap_tables.gap_tables(diagnosis, diagnosis.gap_heldout, of)
    facts = definitions.of_numbers(diagnosis) if diagnosis.held_out_loads else ()
    parts = _numbers(capital(of), *tables)
    return tuple(replace(part, facts=facts) for part in parts)


def _train_tables(diagnosis: Diagnosis) -> tuple[WordTable, ...]:
    return gap_tables.gap_tables(diagnosis, diagnosis.gap_train, "runs of the fit")


def _effects_table(diagnosis: Diagnosis) -> WordTable:
    table = effect_tables.effects_table(diagnosis)
    rows = (tuple(of_the_mass(diagnosis, cell) for cell in row) for row in table.rows)
    return replace(table, rows=tuple(rows))


def _refitted_table(diagnosis: Diagnosis) -> WordTable:
    table = _untitled(effect_tables.refitted_table(diagnosis))
    rows = ((of_the_mass(diagnosis, name), words) for name, words in table.rows)
    return replace(table, rows=tuple(rows))


def _refitted_words(diagnosis: Diagnosis) -> str:
    """Return what was fitted, and when."""
    if not diagnosis.refit_refused:
        return f"{definitions.poorly_known(diagnosis)} {definitions.REFITTED}"
    return (
        f"{definitions.poorly_known(diagnosis)} Fitted first, they made runs outside the fit "
        f"worse; these are fitted together with the {added_words(diagnosis)}."
    )


def _effects_in_words(diagnosis: Diagnosis, note: str) -> str:
    """Return a note with its effects in words; keys of files, as of an import map, are kept."""
    names = [each.name for each in (*diagnosis.ranking, *diagnosis.alternatives)]
    for name in dict.fromkeys((*names, *(effect.name for effect in diagnosis.effects))):
        note = note.replace(name, in_words(name))
    return _sentence(note)


def _caveats(diagnosis: Diagnosis) -> tuple[tuple[str, str], ...]:
    """Return missing data, effects that were not tried and runs left out."""
    untried = [
        _sentence(f"{keys_in_words(', '.join(names)) if diagnosis.ranking else 'all'} ({reason}).")
        for key, names in by_reason(diagnosis.not_tried).items()
        for reason in [keys_as_words(key)]
    ]
    parts = {
        "Missing data": [f"{_sentence(item)}." for item in diagnosis.missing if diagnosis.where],
        "Effects not tried": untried,
        "Runs left out": [f"{_sentence(line)}." for line in diagnosis.left_out],
    }
    return tuple((name, " ".join(lines)) for name, lines in parts.items() if lines)


def _terms(of: str, facts: tuple[definitions.Fact, ...]) -> tuple[Section, ...]:
    """Return a folded part with the definitions of a section's terms."""
    return (Section(f"Terms of the {of}", facts=facts, folded=True),) if facts else ()


def _numbers(title: str, *tables: WordTable) -> tuple[Section, ...]:
    """Return a folded part of tables, whose numbers the files beside the page contain too."""
    known = _with_rows(*tables)
    return (Section(title, tables=known, folded=True, printed=False),) if known else ()


def _run_part(diagnosis: Diagnosis) -> tuple[Section, ...]:
    table = run_table(diagnosis, _MOST_RUNS)
    parts = _numbers(table.title, _untitled(table))
    return tuple(replace(part, paragraphs=(definitions.RUNS,)) for part in parts)


def _matrix_part(diagnosis: Diagnosis) -> tuple[Section, ...]:
    table = matrix_table(diagnosis)
    parts = _numbers(table.title, _untitled(table))
    return tuple(replace(part, paragraphs=(MATRIX_TEXT,)) for part in parts)


def _untitled(table: WordTable) -> WordTable:
    return replace(table, title="")


def _with_rows(*tables: WordTable) -> tuple[WordTable, ...]:
    """Return the tables that have rows, with effects' names in words."""
    return tuple(in_page_words(table) for table in tables if table.rows)


def _sentence(line: str) -> str:
    line = line.strip()
    return f"{line[:1].upper()}{line[1:]}"


def _holds_something(section: Section) -> bool:
    return bool(
        section.items or section.drawings or section.tables or section.parts or section.facts
    )
