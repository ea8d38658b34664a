"""Direction, load and kind of a series of runs in words, and the label that all runs share."""

from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeAlias, TypeVar

from hbench.records import (
    DIRECTION_WORDS,
    KINDS,
    Curve,
    EfficiencyCurve,
    HeadlineSeries,
    ImplausiblePoint,
    PointTrials,
    Results,
    RunPlan,
)
from hbench.report.render.numbers import force, short
from hbench.units import from_si

AnySeries: TypeAlias = (
    Curve | EfficiencyCurve | HeadlineSeries | ImplausiblePoint | PointTrials | RunPlan
)

Record = TypeVar("Record")

TITLES = {direction: words.capitalize() for direction, words in DIRECTION_WORDS.items()}


def within_title(name: str) -> str:
    """Write a figure's name within its title: the direction in lower case, a label as it is."""
    for direction, title in TITLES.items():
        name = name.replace(title, DIRECTION_WORDS[direction])
    return name


def load_words(f_load_n: float | None, p_lr_ref_pa: float | None) -> str:
    """Write the references of the load cylinder, such as ``500 N, 15 bar``; empty without any."""
    references = [] if f_load_n is None else [force(f_load_n)]
    if p_lr_ref_pa is not None:
        references.append(f"{short(from_si(p_lr_ref_pa, 'bar'))} bar")
    return ", ".join(references)


def kind_words(series: AnySeries) -> str:
    """Write a kind of experiment, such as ``ramp 0.1 m/s²``; empty for steady runs."""
    kind = KINDS[series.kind]
    if kind.is_ramp and series.a_ref_m_s2 is not None:
        return f"{kind.display_name} {short(series.a_ref_m_s2)} m/s²"
    return "" if kind.has_constant_speed else kind.display_name


def common_label(results: Results) -> str:
    """Return the label of all runs; empty if they have none, or several."""
    labels = {run.run.plan.label for run in results.runs}
    return labels.pop() if len(labels) == 1 else ""


def without_common_label(results: Results) -> Results:
    """Return the results with an empty label in every record, if all runs share one."""
    return _without_label(results) if common_label(results) else results


def _without_label(value: Record) -> Record:
    changed: Any = value
    if is_dataclass(value) and not isinstance(value, type):
        old = {field.name: getattr(value, field.name) for field in fields(value) if field.init}
        new = {name: "" if name == "label" else _without_label(old[name]) for name in old}
        if any(new[name] is not old[name] for name in old):
            changed = replace(value, **new)
    elif isinstance(value, tuple) and type(value) is tuple:
        entries = tuple(_without_label(entry) for entry in value)
        if any(entry is not value[i] for i, entry in enumerate(entries)):
            changed = entries
    return changed
