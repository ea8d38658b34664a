"""Effects that a search added to a model, with their coefficients and gaps."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hbench.model.parameters import CylinderParameters
from hbench.reconcile.diagnosis_fields import added_effect, fitted_shape, with_place
from hbench.reconcile.estimates import ParameterEstimates, fit_coefficients
from hbench.reconcile.linearised import LinearisedModel, changed_balances
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.search_result import SearchResult, SearchStep
from hbench.records import AddedEffect


def added_effects(
    measured: MeasuredCampaign,
    result: SearchResult,
    fits: Mapping[str, ParameterEstimates],
    held_out: np.ndarray,
) -> tuple[AddedEffect, ...]:
    """Return the named effects; their gaps are those without learned laws.

    ``fits`` has the estimates of each; ``held_out`` are indices of operating points.
    """
    cylinder, ends = _place(measured, result)
    effects = []
    for name, step in zip(result.names, result.additions, strict=True):
        unconfirmed = result.unconfirmed.get(name)
        model = unconfirmed.model if unconfirmed else result.without_laws
        effect = _added(step, fits[name], result.steps, model, held_out)
        shape = fitted_shape(name, model.hypothesis)
        effects.append(with_place(replace(effect, shape=shape), cylinder, ends))
    return tuple(effects)


def small_effects(
    measured: MeasuredCampaign, result: SearchResult, held_out: np.ndarray
) -> tuple[AddedEffect, ...]:
    """Return the effects that are too small to be named and explain all gaps; none otherwise."""
    small = result.small
    if small is None:
        return ()
    cylinder, ends = _place(measured, result)
    points = np.arange(len(small.model.gap_map.points))
    train = np.setdiff1d(points, held_out)
    fit = fit_coefficients(measured.plant, small.model, small.names, train)
    effects = (_added(s, fit, small.steps, small.model, held_out) for s in small.steps if s.added)
    return tuple(with_place(effect, cylinder, ends) for effect in effects)


def held_out_gaps(
    steps: Sequence[SearchStep], model: LinearisedModel, name: str, held_out: np.ndarray
) -> tuple[float, float]:
    """Return the gaps of the balances that an effect changes, before it was added and in a model.

    ``held_out`` are indices of operating points. The level of friction of each run is left out as
    far as it may wander: that of a few runs would decide.
    """
    before = next(step.before for step in steps if step.added == name)
    without, with_it = (each.gap_map.without_levels() for each in (before, model))
    balances = changed_balances(without, model, name, held_out)
    return without.gap(balances, held_out), with_it.gap(balances, held_out)


def _added(
    step: SearchStep,
    fit: ParameterEstimates,
    steps: Sequence[SearchStep],
    model: LinearisedModel,
    held_out: np.ndarray,
) -> AddedEffect:
    """Return the effect that one of the ``steps`` added, with its gaps and those in a model."""
    assert step.added
    candidates = [each.candidate for each in step.evaluated]
    gaps = held_out_gaps(steps, model, step.added, held_out)
    return added_effect(step.added, candidates, fit, *gaps)


def _place(
    measured: MeasuredCampaign, result: SearchResult
) -> tuple[CylinderParameters, tuple[float, float]]:
    """Return the test cylinder, and the ends of the positions that were measured."""
    positions = np.concatenate([run.x_m for log in measured.logs for run in log.runs])
    cylinder = measured.balance_model(result.final.hypothesis).par.test
    return cylinder, (float(positions.min()), float(positions.max()))
