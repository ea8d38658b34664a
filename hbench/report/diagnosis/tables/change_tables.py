"""Tables of what effects change at the bench."""

from hbench.records import Diagnosis, EffectInPractice, WordTable
from hbench.report.diagnosis.names import in_words, quantity
from hbench.report.diagnosis.words.change import (
    CYLINDERS,
    FLOWS,
    INERTIA,
    alternatives,
    changes_of,
    interval,
    wrong_readings,
)
from hbench.report.render.numbers import significant


def changes_tables(diagnosis: Diagnosis) -> tuple[WordTable, ...]:
    """Return what each effect changes, at the working point and along the logs."""
    head = ("quantity", "at the working point", "along the logs (RMS)", "up to (95 %)")
    return tuple(
        WordTable(
            f"What {in_words(effect.name)} changes",
            head,
            tuple(
                (
                    _row_of(effect, change.quantity),
                    interval(change),
                    f"{significant(change.along, 2)} {change.unit}",
                    f"{significant(change.largest, 2)} {change.unit}",
                )
                for change in changes_of(effect)
            ),
        )
        for effect in diagnosis.practice
    )


def candidates_table(diagnosis: Diagnosis) -> WordTable:
    """Return what each effect of the ambiguous set would change, and by how much they differ.

    Of two sets one effect each is missing: their sizes are not compared.
    """
    chosen, one_set = alternatives(diagnosis), len(diagnosis.alternative_sets) == 1
    by_name = [{change.quantity: change for change in changes_of(effect)} for effect in chosen]
    computed = all(map(wrong_readings, chosen))
    rows = []
    for name in dict.fromkeys(name for changes in by_name for name in changes):
        known = [changes.get(name) for changes in by_name]
        unit = next(change.unit for change in known if change)
        values = [change.at_point if change else 0.0 for change in known]
        differs = [f"{significant(max(values) - min(values), 2)} {unit}"] if one_set else []
        row = _row(name, computed=computed)
        rows.append((row, *(interval(c) if c else f"0 {unit}" for c in known), *differs))
    last = ["they differ by"] if one_set else []
    head = ("at the working point", *(in_words(effect.name) for effect in chosen), *last)
    title = "What each of these effects would change"
    return WordTable(title, head, tuple(rows) if len(chosen) > 1 else ())


def _row_of(effect: EffectInPractice, name: str) -> str:
    """Return the title of a quantity that one effect changes; a mass has no friction."""
    title = _row(name, computed=bool(wrong_readings(effect)))
    return title.replace("friction", "inertial force") if effect.name == INERTIA else title


def _row(name: str, *, computed: bool) -> str:
    """Return the title of a quantity in a table; a wrong reading changes what is computed."""
    of_model = computed and (name in FLOWS or name in CYLINDERS)
    return f"{'computed ' if of_model else ''}{quantity(name)}"
