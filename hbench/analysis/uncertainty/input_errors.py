"""Errors of the inputs of friction and efficiency: what one standard uncertainty of each changes.

    F_T = P_Tp A_p - P_Tr A_r,   A_p = pi D^2 / 4,   A_r = pi (D^2 - d^2) / 4
    dF_T / dP_Tp = A_p,  dF_T / dP_Tr = -A_r
    dF_T / dD = (P_Tp - P_Tr) pi D / 2,  dF_T / dd = P_Tr pi d / 2      bore D, rod d

The steps of a log round each reading; the same reading is rounded alike. Samples far from all
others, such as dropouts, change a mean by a known amount, but it is not known whether they are
faults: the mean without them is as possible as that with them.

A load cell that is off the motion's axis by an angle a reads F cos a: at most 1 - cos a too little.
An input's error is the same at all points of a campaign: a gain that is 1 % high is so at every
speed. So changes have signs. An error that all transducers share, by the standard of their
calibration, is one input: their changes are added (JCGM 100, 5.2.2, correlation 1).
"""

from collections.abc import Iterator, Mapping, Sequence
from math import cos, inf, pi, sqrt
from typing import NamedTuple

from hbench.config.sensors import DIVISORS, Distribution, Geometry, Instrument, Instruments
from hbench.records import Specimen

LOAD_CELL = "load cell"
PISTON_SIDE, ROD_SIDE = "piston-side pressure", "rod-side pressure"
_ALL_PRESSURES = "pressures"
_STEPS = ", resolution"
_FAR = "samples far from all others"
_OF_LOG = "the log"


class MeasuredForces(NamedTuple):
    """Means of a point that its inputs' errors change."""

    f_applied_n: float
    p_tp_pa: float
    p_tr_pa: float | None  # None for a plunger


class InputError(NamedTuple):
    """Change of the forces by one standard uncertainty of an input."""

    name: str
    f_test_n: float
    f_applied_n: float
    distribution: Distribution
    dof: float
    source: str


def input_errors(
    instruments: Instruments, forces: MeasuredForces, specimen: Specimen
) -> tuple[InputError, ...]:
    """Return the errors of all inputs of a point, those of the instruments' classes first."""
    merged: dict[str, InputError] = {}
    for error in (
        *_of_instrument(LOAD_CELL, instruments.force, forces.f_applied_n, (0.0, 1.0)),
        *_of_pressures(instruments.pressure, forces, specimen),
        *_of_geometry(instruments.geometry, forces, specimen),
    ):
        same = merged.get(error.name)
        if same is not None:
            error = error._replace(
                f_test_n=same.f_test_n + error.f_test_n,
                f_applied_n=same.f_applied_n + error.f_applied_n,
            )
        merged[error.name] = error
    return tuple(merged.values())


def step_errors(
    u_steps: Mapping[str, float], specimen: Specimen, stated: Sequence[InputError]
) -> Iterator[InputError]:
    """Yield the errors by the steps of the log, of standard uncertainties by channel in SI.

    A resolution that the instruments' file has among ``stated`` replaces them.
    """
    slopes = {
        "f_applied_n": (LOAD_CELL, 0.0, 1.0),
        "p_tp_pa": (PISTON_SIDE, specimen.area_piston_m2, 0.0),
        "p_tr_pa": (ROD_SIDE, -specimen.area_rod_m2, 0.0),
    }
    names = {error.name for error in stated}
    for channel, u in u_steps.items():
        whose, by_test, by_applied = slopes[channel]
        name = f"{whose}{_STEPS}"
        if name not in names:
            yield InputError(name, by_test * u, by_applied * u, "rectangular", inf, _OF_LOG)


def far_error(shift_n: float) -> Iterator[InputError]:
    """Yield the error by samples far from all others, which change mean friction by ``shift_n``."""
    if shift_n:
        u = shift_n / DIVISORS["rectangular"]
        yield InputError(_FAR, u, 0.0, "rectangular", inf, _OF_LOG)


def is_of_log(name: str) -> bool:
    """Return whether an input is an error of the log, which no two campaigns share."""
    return name.endswith(_STEPS) or name == _FAR


def _of_pressures(
    transducer: Instrument, forces: MeasuredForces, specimen: Specimen
) -> Iterator[InputError]:
    sides = [(PISTON_SIDE, forces.p_tp_pa, specimen.area_piston_m2)]
    if forces.p_tr_pa is not None:
        sides.append((ROD_SIDE, forces.p_tr_pa, -specimen.area_rod_m2))
    for name, reading, area in sides:
        yield from _of_instrument(name, transducer, reading, (area, 0.0), _ALL_PRESSURES)


def _of_instrument(
    name: str,
    instrument: Instrument,
    reading: float,
    slopes: tuple[float, float],
    group: str = "",
) -> Iterator[InputError]:
    """Yield the errors of a reading; ``slopes`` are those of F_T and F_applied over it.

    Instruments of one ``group`` share their common errors.
    """
    for kind, source in {"": instrument, **instrument.further}.items():
        u = instrument.standard_uncertainty(source, reading)
        whose = group if source.common and group else name
        yield InputError(
            f"{whose}, {kind}" if kind else whose,
            slopes[0] * u,
            slopes[1] * u,
            source.distribution,
            source.dof or inf,
            source.source,
        )


def _of_geometry(
    geometry: Geometry, forces: MeasuredForces, specimen: Specimen
) -> Iterator[InputError]:
    p_tp, p_tr = forces.p_tp_pa, forces.p_tr_pa or 0.0
    bore_m = sqrt(4 * specimen.area_piston_m2 / pi)
    rod_m = sqrt(4 * max(specimen.area_piston_m2 - specimen.area_rod_m2, 0.0) / pi)
    short = 1 - cos(geometry.alignment)
    inputs = (
        ("bore", geometry.bore, (p_tp - p_tr) * pi * bore_m / 2, 0.0),
        ("rod", geometry.rod, p_tr * pi * rod_m / 2, 0.0),
        ("load cell alignment", short, 0.0, forces.f_applied_n),
    )
    for name, limit, by_test, by_applied in inputs:
        if limit:
            u = limit / DIVISORS[geometry.distribution]
            yield InputError(
                name, by_test * u, by_applied * u, geometry.distribution, inf,
                geometry.source,
            )  # fmt: skip
