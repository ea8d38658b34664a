"""The revised model as a file, with the origin of each number, and the next schedule."""

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import yaml

from hbench.records import AddedEffect, Diagnosis
from hbench.report.diagnosis.sentences import gap_change
from hbench.report.diagnosis.text import gap_line
from hbench.report.diagnosis.words.coefficient import coefficient_text, effect_words, parameter_text
from hbench.report.diagnosis.words.error import errors_in_words, one_sided_words

_SOURCES = {
    "simulated": "SIMULATED: not valid for a real bench",
    "real": "measured on a bench",
    "imported": "measured elsewhere and imported",
}
_USE = "Give it to `hbench run --plant`, or to `hbench simulate` or `reconcile` as --model."
_USE_ELSEWHERE = "Give it to `hbench reconcile` as --model."  # the bench has no board of hbench
_TOLERATED = "within a bench's tolerances: fitted with the values of the model"
_WIDE = 96
_COLUMN = 44  # where a comment beside a value begins


def revised_yaml(diagnosis: Diagnosis) -> str:
    """Return the text of ``model.yaml``: ``found.revised`` with comments."""
    provenance = diagnosis.provenance
    lines = [
        f"{diagnosis.model}, revised by `hbench reconcile` after campaign {provenance.name!r} of "
        f"{provenance.started[:10]} (bench {provenance.bench!r}), {_SOURCES[provenance.source]}.",
        _USE if diagnosis.provenance.firmware else _USE_ELSEWHERE,
        f"Verdict: {diagnosis.verdict}. {diagnosis.why}",
        *(
            f"Not in this model: {effect_words(effect)}. {gap_change(effect)}"
            for effect in diagnosis.effects
            if not effect.confirmed
        ),
        gap_line(diagnosis),
        errors_in_words(diagnosis),
        one_sided_words(diagnosis),
        "Values with 95 % intervals; values without a comment are those of the model.",
    ]
    body = "".join(_lines(diagnosis.revised, _comments(diagnosis), ()))
    return f"{_head(lines)}\n{body}"


def schedule_yaml(diagnosis: Diagnosis) -> str:
    """Return the text of ``next.yaml``, the schedule that would distinguish the alternatives."""
    lines = [f"Made by `hbench reconcile` after campaign {diagnosis.provenance.name!r}."]
    return _head([*lines, diagnosis.next_experiment or ""]) + _dump(diagnosis.next_schedule)


def _head(lines: Sequence[str]) -> str:
    wrapped = (part for line in lines for part in textwrap.wrap(line, _WIDE))
    return "".join(f"# {part}\n" for part in wrapped)


def _comments(diagnosis: Diagnosis) -> dict[tuple[str, ...], str]:
    """Return the comments of the values, by their paths."""
    comments = {
        tuple(path.split(".")): f"refitted: the model's times {parameter_text(factor)}"
        for path, factor in diagnosis.refitted.items()
    }
    if diagnosis.unnamed:
        comments["learned",] = "unnamed: tables fitted to what no effect of the catalogue explains"
    for name in diagnosis.within_tolerance:
        comments["effects", name] = _TOLERATED
    for effect in diagnosis.confirmed:
        comments["effects", effect.name] = _law(effect)
        for name in effect.parameters:
            comments["effects", effect.name, name] = f"found: {coefficient_text(effect, name)}"
    return comments


def _law(effect: AddedEffect) -> str:
    origin = "an error of a sensor: " if effect.of_sensor else ""
    form = f"; form: {effect.shape}" if effect.shape else ""
    return f"{origin}{effect.description}{form}"


def _lines(
    values: Mapping[str, Any], comments: Mapping[tuple[str, ...], str], above: tuple[str, ...]
) -> Iterator[str]:
    """Yield a mapping's lines, with the comment of a section above it and of a value beside it."""
    indent = "  " * len(above)
    for key, value in values.items():
        path = (*above, key)
        comment = " ".join(comments.get(path, "").split())
        name = _dump(key).strip()
        if isinstance(value, Mapping) and value:
            if comment:
                yield f"{indent}# {comment}\n"
            yield f"{indent}{name}:\n"
            yield from _lines(value, comments, path)
        elif value and isinstance(value, list) and isinstance(value[0], Mapping):
            yield f"{indent}# {comment}\n{indent}{name}:\n" if comment else f"{indent}{name}:\n"
            yield from (f"{indent}  - {_flow(each)}\n" for each in value)
        else:
            line = f"{indent}{name}: {_dump(value)}"
            yield f"{line:{_COLUMN}}# {comment}\n" if comment else f"{line}\n"


def _dump(value: Any) -> str:
    """Write a value on one line as YAML; a mapping in as many as it takes."""
    if isinstance(value, Mapping) and value:
        return yaml.safe_dump(dict(value), sort_keys=False, allow_unicode=True)
    return _flow(value)


def _flow(value: Any) -> str:
    """Write a value on one line as YAML."""
    text = yaml.safe_dump(
        value, default_flow_style=True, allow_unicode=True, width=2**30, sort_keys=False
    )
    return text.removesuffix("...\n").strip()
