"""Tables of gaps: by balance, by metering edge, and of runs."""

from collections.abc import Callable, Mapping, Sequence

from hbench.records import BeforeAfter, Diagnosis, Gap, GapTable, WordTable
from hbench.report.diagnosis.names import (
    EDGES,
    DisplayName,
    also_words,
    balance,
    compared_model,
    deviation_and_limit,
    gap_number,
    in_unit,
    models_of,
    of_strokes,
    signal,
    steps_of,
)
from hbench.report.diagnosis.words.place import edge_gaps
from hbench.report.render.numbers import NONE, number, p_words, significant
from hbench.report.render.word_tables import with_columns

_ERRORS = {"force": "force along the motion", "position": "open-loop position"}


def errors_table(diagnosis: Diagnosis) -> WordTable:
    """Return the errors of held-out runs of a driven mass."""
    steps = models_of(diagnosis)
    rows = tuple(
        (
            f"{_ERRORS[error.quantity]} ({error.unit})",
            *(significant(getattr(error, step), 3) for step in steps),
        )
        for error in diagnosis.errors
    )
    title = "Root mean square errors of runs outside the fit"
    return WordTable(title, ("error", *steps.values()), rows)


def loads_table(diagnosis: Diagnosis) -> WordTable:
    """Return the force errors of the models of strokes at each held-out load."""
    loads = diagnosis.held_out_loads
    steps = models_of(diagnosis)
    also = [name for load in loads[:1] for name in load.also]
    head = ("load", *steps.values(), *(also_words(diagnosis, name) for name in also))
    rows = tuple(
        (
            f"{number(load.load_n, 0)} N",
            *(f"{significant(getattr(load, step), 2)} N" for step in steps),
            *(f"{significant(load.also[name], 2)} N" for name in also),
        )
        for load in loads
    )
    return WordTable("Root mean square force error at each load outside the fit", head, rows)


def where_table(diagnosis: Diagnosis) -> WordTable:
    """Return the balances of the model before any effect, the worst first."""
    title = f"Deviations of the {compared_model(diagnosis)}, all runs"
    return _gaps_table(diagnosis, title, diagnosis.where)


def rest_table(diagnosis: Diagnosis) -> WordTable:
    """Return the deviations that remain with the effects; no rows without effects."""
    gaps = diagnosis.rest if diagnosis.confirmed else ()
    return _gaps_table(diagnosis, "Deviations that remain with the effects, all runs", gaps)


def _gaps_table(diagnosis: Diagnosis, title: str, gaps: Sequence[Gap]) -> WordTable:
    """Return a row for each gap; of strokes, whose scatter is tiny at some loads, in newtons."""
    in_scatters = not of_strokes(diagnosis)
    rows = tuple(
        (
            balance(gap.name).title,
            deviation if gap.deviation else NONE,
            limit,
            p_words(gap.p_value),
            in_unit(gap, gap.scatter),
            gap_number(gap.gap) if in_scatters else NONE,
            in_unit(gap, gap.allowed) if gap.allowed else NONE,
            NONE if in_scatters else str(gap.windows),  # as many windows in all rows, about
        )
        for gap in gaps
        for deviation, limit in [deviation_and_limit(gap)]
    )
    of_deviation = ("deviation", "matters above", "p (Holm)")
    head = (
        "quantity",
        *of_deviation,
        "repeatability",
        "gap, all runs",
        "tolerances allow without refit",
        "loads",
    )
    known_columns = head if of_strokes(diagnosis) else head[:-1]
    kept = [i for i in range(len(known_columns)) if any(row[i] != NONE for row in rows)]
    return with_columns(WordTable(title, head, tuple(rows)), kept)


def edges_table(diagnosis: Diagnosis) -> WordTable:
    """Return the gap of each chamber's flow by the edge of its valve that meters it."""
    rows = []
    for name in EDGES:
        gaps = edge_gaps(diagnosis, name)
        cells = [gap_number(gaps.get(edge)) for edge in ("supply", "tank")]
        if any(cell != NONE for cell in cells):
            rows.append((balance(name).title, *cells))
    head = ("chamber", "open to supply", "open to tank")
    title = f"Gap by metering edge, {compared_model(diagnosis)}, all runs"
    return WordTable(title, head, tuple(rows))


def gap_tables(diagnosis: Diagnosis, table: GapTable, of: str) -> tuple[WordTable, ...]:
    """Return the gaps of some runs: balances with their total, signals in closed and open loop."""

    def table_of(
        kind: str,
        title: str,
        gaps: Mapping[str, BeforeAfter],
        display_name: Callable[[str], DisplayName],
    ) -> WordTable:
        steps = (steps_of if kind == "quantity" else models_of)(diagnosis)
        rows = tuple(
            (display_name(name).title, *(gap_number(getattr(gap, step)) for step in steps))
            for name, gap in gaps.items()
        )
        return WordTable(f"Gap of {of}: {title}", (kind, *steps.values()), rows)

    forces = "forces" if of_strokes(diagnosis) else "flows and forces"
    groups = (
        ("quantity", forces, with_total(table), balance),
        ("signal", "signals, closed loop", table.signals, signal),
        ("signal", "signals, open loop", table.open_loop, signal),
    )
    return tuple(table_of(*group) for group in groups if group[2])


def with_total(table: GapTable) -> dict[str, BeforeAfter]:
    """Return the balances' gaps, after that of all if there are several."""
    return {"all": table.total, **table.balances} if len(table.balances) > 1 else table.balances
