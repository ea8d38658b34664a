"""Identification of five friction laws from a campaign's averaged curves and logged motions.

    tustin          all points of the steady curves, for magnitudes
    marton_lantos   points of each direction's curves: the two lines of its Tustin fit
    pressure_based  all points of the steady curves
    lugre           motions with reversals, and ramps; the search starts at the Tustin fit
    leuven          as LuGre, with three elements and n = 1; the search starts at the LuGre fit

Ramps do not reverse; they determine sliding friction over load and speed. Runs of ``steps`` are not
used: velocity steps occur between two samples, so that velocity and inertia from the log are wrong
(on the virtual rig by up to 150 N, which distorts the bristles' parameters).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from hbench.analysis.fitting.fit import fit_law, fit_pressure_based
from hbench.analysis.fitting.fit_data import fit_points
from hbench.analysis.fitting.marton_lantos import lines_from_tustin
from hbench.analysis.fitting.over_curves import tustin_covariance, without_impossible_intervals
from hbench.analysis.fitting.tustin import (
    PARAMETER_NAMES,
    PARAMETER_UNITS,
    TUSTIN_LAW,
    tustin_bounds,
)
from hbench.analysis.identification.friction_section import friction_section
from hbench.analysis.identification.leuven import STEADY, fit_leuven
from hbench.analysis.identification.lugre import UNKNOWNS, fit_lugre
from hbench.analysis.identification.position_noise import with_position_noise
from hbench.analysis.screening.sample_friction import LoggedMotion
from hbench.analysis.statistics.intervals import fit_parameters, parameter_messages
from hbench.config.fitting import Fitting
from hbench.config.friction import parse_friction
from hbench.errors import ConfigError, DataError
from hbench.model.friction.laws import LAWS
from hbench.model.parameters import FrictionParameters
from hbench.records import DIRECTION_WORDS, Curve, Direction, Fit, FitParameter, IdentifiedLaw

REVERSING_M_S = 2e-3  # a reversing motion is faster than this in both directions
_SEALS = ("k_piston_n_pa", "k_rod_n_pa")
_SPANS = (0.7, 1.0, 1.4, 2.0)  # Delta_max tried for a start, in lengths of LuGre's presliding
_SHARES = (0.25, 0.25, 0.5)  # of the stiction, in the elements at the start
_SEVERAL_MINIMA = (
    "n = 1 is assumed; delta_max_m and the elements may have other equally low minima, and their "
    "intervals are those at this minimum"
)
_UNKNOWN = FrictionParameters(
    law=LAWS["lugre"].code,
    coulomb=300.0,
    stiction=400.0,
    stribeck_velocity=0.06,
    viscous=2e3,
    bristle_stiffness=3e5,
)  # start of the search without a Tustin fit


def identify_laws(
    curves: Sequence[Curve], motions: Sequence[LoggedMotion]
) -> tuple[IdentifiedLaw, ...]:
    """Identify every law that steady ``curves`` and ``motions`` (triangles, ramps) determine.

    A law that can't be identified, or has no valid section of a bench file, has the reason. Raises
    ``DataError`` for curves of different cylinders.
    """
    if len({curve.specimen for curve in curves}) > 1:
        raise DataError(
            "the campaign's steady runs are of different cylinders",
            "Import the runs of each cylinder as a separate campaign.",
        )
    laws: dict[str, IdentifiedLaw] = {}

    def fit_of(law: str) -> Fit | None:
        return laws[law].fit

    runs = tuple(run for curve in curves for point in curve.points for run in point.runs)
    moving = tuple(motion.run for motion in motions)
    for law, used, fit in (
        ("tustin", runs, lambda: _tustin(_enough(curves))),
        ("marton_lantos", runs, lambda: _lines(curves)),
        ("pressure_based", runs, lambda: _determined(fit_pressure_based(curves))),
        (
            "lugre",
            moving,
            lambda: _lugre(_reversing(motions), fit_of("tustin")),
        ),
        ("leuven", moving, lambda: _leuven(motions, fit_of("lugre"))),
    ):
        laws[law] = _identified(law, used, fit)
    return tuple(laws.values())


def reverses(motion: LoggedMotion) -> bool:
    """Return whether the piston moves in both directions within the compared samples."""
    v = motion.v_m_s[motion.compared]
    return bool(len(v)) and v.min() < -REVERSING_M_S and v.max() > REVERSING_M_S


def _identified(law: str, runs: tuple[str, ...], fit: Callable[[], Fit]) -> IdentifiedLaw:
    try:
        result = fit()
        section = friction_section(result)
        parse_friction(section, law)
    except _NotDetermined as error:
        return IdentifiedLaw(law, None, str(error))
    except ConfigError as error:
        return IdentifiedLaw(law, None, f"the fitted values are impossible: {error.message}")
    return IdentifiedLaw(law, result, section=section, runs=runs)


class _NotDetermined(Exception):
    """Data that is insufficient for a law."""


def _enough(curves: Sequence[Curve], direction: Direction | Literal[""] = "") -> Sequence[Curve]:
    """Return all curves, or one direction's, if one of them has enough speeds."""
    chosen = [curve for curve in curves if direction in ("", curve.direction)]
    speeds = max((len(curve.points) for curve in chosen), default=0)
    if speeds < len(PARAMETER_NAMES):
        when = f" when {DIRECTION_WORDS[direction]}" if direction else ""
        raise _NotDetermined(
            f"its {len(PARAMETER_NAMES)} parameters need a curve of at least "
            f"{len(PARAMETER_NAMES)} steady speeds{when}; the campaign has {speeds or 'none'}"
        )
    return chosen


