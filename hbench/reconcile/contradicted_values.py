"""Values of a model file that the measured flows contradict: bulk modulus and valve gain.

Oil alone has 12,000 to 18,000 bar; with some air and elastic hoses a bench has a tenth of it. A
refit does not reach a value so far from the given one, and gaps would remain in its place. The
residual of a flow balance is linear in the compressibility and in the valves' gain, so that both
need no search: with the residual r, its part c from compression and its derivative g by the
logarithm of the gain, at the given values,

    r + (s - 1) c + (k - 1) g = noise,   s = given / measured modulus, k = measured / given gain

The flows to a chamber show the ratio of modulus and volume; the modulus is that for the given dead
volumes.
"""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

from hbench.config.bench import Bench, Plant
from hbench.reconcile.column_names import factor_name
from hbench.reconcile.measured.balances import BALANCES, FLOWS
from hbench.reconcile.measured.comparable_runs import comparable_runs
from hbench.reconcile.measured.contradictions import refuse_contradictions
from hbench.reconcile.measured.session import sessions
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.nuisance import BOUND, FACTORS, nuisance_value
from hbench.reconcile.separation.missing_data import data_shortfalls
from hbench.records import Run
from hbench.records.reconcile.diagnosis import MATERIAL

MODULUS, GAIN = "oil.bulk_modulus", "valve.gain"
_POWERS = {MODULUS: -1, GAIN: 1}  # the residuals are linear in these powers of the values
_CLEAR = 5.0  # standard errors; windows overlap, so the true ones are larger


def contradicted_values(bench: Bench | None, plant: Plant, runs: Sequence[Run]) -> dict[str, float]:
    """Return the measured values [SI] that no refit reaches from those of the plant, by path.

    A value is left out where the refit reaches it, or where the runs do not determine it. ``bench``
    is None where the board is unknown. Raises ``DataError`` for logs that contradict the plant in
    what no refit corrects.
    """
    usable, _ = comparable_runs(runs)
    if data_shortfalls(usable):
        return {}
    measured = MeasuredCampaign(bench, plant, None, sessions(usable), MATERIAL)
    refuse_contradictions(measured.logs, measured.balance_model(measured.start))
    return {
        path: factor * nuisance_value(plant, path)
        for path, factor in _measured_factors(measured).items()
        if abs(np.log(factor)) > BOUND * FACTORS[path]
    }


def _measured_factors(measured: MeasuredCampaign) -> dict[str, float]:
    """Return the measured values in multiples of the given ones, where they are determined."""
    columns = measured.columns(measured.start, map(factor_name, _POWERS))
    gaps, flows = measured.gap_map(measured.start), np.isin(BALANCES, FLOWS)
    slopes = [
        -columns[factor_name(path)] / FACTORS[path] / power for path, power in _POWERS.items()
    ]
    with np.errstate(divide="ignore", invalid="ignore"):
        values = np.array([gaps.difference, *slopes]) / gaps.scatter
    values = values[:, :, flows].reshape(len(values), -1)
    residual, *slopes = values[:, np.isfinite(values).all(axis=0)]
    design = np.column_stack(slopes)
    if np.linalg.matrix_rank(design) < len(_POWERS):
        return {}
    fit = least_squares(
        lambda q: residual + design @ (q - 1), np.ones(len(_POWERS)), loss="soft_l1"
    )
    variances = 2 * fit.cost / len(residual) * np.diag(np.linalg.inv(fit.jac.T @ fit.jac))
    return {
        path: float(ratio ** (1 / power))
        for (path, power), ratio, error in zip(
            _POWERS.items(), fit.x, np.sqrt(variances), strict=True
        )
        if ratio > _CLEAR * error
    }
