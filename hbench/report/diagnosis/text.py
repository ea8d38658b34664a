"""A diagnosis in words and tables, for the terminal and the page."""

from collections.abc import Callable, Mapping

from hbench.records import (
    AddedEffect,
    BeforeAfter,
    Candidate,
    Diagnosis,
    Gap,
    GapTable,
    WordTable,
)
from hbench.report.diagnosis.names import (
    BALANCES,
    EDGES,
    Words,
    balance,
    quantity,
    scatter_words,
    share,
    signal,
    steps_of,
)
from hbench.report.diagnosis.run_gaps import run_table
from hbench.report.render.numbers import NONE, number, short
from hbench.report.render.terminal_table import aligned

Rows = tuple[tuple[str, ...], ...]

_UNIT_OF_GAP = "Gaps are in trial scatters: 1 is as good as the bench repeats itself."


def diagnosis_text(found: Diagnosis) -> str:
    """Return the verdict, then every table and what is missing, for a terminal (ASCII)."""
    parts = [f"{headline(found)}\n{found.why}", gap_line(found)]
    parts += effect_lines(found)
    if found.next_experiment:
        parts.append(f"next experiment: {found.next_experiment}")
    parts += ["\n".join(aligned(table)) for table in tables(found)]
    parts += ["\n".join(lines) for lines in (caveats(found), found.notes) if lines]
    text = "\n\n".join(part for part in parts if part)
    for sign, plainly in {"−": "-", "–": "-", "±": "+-", "…": "..."}.items():
        text = text.replace(sign, plainly)
    return text


def headline(found: Diagnosis) -> str:
    """Return the verdict in one sentence, with the effects' coefficients or the set."""
    told = "; ".join(effect_words(one) for one in found.effects)
    names = " or ".join(one.name for one in found.alternatives)
    if found.verdict == "named":
        also = f" Further {names}: these data can't tell which." if names else ""
        rest = f" A rest stays in {_list(found.rest)}." if found.rest else ""
        return f"named: {told}.{also}{rest}"
    also = f" Beside {told}." if told else ""
    if found.verdict == "ambiguous":
        return f"ambiguous: {names}; these data can't tell which.{also}"
    if found.verdict == "unknown" and not found.where:
        return "unknown: these data are too few for a verdict."
    if found.verdict == "unknown":
        where = _list(found.rest or found.where[:1])
        return f"unknown: no effect of the catalogue explains what disagrees in {where}.{also}"
    agrees = "the model agrees with the measurement as well as the bench repeats itself"
    if {one.name for one in found.where} < BALANCES.keys():
        return f"none: in the balances that these channels tell, {agrees}."
    return f"none: {agrees}."


def gap_line(found: Diagnosis) -> str:
    """Return the gap of all balances over the held-out runs, from the model as given on.

    Empty where nothing was compared.
    """
    total = found.gap_heldout.total
    if not found.gap_heldout.balances:
        return ""
    steps = ", ".join(
        f"{number(getattr(total, step), 2)} {words}" for step, words in steps_of(found).items()
    )
    return f"Gap of held-out runs, all balances: {steps}. {_UNIT_OF_GAP}"


def effect_words(effect: AddedEffect) -> str:
    """Return an effect's name with its coefficients and their intervals.

    Those at a bound are left out where others are not.
    """
    free = {name: p for name, p in effect.parameters.items() if not p.at_bound}
    told = free or effect.parameters
    each = ", ".join(f"{name} {quantity(p)}" for name, p in told.items())
    return f"{effect.name} ({each})"


def tables(found: Diagnosis) -> tuple[WordTable, ...]:
    """Return the tables that have rows, in the order of what a reader asks."""
    every = (
        effects_table(found),
        alternatives_table(found),
        where_table(found),
        *gap_tables(found, found.gap_heldout, "held-out runs"),
        run_table(found, _FEW),
        ranking_table(found, _FEW),
        refitted_table(found),
    )
    return tuple(table for table in every if table.rows)


def effect_lines(found: Diagnosis) -> tuple[str, ...]:
    """Return for each effect whether it is the plant's or a sensor's, its law and its form."""
    return tuple(
        f"{one.name} ({'sensor' if one.of_sensor else 'plant'}): {one.says}; "
        f"form: {one.shape or 'the textbook one'}."
        for one in found.effects
    )


def effects_table(found: Diagnosis) -> WordTable:
    """Return a row for each coefficient, with what adding its effect did to held-out runs."""
    rows = []
    for one in found.effects:
        rival = f"{one.runner_up.name}, {short(one.runner_up.margin)}" if one.runner_up else NONE
        own = (number(one.gap_before, 2), number(one.gap_after, 2), short(one.score), rival)
        for i, (name, p) in enumerate(one.parameters.items()):
            effect, cells = ("", ("",) * len(own)) if i else (one.name, own)
            rows.append((effect, name, quantity(p), *cells))
    head = ("effect", "coefficient", "value with 95 % interval", "gap before", "after")
    return WordTable(
        "Effects that were added; gaps of held-out runs in the balances they touch",
        (*head, "score nats", "next, below by nats"),
        tuple(rows),
    )


