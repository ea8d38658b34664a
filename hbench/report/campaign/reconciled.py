"""Section of the campaign's report on the results of ``hbench reconcile``.

The content of ``diagnosis.json`` is untrusted: values of an unexpected type are left out.
"""

import math
from collections.abc import Iterator
from typing import Any

from hbench.records import WordTable
from hbench.report.render.document import Section
from hbench.report.render.numbers import number, significant

_GAPS = (
    "Gaps of runs outside the fit: root mean square of measurement less model, in multiples of the "
    "repeatability of the bench. Before: the model as given; after: refitted and with the effects "
    "added; expected: average of correct models with parameters as uncertain, of flows and forces "
    "only."
)
_HEAD = ("Of", "Name", "Before", "After", "Expected")
_PARTS = {
    "signals": "signal, closed loop",
    "balances": "flow or force",
    "open_loop": "signal, open loop",
}


def reconciled_section(folder: str, content: dict[str, Any] | str) -> Section:
    """Return the section of the diagnosis in ``folder``, or the reason why there is none."""
    title = f"Model against measurement ({folder})"
    if isinstance(content, str):
        return Section(title, (f"The diagnosis cannot be read. {content}",))
    held = _mapping(_mapping(content.get("gap")).get("heldout"))
    rows = [*_row("all", "flows and forces together", held)]
    for part, part_title in _PARTS.items():
        for name, gaps in _mapping(held.get(part)).items():
            known = _mapping(gaps)
            if part != "balances":  # nothing is expected of a signal
                known = {step: gap for step, gap in known.items() if step != "floor"}
            rows += _row(part_title, str(name), known)
    verdict = f"Verdict: {_text(content.get('verdict'))}. {_text(content.get('why'))}".strip()
    next_ = _text(content.get("next_experiment"))
    return Section(
        title,
        (
            verdict,
            *_effects(content),
            *([f"Next experiment: {next_}"] if next_ else []),
            *([_GAPS] if rows else []),
            f"The folder {folder} of the campaign has its own report.",
        ),
        tables=(WordTable("The gap before and after", _HEAD, tuple(rows)),) if rows else (),
    )


def _effects(content: dict[str, Any]) -> Iterator[str]:
    effects = content.get("effects")
    for effect in effects if isinstance(effects, list) else ():
        effect = _mapping(effect)
        values = []
        for name, parameter in _mapping(effect.get("parameters")).items():
            parameter = _mapping(parameter)
            values.append(
                f"{name} = {significant(_number(parameter.get('value')), 3)} {_interval(parameter)}"
            )
        coefficients = ", ".join(values)
        before, after = (_number(effect.get(key)) for key in ("gap_before", "gap_after"))
        name = _text(effect.get("name")).replace("_", " ")
        rises = before is not None and after is not None and after >= before
        change = (
            "is not reduced; runs outside the fit do not confirm it:" if rises else "falls from"
        )
        ends = f"{number(before, 2)} to {number(after, 2)}"
        yield f"Effect {name}: {coefficients}; its gap {change} {ends}."


def _interval(value: dict[str, Any]) -> str:
    unit, ends = _text(value.get("unit")), value.get("ci95")
    if not isinstance(ends, list) or len(ends) != 2:
        return unit
    low, high = (significant(_number(end), 3) for end in ends)
    return f"{unit} (95 %: {low} to {high})".strip()


def _row(of: str, name: str, gaps: Any) -> Iterator[tuple[str, ...]]:
    values = [_number(_mapping(gaps).get(key)) for key in ("before", "after", "floor")]
    if any(value is not None for value in values):
        yield (of, name, *(number(value, 2) for value in values))


def _mapping(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _text(value: Any) -> str:
    return value if isinstance(value, str) else ""


def _number(value: Any) -> float | None:
    if not isinstance(value, int | float) or isinstance(value, bool):
        return None
    try:
        return float(value) if math.isfinite(value) else None
    except OverflowError:  # an integer beyond all floats
        return None
