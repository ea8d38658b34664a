"""Repeatability and reproducibility of a fleet whose campaigns form a plan.

A plan is crossed, nested or unbalanced: cylinders that were measured more than once, by several
operators, in several mountings or on several days. Mountings are nested in cylinders. What varies
in the plan and is not the cylinder counts as reproducibility:

    s_r^2 = s_trials^2,   s_R^2 = s_r^2 + sum of the variances of all factors but the cylinder

(ISO 5725-2, 7.4.5, with one factor; ISO 5725-3, 8 and 9, with several). In the terms of the AIAG's
Measurement Systems Analysis, s_r is the equipment variation and s_R the GRR.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hbench.analysis.fleet.variance_components import (
    REPEATS,
    Component,
    PlanData,
    Separated,
    VarianceComponents,
    anova,
    numbered,
    separated,
)
from hbench.records import CYLINDER, Estimate, Precision, Quantity, Side, VarianceSource
from hbench.sentences import counted

_FEWEST = 2  # campaigns of the plan beyond one of each cylinder
_MOST = 150  # campaigns; the time rises with the third power of their number
_KEYS = {
    CYLINDER: "specimen.serial",
    "operator": "test.operator",
    "mounting": "test.mounting",
    "day": "test.date",
}
_CROSSED = "cylinder × operator"
_CAMPAIGN = "campaign"


class Tolerance(NamedTuple):
    """Width between the limits of a number, in SI, for the numbers of one unit."""

    value: float
    unit: str  # of these numbers


@dataclass(frozen=True)
class Plan:
    """Levels of each factor over the campaigns; none where they form no plan."""

    rows: np.ndarray  # (n,) of the table
    levels: dict[str, np.ndarray]  # factor -> (n,)
    notes: tuple[str, ...]  # why there is no plan, or what it can't show


def plan_of(rows: np.ndarray, identities: dict[str, list[str]]) -> Plan:
    """Return the plan of the campaigns in ``rows`` (n,).

    ``identities`` are the texts (n,) of cylinder, operator, mounting and day; empty if not stated.
    """
    cylinders = identities[CYLINDER]
    stated = np.array([bool(name) for name in cylinders], dtype=bool)
    if not stated.any():
        return _no_plan(
            "The campaigns do not state which cylinder they measured: set its serial number "
            f"({_KEYS[CYLINDER]})."
        )
    notes = []
    if not stated.all():
        notes.append(
            f"{counted(int((~stated).sum()), 'campaign')} without {_KEYS[CYLINDER]} left out."
        )
    texts = {name: np.array(each, dtype=object)[stated] for name, each in identities.items()}
    rows = rows[stated]
    count, kinds = len(rows), len(set(texts[CYLINDER]))
    if count - kinds < _FEWEST:
        each = "The cylinder was" if kinds == 1 else f"Each of the {kinds} cylinders was"
        measured = f"{each} measured once" if count == kinds else "One cylinder was measured twice"
        return _no_plan(
            f"{measured}: at least {_FEWEST} repeated campaigns of a cylinder are "
            "needed, re-mounted, by another operator or on another day.",
            *notes,
        )
    if count > _MOST:
        return _no_plan(
            f"{count} campaigns; limit {_MOST}. Analyze those of the plan in a separate call."
        )
    levels: dict[str, Sequence[object]] = {}
    unstated, fixed = [], []
    for name, key in _KEYS.items():
        known = [bool(text) for text in texts[name]]
        if not any(known):
            unstated.append(f"{name} ({key})")
        elif not all(known):
            notes.append(
                f"The {name} is not part of the plan: {known.count(False)} of {count} campaigns do "
                f"not state {key}."
            )
        elif len(set(texts[name])) == 1:
            fixed.append(name)
        else:
            nested = name == "mounting"
            levels[name] = _together(texts[CYLINDER], texts[name]) if nested else texts[name]
    if unstated:
        notes.append(f"Not stated: {', '.join(unstated)}.")
    if fixed:
        notes.append(f"Not varied: {', '.join(fixed)}.")
    if CYLINDER in levels and "operator" in levels:
        levels[_CROSSED] = _together(texts[CYLINDER], texts["operator"])
    levels[_CAMPAIGN] = range(count)
    return Plan(rows, {name: numbered(each) for name, each in levels.items()}, tuple(notes))


def precision_of(
    quantity: Quantity, direction: Side, plan: Plan, columns: np.ndarray, tolerance: float | None
) -> tuple[Precision | None, tuple[str, ...]]:
    """Return the precision of one number, None if it is not known, and notes on the plan.

    ``columns`` (4, n) are the plan's campaigns' value, standard error, trials and degrees of
    freedom.
    """
    known = np.isfinite(columns[0])
    x, se, trials, dof = columns[:, known]
    repeated = np.isfinite(se) & np.isfinite(trials) & (np.nan_to_num(dof) > 0)
    data = PlanData(
        means=x,
        trials=np.where(repeated, trials, 1.0),
        scatter=float(np.sum(dof[repeated] * trials[repeated] * se[repeated] ** 2)),
        dof=float(dof[repeated].sum()),
        levels={name: levels[known] for name, levels in plan.levels.items()},
    )
    cylinders = data.levels.get(CYLINDER, np.zeros(len(x), dtype=int))
    kinds = len(np.unique(cylinders))
    if len(x) - kinds < _FEWEST or _constant(data):
        return None, ()
    found = separated(data)
    data = replace(data, levels=found.levels)
    fit = VarianceComponents(data)
    by_anova = anova(data)
    measurement = [name for name in fit.names if name != CYLINDER]
    sources = tuple(
        VarianceSource(
            name,
            round(data.dof) if name == REPEATS else len(np.unique(data.levels[name])),
            _estimate(fit.component([name])),
            by_anova[name],
        )
        for name in fit.names
    )
    precision = Precision(
        quantity=quantity,
        direction=direction,
        campaigns=len(x),
        cylinders=kinds,
        trials=float(1 / np.mean(1 / data.trials)),
        mean=float(x.mean()),
        sources=sources,
        repeatability=_root(fit.component([REPEATS])),
        reproducibility=_root(fit.component(measurement)),
        share_of_total=_root(fit.share(measurement)) if CYLINDER in fit.names else None,
        tolerance=tolerance,
    )
    return precision, tuple(_notes(found, quantity.words if data.dof == 0 else ""))


def _notes(found: Separated, without_trials: str) -> Iterator[str]:
    """Yield what the plan can't separate; the rest of a campaign may be that of another factor.

    ``without_trials`` is the number that has no repeated trials in any campaign.
    """
    where = f"{without_trials}: the" if without_trials else "The"
    for name, other in found.merged:
        if name != _CAMPAIGN:
            yield f"{where} plan cannot separate {name} from {other}, with which it changes."
    for name in found.dependent:
        if name != _CAMPAIGN:
            yield f"{where} plan cannot separate {name} from the other factors."


def _constant(data: PlanData) -> bool:
    """Whether nothing varies by more than rounding."""
    size = float(np.abs(data.means).max())
    return float(np.ptp(data.means)) + math.sqrt(data.scatter) <= 1e-9 * size


def _together(a: np.ndarray, b: np.ndarray) -> list[tuple[str, str]]:
    return list(zip(a.tolist(), b.tolist(), strict=True))


def _no_plan(*notes: str) -> Plan:
    return Plan(np.zeros(0, dtype=int), {}, notes)


def _estimate(component: Component) -> Estimate:
    value, low, high = component
    return Estimate(value, low, high if math.isfinite(high) else None)


def _root(component: Component) -> Estimate:
    return _estimate(Component(*map(math.sqrt, component)))
