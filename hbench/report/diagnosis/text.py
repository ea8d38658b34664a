"""A diagnosis in words and tables, for the terminal and the page."""

from math import isfinite

from hbench.records import (
    AddedEffect,
    Diagnosis,
    Gap,
    WordTable,
)
from hbench.report.diagnosis.names import (
    BALANCE_NAMES,
    gap_number,
    in_sentence,
    keys_in_words,
    steps_of,
)
from hbench.report.diagnosis.sentences import reason_words
from hbench.report.diagnosis.summary import short_summary
from hbench.report.diagnosis.tables.change_tables import candidates_table, changes_tables
from hbench.report.diagnosis.tables.effect_tables import (
    alternatives_table,
    effects_table,
    ranking_table,
    refitted_table,
)
from hbench.report.diagnosis.tables.gap_tables import (
    errors_table,
    gap_tables,
    loads_table,
    rest_table,
    where_table,
)
from hbench.report.diagnosis.tables.run_gaps import run_table
from hbench.report.diagnosis.tables.separability_tables import not_tried_lines
from hbench.report.diagnosis.words.coefficient import effect_words
from hbench.report.diagnosis.words.deviation import (
    agrees,
    deviations,
    expected_words,
    not_expected,
    undecided_balance,
)
from hbench.report.diagnosis.words.error import errors_in_words, load_errors, one_sided_words
from hbench.report.diagnosis.words.law import law_line
from hbench.report.render.symbols import listed
from hbench.report.render.terminal_table import table_lines
from hbench.report.render.terminal_text import plain

_LEFT_OUT = 5  # runs that the terminal lists


def diagnosis_text(diagnosis: Diagnosis) -> str:
    """Return the verdict, every table and the caveats, for a terminal (ASCII)."""
    blocks = [
        f"{verdict_sentence(diagnosis)}\n{keys_in_words(short_summary(diagnosis))}",
        gap_line(diagnosis),
    ]
    errors = (errors_in_words(diagnosis), one_sided_words(diagnosis))
    blocks += (
        reason_words(diagnosis),
        " ".join(filter(None, errors)),
        *effect_lines(diagnosis),
        *law_lines(diagnosis),
    )
    experiment = keys_in_words(diagnosis.next_experiment or "")
    if experiment not in blocks[0]:
        blocks.append(f"next experiment: {experiment}")
    blocks += ["\n".join(table_lines(table)) for table in diagnosis_tables(diagnosis)]
    blocks += ["\n".join(lines) for lines in (caveats(diagnosis), diagnosis.notes) if lines]
    return plain("\n\n".join(block for block in blocks if block))


def verdict_sentence(diagnosis: Diagnosis) -> str:
    """Return the verdict in one sentence, with the effects' coefficients or the set."""
    effects = "; ".join(map(_finding, diagnosis.effects))
    names = listed([candidate.name for candidate in diagnosis.alternatives], "or")
    if diagnosis.verdict == "named":
        also = f" Also {names}; these data cannot distinguish them." if names else ""
        gaps = not_expected(diagnosis)
        rest = f" Not explained: {deviations(gaps)}." if gaps else ""
        expected = expected_words(diagnosis)
        return f"named: {effects}.{also}{rest}{' ' if expected else ''}{expected}"
    also = f" Added before: {effects}." if effects else ""
    if diagnosis.verdict == "ambiguous":
        return f"ambiguous: {names}; these data cannot distinguish them.{also}"
    if diagnosis.verdict == "unknown" and not diagnosis.where:
        return "unknown: these data are too few for a verdict."
    if diagnosis.verdict == "unknown":
        where = _list(diagnosis.rest or diagnosis.where[:1])
        return f"unknown: no effect of the catalogue explains the residuals in {where}.{also}"
    refitted = "with refitted values " if diagnosis.refitted and not diagnosis.refit_refused else ""
    total = diagnosis.gap_heldout.total
    gap, expected = gap_number(total.refitted), gap_number(total.floor)
    if agrees(diagnosis):
        finding = f"{refitted}the model agrees with the measurement"
        if isfinite(total.refitted):
            finding += (
                f". In runs outside the fit the model deviates by {gap} times the repeatability "
                "(1 is the scatter of repeated trials, and lower is better); a correct model with "
                f"equally uncertain values would deviate by {expected} times on average"
            )
    else:
        finding = (
            f"{refitted}the model deviates from runs outside the fit by {gap} times the "
            f"repeatability, a correct one by {expected} on average; no known effect explains the "
            "difference"
        )
    if {gap.name for gap in diagnosis.where} < BALANCE_NAMES.keys():
        return f"none: in the quantities that these channels determine, {finding}."
    return f"none: {finding}."


def _finding(effect: AddedEffect) -> str:
    unconfirmed = "" if effect.confirmed else ", not confirmed by runs outside the fit"
    return f"{effect_words(effect)}{unconfirmed}"


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
    """Return the tables that have rows, the answers first and the evidence after them."""
    every = (
        candidates_table(diagnosis),
        *changes_tables(diagnosis),
        errors_table(diagnosis),
        loads_table(diagnosis),
        effects_table(diagnosis),
        alternatives_table(diagnosis),
        where_table(diagnosis),
        rest_table(diagnosis),
        *gap_tables(diagnosis, diagnosis.gap_heldout, "runs outside the fit"),
        run_table(diagnosis, _FEW),
        ranking_table(diagnosis, _FEW),
        refitted_table(diagnosis),
    )
    return tuple(table for table in every if table.rows)


def effect_lines(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return for each effect whether it is the bench's or a sensor's, its law and its form."""
    return tuple(
        f"{effect.name} (of the {'sensors' if effect.of_sensor else 'bench'}): "
        f"{effect.description}; form: {effect.shape or 'the textbook one'}."
        for effect in diagnosis.effects
    )


def law_lines(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return for each unnamed law what it adds and what it does to held-out runs."""
    return tuple(map(law_line, diagnosis.unnamed))


_FEW = 8  # candidates, and runs, that a terminal is shown


def caveats(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return missing data, effects that were not tried and runs left out, a sentence each."""
    lines = [f"missing for a better verdict: {item}" for item in diagnosis.missing]
    lines += not_tried_lines(diagnosis.not_tried)
    lines += [diagnosis.refit_refused] if diagnosis.refit_refused else []
    if diagnosis.left_out:
        lines.append(f"runs left out: {len(diagnosis.left_out)}")
        lines += [f"  {line}" for line in diagnosis.left_out[:_LEFT_OUT]]
        if (more := len(diagnosis.left_out) - _LEFT_OUT) > 0:
            lines.append(f"  and {more} more, in diagnosis.json")
    return tuple(lines)


def _list(gaps: tuple[Gap, ...]) -> str:
    return listed([in_sentence(gap.name) for gap in gaps])
