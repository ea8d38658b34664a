"""A diagnosis in words and tables, for the terminal and the page."""

from collections.abc import Collection
from dataclasses import replace

from hbench.records import Diagnosis, WordTable
from hbench.report.diagnosis.names import gap_number, in_sentence, keys_in_words, steps_of
from hbench.report.diagnosis.tables.change_tables import candidates_table
from hbench.report.diagnosis.tables.effect_tables import (
    alternatives_table,
    effects_table,
    ranking_table,
)
from hbench.report.diagnosis.tables.gap_tables import (
    errors_table,
    loads_table,
    rest_table,
    where_table,
)
from hbench.report.diagnosis.words.deviation import undecided_balance
from hbench.report.diagnosis.words.error import load_errors
from hbench.report.diagnosis.words.law import law_line
from hbench.report.render.word_tables import with_columns
from hbench.sentences import capital

_FEW = 5  # candidates that a terminal is shown
_OF_EFFECTS = ("effect", "coefficient", "value with 95 % interval", "in model.yaml")
_OF_DEVIATIONS = ("quantity", "deviation", "matters above", "p (Holm)")


def in_page_words(table: WordTable) -> WordTable:
    """Return a table with effects and quantities in words, and heads that begin with a capital."""
    return WordTable(
        keys_in_words(table.title),
        tuple(name if name.startswith("p ") else _head(name) for name in table.head),
        tuple(tuple(map(keys_in_words, row)) for row in table.rows),
    )


def _head(name: str) -> str:
    return capital(keys_in_words(name))


def gap_line(diagnosis: Diagnosis) -> str:
    """Return the gap of all balances over the held-out runs, from the model as given on.

    Empty where nothing was compared.
    """
    total = diagnosis.gap_heldout.total
    if not diagnosis.gap_heldout.balances:
        return ""
    if errors := load_errors(diagnosis):
        sizes = ", ".join(f"{error} {title}" for title, error in errors.items())
        line = f"Force error at loads outside the fit, root mean square: {sizes}."
        return " ".join(filter(None, (line, _most_in(diagnosis))))
    steps = ", ".join(
        f"{gap_number(getattr(total, step))} {title}"
        for step, title in steps_of(diagnosis).items()
        if step != "floor"
    )
    worse = not diagnosis.refit_refused and total.refitted > total.before
    remark = " The refit increases it." if worse else ""
    every = ", all flows and forces" if len(diagnosis.gap_heldout.balances) > 1 else ""
    words = (
        f"Gap of runs outside the fit (RMS of measurement less model, in multiples of the "
        f"repeatability{every}): {steps}.{remark} A correct model with equally uncertain values "
        "would have "
        f"{gap_number(total.floor)} on average.",
        _most_in(diagnosis),
    )
    return " ".join(filter(None, words))


def _most_in(diagnosis: Diagnosis) -> str:
    name = undecided_balance(diagnosis)
    if name is None:
        return ""
    return (
        f"Most of what remains is in {in_sentence(name)}: of its possible causes, which these runs "
        "cannot distinguish, none is added to the model."
    )


def diagnosis_tables(diagnosis: Diagnosis) -> tuple[WordTable, ...]:
    """Return the tables of a terminal that have rows, in their main columns; the page has more."""
    unnamed = not diagnosis.effects and not diagnosis.alternatives
    every = (
        candidates_table(diagnosis),
        errors_table(diagnosis),
        loads_table(diagnosis),
        replace(_columns(effects_table(diagnosis), _OF_EFFECTS), title="Effects"),
        alternatives_table(diagnosis),
        _columns(where_table(diagnosis) if unnamed else rest_table(diagnosis), _OF_DEVIATIONS),
        *([ranking_table(diagnosis, _FEW)] if diagnosis.verdict == "unknown" else []),
    )
    return tuple(table for table in every if table.rows)


def _columns(table: WordTable, names: Collection[str]) -> WordTable:
    """Return the columns of some names; all of a table that has none of them."""
    kept = [i for i, name in enumerate(table.head) if name in names] or range(len(table.head))
    return with_columns(table, kept)


def law_lines(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return for each unnamed law what it adds and what it does to held-out runs."""
    return tuple(map(law_line, diagnosis.unnamed))
