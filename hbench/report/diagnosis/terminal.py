"""A diagnosis for a terminal: the verdict, what to do, and the main tables."""

from collections.abc import Iterator

from hbench.records import Diagnosis
from hbench.report.diagnosis.heading import title_words
from hbench.report.diagnosis.names import keys_in_words, of_the_mass
from hbench.report.diagnosis.sentences import refused_words, ruled_out_words
from hbench.report.diagnosis.summary import OF_NEXT, Answer, answers, on_method
from hbench.report.diagnosis.tables.separability_tables import not_tried_lines, unseen_line
from hbench.report.diagnosis.text import diagnosis_tables, gap_line, in_page_words, law_lines
from hbench.report.diagnosis.verdict import verdict_words
from hbench.report.diagnosis.words.candidate import absorbed_words
from hbench.report.diagnosis.words.coefficient import keys_as_words
from hbench.report.diagnosis.words.error import errors_in_words, one_sided_words
from hbench.report.render.terminal_table import table_lines
from hbench.report.render.terminal_text import plain, wrapped
from hbench.sentences import capital

_LEFT_OUT = 5  # runs that the terminal lists
_GAP = "times the repeatability"  # in a verdict that states the gap of runs outside the fit


def diagnosis_text(diagnosis: Diagnosis) -> str:
    """Return the verdict, the answers, the main tables and the caveats; the page has the rest."""
    title = f"{title_words(diagnosis)} ({diagnosis.provenance.source}, verdict: "
    lead = of_the_mass(diagnosis, verdict_words(diagnosis))
    errors = (errors_in_words(diagnosis), one_sided_words(diagnosis))
    blocks = [
        "\n".join((f"{title}{diagnosis.verdict})", *wrapped(lead))),
        _paragraphs(*(f"{question}: {words}" for question, words in _short(diagnosis))),
        "" if _GAP in lead else _paragraphs(gap_line(diagnosis)),
        _paragraphs(" ".join(filter(None, errors))),
        _paragraphs(*law_lines(diagnosis)),
    ]
    tables = map(in_page_words, diagnosis_tables(diagnosis))
    blocks += ["\n".join(table_lines(table)) for table in tables]
    if not diagnosis.effects:
        blocks.append(_paragraphs(ruled_out_words(diagnosis)))
    notes = [line for note in diagnosis.notes for line in wrapped(note)]  # keys of files are kept
    blocks += [_paragraphs(*caveats(diagnosis)), "\n".join(notes)]
    return plain("\n\n".join(block for block in blocks if block))


def _short(diagnosis: Diagnosis) -> Iterator[Answer]:
    """Yield the answers without those on the method, and without the recipe of next.yaml."""
    hidden = on_method(diagnosis)
    for question, words in answers(diagnosis):
        if question in OF_NEXT and diagnosis.next_schedule:
            yield question, "Those of next.yaml; the page describes them."
        elif question not in hidden:
            yield question, words


def _paragraphs(*texts: str) -> str:
    """Return texts in lines of limited width, with effects and quantities in words."""
    return "\n".join(line for text in texts for line in wrapped(keys_in_words(text)))


def caveats(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return missing data, effects that were not tried and runs left out, a sentence each."""
    lines = [f"Missing for a better verdict: {item}" for item in diagnosis.missing]
    lines += filter(None, (unseen_line(diagnosis), absorbed_words(diagnosis)))
    lines += map(capital, map(keys_as_words, not_tried_lines(diagnosis.not_tried)))
    lines += [refused_words(diagnosis)] if diagnosis.refit_refused else []
    if diagnosis.left_out:
        lines.append(f"Runs left out: {len(diagnosis.left_out)}")
        lines += [f"- {line}" for line in diagnosis.left_out[:_LEFT_OUT]]
        if (more := len(diagnosis.left_out) - _LEFT_OUT) > 0:
            lines.append(f"- and {more} more, in diagnosis.json")
    return tuple(lines)
