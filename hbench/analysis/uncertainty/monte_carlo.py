"""Propagation of distributions by Monte Carlo, to check the law of propagation (JCGM 101).

Each draw changes every input by its own distribution, and the mean of the trials by s / sqrt(n)
times Student's t with n - 1 degrees of freedom (JCGM 101, 6.4.9). The 95 % interval of friction or
efficiency is the probabilistically symmetric one of all draws (7.7). Nothing is linearised: the
changed forces go through the equations themselves.

The two agree if the half-widths differ by no more than half a unit of the first significant digit
of the standard uncertainty (JCGM 101, 8.1): tolerances are stated with one or two digits.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import floor, log10

import numpy as np

from hbench.analysis.uncertainty.budget import errors_of
from hbench.analysis.uncertainty.efficiency import driving_side, forces_of
from hbench.analysis.uncertainty.input_errors import InputError
from hbench.config.sensors import Instruments
from hbench.errors import DataError
from hbench.records import Curve, CurvePoint, EfficiencyCurve, EfficiencyPoint

DRAWS = 100_000


def checked_by_monte_carlo(
    curves: Sequence[Curve],
    efficiencies: Sequence[EfficiencyCurve],
    instruments: Instruments | None,
) -> tuple[tuple[Curve, ...], tuple[EfficiencyCurve, ...], tuple[str, ...]]:
    """Return curves and their efficiencies with ``u95_monte_carlo``, and the result in words.

    Raises ``DataError`` without tolerances of the instruments.
    """
    if instruments is None:
        raise DataError(
            "--monte-carlo: the tolerances of the instruments are not known",
            "State `instruments` in the bench file, the import map or the settings file.",
        )
    rng = np.random.default_rng(0)
    frictions, etas = [], []
    for curve, efficiency in zip(curves, efficiencies, strict=True):
        points = [_friction(point, curve, instruments, rng) for point in curve.points]
        frictions.append(replace(curve, points=tuple(points)))
        pairs = zip(efficiency.points, curve.points, strict=True)
        of_eta = [_efficiency(eta, point, curve, instruments, rng) for eta, point in pairs]
        etas.append(replace(efficiency, points=tuple(of_eta)))
    of_friction = [(p.u95_n, p.u95_monte_carlo_n) for curve in frictions for p in curve.points]
    of_efficiency = [(p.u95, p.u95_monte_carlo) for curve in etas for p in curve.points]
    notes = (_comparison("friction", of_friction), _comparison("efficiency", of_efficiency))
    return tuple(frictions), tuple(etas), notes


def _comparison(quantity: str, pairs: Sequence[tuple[float | None, float | None]]) -> str:
    known = [(own, drawn) for own, drawn in pairs if own is not None and drawn is not None]
    text = f"Monte Carlo ({DRAWS} draws): U of steady {quantity} "
    if not known:
        return f"{text}has no point to compare"
    same = sum(agree(own, drawn) for own, drawn in known)
    agreement = f"{text}agrees at {same} of {len(known)} points"
    ratios = [own / drawn for own, drawn in known if drawn]
    if not ratios:
        return agreement
    span = f"{min(ratios):.2f} to {max(ratios):.2f}"
    return f"{agreement}; the law of propagation gives {span} of it"


def agree(u95: float, u95_monte_carlo: float) -> bool:
    """Return whether two expanded uncertainties agree, as JCGM 101 asks."""
    standard = u95_monte_carlo / 2
    if standard == 0:
        return u95 == 0
    return abs(u95 - u95_monte_carlo) <= 0.5 * 10.0 ** floor(log10(standard))


def _friction(
    point: CurvePoint, curve: Curve, instruments: Instruments, rng: np.random.Generator
) -> CurvePoint:
    if point.u95_n is None:
        return point
    errors = errors_of(point, curve.specimen, instruments)
    f_test, f_applied = _changes(errors, rng)
    drawn = f_test - f_applied + _of_trials(point.trials_n, rng)
    return replace(point, u95_monte_carlo_n=_half_width(drawn))


def _efficiency(
    eta: EfficiencyPoint,
    point: CurvePoint,
    curve: Curve,
    instruments: Instruments,
    rng: np.random.Generator,
) -> EfficiencyPoint:
    forces = forces_of(point, curve.specimen)
    if eta.u95 is None or eta.sigma_trials is None:
        return eta
    errors = errors_of(point, curve.specimen, instruments)
    f_test, f_applied = _changes(errors, rng)
    f_test, f_applied = f_test + forces.f_test_n, f_applied + forces.f_applied_n
    drives = driving_side(forces)[0] == "hydraulics"
    drawn = f_applied / f_test if drives else f_test / f_applied
    drawn += eta.sigma_trials * rng.standard_t(point.n - 1, DRAWS)
    return replace(eta, u95_monte_carlo=_half_width(drawn))


def _changes(
    errors: Sequence[InputError], rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return the drawn changes (m,) of F_T and F_applied."""
    f_test, f_applied = np.zeros(DRAWS), np.zeros(DRAWS)
    for error in errors:
        drawn = standardised(error, rng, DRAWS)
        f_test += error.f_test_n * drawn
        f_applied += error.f_applied_n * drawn
    return f_test, f_applied


def standardised(error: InputError, rng: np.random.Generator, draws: int) -> np.ndarray:
    """Return draws (m,) of an input's error in its standard uncertainties."""
    if error.distribution == "rectangular":
        return rng.uniform(-(3**0.5), 3**0.5, draws)
    if error.distribution == "triangular":
        return rng.triangular(-(6**0.5), 0.0, 6**0.5, draws)
    if np.isfinite(error.dof):
        return rng.standard_t(error.dof, draws)
    return rng.standard_normal(draws)


def _of_trials(trials: Sequence[float], rng: np.random.Generator) -> np.ndarray:
    error = np.std(trials, ddof=1) / np.sqrt(len(trials))
    return error * rng.standard_t(len(trials) - 1, DRAWS)


def _half_width(drawn: np.ndarray) -> float:
    low, high = np.quantile(drawn, [0.025, 0.975])
    return float(high - low) / 2
