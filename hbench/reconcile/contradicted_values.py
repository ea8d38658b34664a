"""Values of a model file that the measured flows contradict: bulk modulus and gains of valves.

Oil alone has 12,000 to 18,000 bar; with some air and elastic hoses a bench has a tenth of it. A
spool for an asymmetric cylinder has edges of two sizes, and load valves may have a size of their
own. A refit does not reach values so far from the given ones, and gaps would remain in their place.
The residual of a flow balance is linear in the compressibility and in each gain: with the residual
r, its part c from compression, its derivative g by the logarithm of the gain of all valves and its
derivatives h by the coefficients p of ``valve_trim`` and ``valve_asymmetry``, given as p_0,

    r + (s - 1) c + (k - 1) g + h (p - p_0) = noise,
    s = given / measured modulus, k = measured / given gain

k and p are multiplied with each other, so that values that no refit reaches are solved for again,
about themselves. Among p are nulls and asymmetries, which the others would replace otherwise. The
flows to a chamber show the ratio of modulus and volume; the modulus is that for the given dead
volumes. One that no liquid has is that of runs in which little is compressed.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import log

import numpy as np
from scipy.optimize import least_squares

from hbench.config.bench import Bench, Plant
from hbench.model.effects.catalogue import read_effects
from hbench.reconcile.column_names import (
    CoefficientKey,
    coefficient_name,
    coefficient_of,
    factor_name,
)
from hbench.reconcile.hypothesis import Hypothesis, typical_size
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
PORTS: CoefficientKey = ("valve_trim", "ports")
LOADS: tuple[CoefficientKey, ...] = (("valve_trim", "gain_load_1"), ("valve_trim", "gain_load_2"))
_BESIDE: tuple[CoefficientKey, ...] = (
    *(("valve_trim", f"null_{valve}") for valve in ("test", "load_1", "load_2")),
    *(("valve_asymmetry", key) for key in ("test", "load", "load_apart")),
)
_POWERS = {MODULUS: -1, GAIN: 1}  # the residuals are linear in these powers of the values
_EFFECTS = "effects."  # the section of a model file
_CLEAR = 5.0  # standard errors; windows overlap, so the true ones are larger
_PRECISE = 0.01  # standard error of a gain; V, that of a null
_STIFFEST_PA = 3.5e9  # water glycol; oil without air has half of it


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
    at = _solved(measured, measured.start)
    if not any(_beyond_refit(measured, at)):
        return {}
    return dict(_beyond_refit(measured, _solved(measured, at)))


def _beyond_refit(measured: MeasuredCampaign, at: Hypothesis) -> Iterator[tuple[str, float]]:
    """Yield path and value [SI] of what a refit of the given values does not reach.

    Where a valve has another size than the others, its gain and theirs belong together.
    """
    given, limits = measured.start, measured.tolerances
    sizes = []
    for which in LOADS if GAIN in at.factors else ():
        before, after = (1.0 + each.coefficient(which) for each in (given, at))
        share = limits[which] / before
        sizes.append(abs(log(after / before)) > log((1.0 + share) / (1.0 - share)))
    for path, factor in at.factors.items():
        value = factor * given_value(measured.plant, path)
        is_far = abs(log(factor)) > BOUND * FACTORS[path] or (path == GAIN and any(sizes))
        if is_far and not (path == MODULUS and value > _STIFFEST_PA):
            yield path, value
    uneven = abs(at.coefficient(PORTS) - given.coefficient(PORTS)) > BOUND * limits[PORTS]
    for which in (*(LOADS if any(sizes) else ()), *([PORTS] if uneven else ())):
        yield f"{_EFFECTS}{coefficient_name(which)}", at.coefficient(which)


def given_value(plant: Plant, path: str) -> float:
    """Return the value [SI] that a plant has at a path of ``contradicted_values``."""
    if path.startswith(_EFFECTS):
        given = Hypothesis(effects=read_effects(plant.effects))
        return given.coefficient(coefficient_of(path.removeprefix(_EFFECTS)))
    return nuisance_value(plant, path)


def _solved(measured: MeasuredCampaign, at: Hypothesis) -> Hypothesis:
    """Return a hypothesis with the values that the flows show, where they determine them."""
    coefficients = (PORTS, *LOADS, *_BESIDE)
    names = [*map(factor_name, _POWERS), *map(coefficient_name, coefficients)]
    sizes = [FACTORS[path] * power for path, power in _POWERS.items()]
    sizes += [typical_size(which) for which in coefficients]
    columns = measured.columns(at, names)
    gaps, flows = measured.gap_map(at), np.isin(BALANCES, FLOWS)
    slopes = [-columns[name] / size for name, size in zip(names, sizes, strict=True)]
    with np.errstate(divide="ignore", invalid="ignore"):
        values = np.array([gaps.difference, *slopes]) / gaps.scatter
    values = values[:, :, flows].reshape(len(values), -1)
    residual, *slopes = values[:, np.isfinite(values).all(axis=0)]
    shown = [i for i, slope in enumerate(slopes) if slope.any()]  # load valves have no commands
    design = np.column_stack([slopes[i] for i in shown])
    if np.linalg.matrix_rank(design) < len(shown):
        return at
    fit = least_squares(lambda q: residual + design @ q, np.zeros(len(shown)), loss="soft_l1")
    variances = 2 * fit.cost / len(residual) * np.diag(np.linalg.inv(fit.jac.T @ fit.jac))
    factors, trims = dict(at.factors), {}
    for i, change, error in zip(shown, fit.x, np.sqrt(variances), strict=True):
        if i < len(_POWERS):
            path, power = list(_POWERS.items())[i]
            if 1.0 + change > _CLEAR * error:
                factors[path] = factors.get(path, 1.0) * float((1.0 + change) ** (1 / power))
        elif error < _PRECISE:
            which = coefficients[i - len(_POWERS)]
            trims[which] = at.coefficient(which) + float(change)
    return replace(at, factors=factors).with_coefficients(trims)