def alternatives_table(found: Diagnosis) -> WordTable:
    """Return the ambiguous set."""
    return WordTable(
        "Effects that these data can't tell apart", _RANK_HEAD, _ranked(found.alternatives)
    )


def where_table(found: Diagnosis) -> WordTable:
    """Return the balances of the refitted model, the worst first."""
    rows = tuple(
        (
            balance(one.name).says,
            number(one.gap, 2),
            number(one.structured, 2),
            p_words(one.p_value),
            scatter_words(one),
            str(one.windows),
        )
        for one in found.where
    )
    head = ("balance", "gap", "structured", "p (Holm)", "trial scatter", "windows")
    return WordTable("Where the refitted model disagrees", head, rows)


def edges_table(found: Diagnosis) -> WordTable:
    """Return the gap of each chamber's flow by the edge of its valve that meters it."""
    ways = {one.label: one for one in found.regions if one.axis == "direction"}
    rows = []
    for name, edges in EDGES.items():
        by_edge = dict(zip(edges, ("extend", "retract"), strict=True))
        cells = []
        for edge in ("supply", "tank"):
            gaps = ways[by_edge[edge]].gaps if by_edge[edge] in ways else {}
            cells.append(number(gaps.get(name), 2))
        rows.append((balance(name).says, *cells))
    known = any(cell != NONE for _, *cells in rows for cell in cells)
    head = ("chamber", "open to supply", "open to tank")
    return WordTable("Gap by metering edge", head, tuple(rows) if known else ())


def gap_tables(found: Diagnosis, table: GapTable, of: str) -> tuple[WordTable, ...]:
    """Return the gaps of some runs: balances with their total, signals in closed and open loop."""
    steps = steps_of(found)

    def rows(of: Mapping[str, BeforeAfter], words: Callable[[str], Words]) -> Rows:
        return tuple(
            (words(name).says, *(number(getattr(one, step), 2) for step in steps))
            for name, one in of.items()
        )

    parts = (
        ("balance", "balances", with_total(table), balance),
        ("signal", "signals, closed loop", table.signals, signal),
        ("signal", "signals, open loop", table.open_loop, signal),
    )
    return tuple(
        WordTable(f"Gap of {of}: {title}", (kind, *steps.values()), rows(values, words))
        for kind, title, values, words in parts
        if values
    )


def with_total(table: GapTable) -> dict[str, BeforeAfter]:
    """Return the balances' gaps after that of all; empty where nothing was compared."""
    return {"all": table.total, **table.balances} if table.balances else {}


_FEW = 8  # candidates, and runs, that a terminal is shown
_RANK_HEAD = ("candidate", "score nats", "must exceed", "explains", "size", "tried")


def ranking_table(found: Diagnosis, most: int | None = None) -> WordTable:
    """Return the candidates of the first search, the best first; at ``most`` some of them."""
    chosen = found.ranking[:most]
    title = "Candidates of the first search"
    if len(chosen) < len(found.ranking):
        title += f" (the best {len(chosen)} of {len(found.ranking)})"
    return WordTable(title, _RANK_HEAD, _ranked(chosen))


def refitted_table(found: Diagnosis) -> WordTable:
    """Return the factors on the model's badly tuned values."""
    rows = tuple((path, quantity(p)) for path, p in found.refitted.items())
    head = ("value of the model", "refitted by the factor (95 % interval)")
    return WordTable("Refitted before the search", head, rows)


def caveats(found: Diagnosis) -> tuple[str, ...]:
    """Return what the data lacks, what was not tried and what took no part, a sentence each."""
    lines = [f"missing for a better verdict: {one}" for one in found.missing]
    for reason in dict.fromkeys(found.not_tried.values()):
        names = ", ".join(name for name, own in found.not_tried.items() if own == reason)
        lines.append(f"not tried ({reason}): {names}")
    if found.left_out:
        lines.append(f"runs left out: {len(found.left_out)}")
        lines += [f"  {line}" for line in found.left_out]
    return tuple(lines)


def p_words(value: float) -> str:
    """Write a p-value."""
    return "< 0.001" if value < 1e-3 else number(value, 3)


def _ranked(candidates: tuple[Candidate, ...]) -> Rows:
    return tuple(
        (
            one.name,
            number(one.score + 0.0, 1),
            number(one.threshold, 1),
            share(one.explained),
            f"{number(one.size, 2)} x typical",
            "simulated" if one.tried == "simulated" else "by its signature",
        )
        for one in candidates
    )


def _list(gaps: tuple[Gap, ...]) -> str:
    return ", ".join(balance(one.name).says for one in gaps)
