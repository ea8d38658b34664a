"""Page of the catalogue for users, generated from its rows.

python -m hbench.model.effects.guide > hbench/model/effects/README.md
"""

from collections.abc import Iterator, Mapping

from hbench.config.effects import Coefficient
from hbench.model.effects.catalogue import EFFECTS, lookalikes
from hbench.model.effects.rows import Effect

_HEAD = """\
# Physical effects

Effects that a plant can have and that `hbench reconcile` looks for. The page is generated from the
rows of the catalogue: `python -m hbench.model.effects.guide > hbench/model/effects/README.md`. To
simulate an effect, name it in a bench or plant file
([configs](../../../configs/README.md#physical-effects)); an effect that is not named is off.

The typical size is that of a clear effect in a campaign. A coefficient without one only changes the
shape of the law; its default is the textbook's. Balances are those of `hbench reconcile`
([method](../../reconcile/README.md)).
"""


def guide(effects: Mapping[str, Effect]) -> str:
    """Return the page in Markdown."""
    rows = [f"| [{name}](#{name}) | {row.description} |" for name, row in effects.items()]
    overview = ["| effect | what it is |", "|---|---|", *rows]
    parts = [_HEAD, "\n".join(overview) + "\n"]
    parts += ["\n\n".join(_blocks(name, effects)) + "\n" for name in effects]
    return "\n".join(parts)


def _blocks(name: str, effects: Mapping[str, Effect]) -> Iterator[str]:
    row = effects[name]
    yield f"## {name}"
    yield f"{row.description[:1].upper()}{row.description[1:]}."
    balances = ", ".join(f"`{balance}`" for balance in row.balances)
    facts = {
        "Kind": "error of the instruments" if row.of_sensor else "effect of the plant",
        "Law": f"`{row.law}`" if row.law else "",
        "Signals": row.signals,
        "Balances": balances or "none: `hbench reconcile` does not look for it",
        "Inspect": row.inspect,
        "Repair": row.repair,
        "Source": row.source,
    }
    yield "\n".join(f"- {title}: {text}" for title, text in facts.items() if text)
    yield _table(
        ("coefficient", "unit", "typical", "lowest", "highest", "default"),
        _coefficients(row.coefficients),
    )
    separations = lookalikes(name, effects)
    if separations:
        rows = ((f"[{other}](#{other})", f"`{s.kind}`", s.why) for other, s in separations.items())
        yield _table(("confused with", "run that separates them", "why"), rows)


def _coefficients(coefficients: Mapping[str, Coefficient]) -> Iterator[tuple[str, ...]]:
    """Yield a row for each distinct coefficient, with the names of all that are like it."""
    for each in dict.fromkeys(coefficients.values()):
        names = ", ".join(name for name, other in coefficients.items() if other == each)
        typical = f"{each.typical:g}" if each.typical else "–"
        yield names, each.unit, typical, f"{each.low:g}", f"{each.high:g}", f"{each.default:g}"


def _table(head: tuple[str, ...], rows: Iterator[tuple[str, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


if __name__ == "__main__":
    print(guide(EFFECTS), end="")