def _tustin(curves: Sequence[Curve]) -> Fit:
    """Fit Tustin's law to the points of all curves; intervals of several are over curves."""
    fit = fit_law(TUSTIN_LAW, curves, Fitting())
    if len(curves) == 1:
        return fit
    values = np.array([fit.parameters[name].value for name in PARAMETER_NAMES])
    bounds = [fit.parameters[name].at_bound for name in PARAMETER_NAMES]
    spread, dof = tustin_covariance(curves, fit)
    free = [bound is None for bound in bounds]
    points = fit_points(curves)
    force_n = float(np.abs(points.friction_n).max())
    size = TUSTIN_LAW.scale(points.inputs, force_n)
    covariance = spread[np.ix_(free, free)]
    linearised = fit_parameters(PARAMETER_UNITS, values, covariance, dof[free], bounds, size)
    allowed = tustin_bounds(points.inputs, force_n)
    parameters, impossible = without_impossible_intervals(linearised, allowed)
    messages = [] if fit.converged else ["the search for the best fit did not converge"]
    messages += [*parameter_messages(linearised), *impossible]
    messages.append(
        f"points of a curve are not independent, so intervals are over the {len(curves)} curves"
    )
    return replace(fit, parameters=parameters, message="; ".join(messages))


def _lines(curves: Sequence[Curve]) -> Fit:
    fits: dict[Direction, Fit] = {}
    for direction in ("extend", "retract"):
        chosen = _enough(curves, direction)
        fits[direction] = lines_from_tustin(chosen, _tustin(chosen))
    parameters: dict[str, FitParameter] = {
        f"{direction}_{name}": parameter
        for direction, fit in fits.items()
        for name, parameter in fit.parameters.items()
    }
    messages = [f"{direction}: {fit.message}" for direction, fit in fits.items() if fit.message]
    return Fit(
        law="marton_lantos",
        parameters=parameters,
        rmse_n=max(fit.rmse_n for fit in fits.values()),
        converged=all(fit.converged for fit in fits.values()),
        message="; ".join(messages),
    )


def _determined(fit: Fit) -> Fit:
    if not fit.parameters:
        raise _NotDetermined(fit.message)
    return fit


def _reversing(motions: Sequence[LoggedMotion]) -> Sequence[LoggedMotion]:
    if not any(reverses(motion) for motion in motions):
        raise _NotDetermined(
            "its bristles need reversals of motion, and the campaign has no usable run of kind "
            "'triangle'"
        )
    return motions


def _unknowns(motions: Sequence[LoggedMotion]) -> tuple[str, ...]:
    """Return the parameters to fit: without hydraulics there is no friction from pressures."""
    hydraulic = any(motion.p_p_pa.any() or motion.p_r_pa.any() for motion in motions)
    return tuple(name for name in UNKNOWNS if hydraulic or name not in _SEALS)


def _start(fit: Fit | None) -> FrictionParameters:
    """Return the start of a search: the parameters of another law's fit."""
    values: dict[str, Any] = {
        UNKNOWNS[name].field: parameter.value
        for name, parameter in (fit.parameters if fit else {}).items()
        if name in UNKNOWNS
    }
    return _UNKNOWN._replace(**values)


def _lugre(motions: Sequence[LoggedMotion], tustin: Fit | None) -> Fit:
    fit = fit_lugre(motions, _start(tustin), _unknowns(motions))
    return with_position_noise(fit, motions, _deflection(_start(fit)))


def _deflection(law: FrictionParameters) -> float:
    """Return the deflection [m] of the bristles of LuGre's law before they slide."""
    return law.stiction / law.bristle_stiffness


def _leuven(motions: Sequence[LoggedMotion], lugre: Fit | None) -> Fit:
    """Fit Leuven's law: its elements for some Delta_max to some runs, then everything to all."""
    if lugre is None:
        raise _NotDetermined("its search starts at LuGre's fit, which is missing")
    known = _start(lugre)
    if not known.stiction > 0.0:
        raise _NotDetermined("its search starts at LuGre's fit, whose static friction is 0 N")
    length = _deflection(known)
    elements = tuple(share * known.stiction for share in _SHARES)
    turning = sorted(filter(reverses, motions), key=lambda motion: len(motion.v_m_s))
    few = turning[: (len(turning) + 1) // 2]  # the shorter ones: many reversals, little sliding
    tried = []
    for span in _SPANS:
        guess = known._replace(elements=elements, presliding=span * length)
        fit = fit_leuven(few, guess, ())
        fitted = tuple(p.value for p in fit.parameters.values())
        tried.append((fit.rmse_n, guess._replace(elements=fitted)))
    _, best = min(tried, key=lambda candidate: candidate[0])
    seals = [name for name in _unknowns(motions) if name in _SEALS]
    names = (*STEADY, "sigma1_n_s_m", *seals, "delta_max_m")
    fit = fit_leuven(motions, best, names, spans=(1.0,))
    fit = replace(fit, message="; ".join(filter(None, (fit.message, _SEVERAL_MINIMA))))
    return with_position_noise(fit, motions, length)
