"""A fitted effect: the model without it, and what follows from its coefficients."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from hbench.analysis.statistics.student import student_factor
from hbench.model.effects.catalogue import EFFECTS, lookalikes
from hbench.reconcile.estimates import ParameterEstimates, whole_dof
from hbench.reconcile.hypothesis import Hypothesis, stepped
from hbench.reconcile.nuisance import nuisances
from hbench.records import Change, EffectInPractice, Lookalike

_LARGEST = 0.95  # quantile of the magnitudes that counts as the largest
_STEP = 0.05  # of a typical size, for derivatives by the coefficients


def without_effect(hypothesis: Hypothesis, name: str) -> Hypothesis:
    """Return a hypothesis with the effect's coefficients at their defaults."""
    rows = EFFECTS[name].coefficients.items()
    neutral = {key: row.to_si(row.default) for key, row in rows}
    return replace(hypothesis, effects={**hypothesis.effects, name: neutral})


def half_widths(
    plant: Any,
    estimates: ParameterEstimates,
    name: str,
    evaluate: Callable[[Hypothesis], Mapping[str, float]],
) -> dict[str, float]:
    """Return the half widths of the 95 % intervals: sqrt(g' C g) times Student's factor.

    g are derivatives of what ``evaluate`` returns by the effect's coefficients that are not at a
    bound, C is their covariance. nan where all are at their bounds.
    """
    fitted = estimates.hypothesis
    before = evaluate(fitted)
    free = [key for key, p in estimates.of_effect(name).items() if p.at_bound is None]
    if not free:
        return dict.fromkeys(before, float("nan"))
    places = [estimates.chosen.index(estimates.model.column((name, key))) for key in free]
    covariance = estimates.covariance[np.ix_(places, places)]
    dof = min(estimates.degrees_of_freedom((name, key)) for key in free)
    factor, slopes = student_factor(whole_dof(dof)), []
    for key in free:
        at_step, share = stepped(fitted, f"{name}.{key}", nuisances(plant), _STEP)
        after = evaluate(at_step)
        slopes.append([(after[quantity] - before[quantity]) / share for quantity in before])
    g = np.array(slopes)
    spread = np.sqrt(np.einsum("iq,ij,jq->q", g, covariance, g))
    return {quantity: factor * float(s) for quantity, s in zip(before, spread, strict=True)}


def change(
    quantity: str, unit: str, at_point: float, half_width: float, windows: np.ndarray
) -> Change:
    """Return the change of a quantity; ``windows`` (w,) are its changes in all measured motion."""
    known = windows[np.isfinite(windows)]
    return Change(
        quantity=quantity,
        unit=unit,
        at_point=at_point,
        ci95=(at_point - half_width, at_point + half_width) if np.isfinite(half_width) else None,
        along=float(np.sqrt(np.mean(known**2))) if len(known) else float("nan"),
        largest=float(np.quantile(np.abs(known), _LARGEST)) if len(known) else float("nan"),
    )


def effect_in_practice(name: str, changes: tuple[Change, ...]) -> EffectInPractice:
    """Return what an effect changes, with the description and advice of its catalogue row.

    Quantities that it does not change are left out.
    """
    row = EFFECTS[name]
    return EffectInPractice(
        name=name,
        changes=tuple(each for each in changes if each.largest > 0 or each.at_point),
        inspect=row.inspect,
        repair=row.repair,
        lookalikes=tuple(
            Lookalike(other, separation.kind, separation.why)
            for other, separation in lookalikes(name).items()
        ),
    )
