"""Learned laws as a diagnosis has them, with the intervals of their values."""

from collections.abc import Sequence

import numpy as np

from hbench.analysis.statistics.student import student_factor
from hbench.config.effects import QUANTITIES, target_unit
from hbench.reconcile.column_names import mode_name
from hbench.reconcile.estimates import ParameterEstimates, whole_dof
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.learned.table import LawFound
from hbench.records import UnnamedLaw
from hbench.units import parse_unit


def unnamed_laws(
    laws: Sequence[LawFound],
    estimates: ParameterEstimates,
    before: GapMap,
    after: GapMap,
    held_out: np.ndarray,
) -> tuple[UnnamedLaw, ...]:
    """Return the learned laws of the estimated model.

    ``before`` and ``after`` are the residuals without and with all of them; ``held_out`` (n,) are
    indices of operating points.
    """
    return tuple(_unnamed(law, estimates, before, after, held_out) for law in laws)


def _unnamed(
    law: LawFound,
    estimates: ParameterEstimates,
    before: GapMap,
    after: GapMap,
    held_out: np.ndarray,
) -> UnnamedLaw:
    table = estimates.hypothesis.tables[law.table]
    unit, values = target_unit(table.adds_to), table.values
    names = [mode_name(law.table, j) for j in range(len(table.modes))]
    at = [estimates.chosen.index(estimates.model.data.names.index(name)) for name in names]
    covariance = table.basis @ estimates.covariance[np.ix_(at, at)] @ table.basis.T
    factor = student_factor(whole_dof(float(np.max(estimates.dof[at]))))
    half = factor * np.sqrt(np.diag(covariance)).reshape(values.shape)
    si = parse_unit(unit).factor
    units = tuple(QUANTITIES[name] for name in table.knots)
    return UnnamedLaw(
        adds_to=table.adds_to,
        balances=table.balances,
        unit=unit,
        quantities=tuple(table.knots),
        quantity_units=units,
        knots=tuple(
            tuple((np.array(knots) / parse_unit(each).factor).tolist())
            for knots, each in zip(table.knots.values(), units, strict=True)
        ),
        values=_row_by_row(values / si),
        low=_row_by_row((values - half) / si),
        high=_row_by_row((values + half) / si),
        gap_before=before.gap(table.balances, held_out),
        gap_after=after.gap(table.balances, held_out),
        score=law.score,
        threshold=law.threshold,
        p_value=law.p_value,
    )


def _row_by_row(values: np.ndarray) -> tuple[float, ...]:
    return tuple(values.ravel().tolist())
