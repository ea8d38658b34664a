"""Gaps of the models of a search: given, refitted and final."""

from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np

from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.column_names import coefficient_name
from hbench.reconcile.diagnosis_fields import residual_map
from hbench.reconcile.estimates import ParameterEstimates
from hbench.reconcile.gaps.gap_map import column_means
from hbench.reconcile.gaps.log_map import expected_square, unexplained_gaps
from hbench.reconcile.gaps.regions import regions
from hbench.reconcile.gaps.tables import BalanceStages, SimulatedStages, gap_table, gaps_of_runs
from hbench.reconcile.hypothesis import typical_size
from hbench.reconcile.linearised import LinearisedModel
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.nuisance import standard_deviation
from hbench.reconcile.search_result import SearchResult
from hbench.records import Gap, RunPlan


def refitted_and_unexplained(
    measured: MeasuredCampaign, result: SearchResult
) -> tuple[tuple[Gap, ...], tuple[Gap, ...]]:
    """Return the gaps of the refitted model, and those that no effect explains, large or small."""
    refitted = result.refitted.gap_map
    allowed = _allowed(measured, result.refitted)
    by_effects = result.with_small.gap_map.in_units_of(refitted)
    unexplained = unexplained_gaps(measured.ranked_gaps(by_effects, allowed))
    return measured.ranked_gaps(refitted, allowed), unexplained


def gap_fields(
    result: SearchResult,
    estimates: ParameterEstimates,
    simulated: SimulatedStages | None,
    plans: Sequence[RunPlan],
    held_out: frozenset[Hashable],
) -> dict[str, Any]:
    """Return the fields of a diagnosis with gaps and residuals, in the refitted model's scatter."""
    before = result.refitted.gap_map
    given, after = (each.gap_map.in_units_of(before) for each in (result.given, result.final))
    expected = expected_square(after) + expected_variance(result.final, estimates)
    balances = BalanceStages((given, before, after), expected)
    train = frozenset(before.points) - held_out
    return {
        "regions": regions(before),
        "regions_after": regions(after),
        "gap_heldout": gap_table(balances, simulated, held_out),
        "gap_train": gap_table(balances, simulated, train),
        "gap_runs": gaps_of_runs(plans, balances, simulated, held_out),
        "residuals_before": residual_map(before, held_out),
        "residuals_after": residual_map(after, held_out),
    }


def expected_variance(final: LinearisedModel, estimates: ParameterEstimates) -> np.ndarray:
    """Return the variance (w, c) of the residuals by the parameters' uncertainty, in scatters.

    That by the residuals alone: where they are far below what is material, so is this.
    """
    return residual_variance(final, estimates, estimates.sandwich)


def residual_variance(
    final: LinearisedModel, estimates: ParameterEstimates, covariance: np.ndarray
) -> np.ndarray:
    """Return the variance (w, c) of the residuals by a covariance of the parameters, in scatters.

    By the columns: of parameters that only their sum determines, draws would leave the fit.
    """
    names = [final.data.names[i] for i in estimates.chosen]
    columns = np.stack([np.nan_to_num(final.columns[name]) for name in names], axis=-1)
    variance = np.einsum("wcj,jk,wck->wc", columns, covariance, columns, optimize=True)
    return variance / final.gap_map.scatter**2


def _allowed(measured: MeasuredCampaign, model: LinearisedModel) -> np.ndarray:
    """Return the root mean square (c,) of what sensors within their tolerances may cause."""
    squares = np.zeros(len(model.gap_map.names))
    for which, limit in measured.tolerances.items():
        if EFFECTS[which[0]].of_sensor:
            change = model.columns[coefficient_name(which)] / typical_size(which)
            squares += standard_deviation(limit) ** 2 * np.nan_to_num(column_means(change**2))
    return np.sqrt(squares)
