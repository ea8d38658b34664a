"""Points that contradict the second law: friction that drives, efficiency above 100 %.

Friction opposes the motion: with the signs of 5.1 it has the sign of the velocity, and the
efficiency 6.10 is at most 1. A measured point that is beyond this by more than its 95 % interval
shows an error of the instruments, of their zero, or of an area.
"""

from collections.abc import Iterable, Iterator
from typing import Any

from hbench.analysis.curves.ramps import sliding
from hbench.analysis.rounding import exceeds
from hbench.analysis.uncertainty.budget import StandardUncertainty, of_instruments
from hbench.records import SERIES_FIELDS, Curve, EfficiencyCurve, ImplausiblePoint


def implausible_points(
    curves: Iterable[Curve], efficiency: Iterable[EfficiencyCurve]
) -> tuple[ImplausiblePoint, ...]:
    """Return the points with an implausible sign, those within their interval included.

    Of ramps the points from breakaway on count: before it, the seals follow the motion elastically.
    """
    return (*_of_friction(curves), *_of_efficiency(efficiency))


def _of_friction(curves: Iterable[Curve]) -> Iterator[ImplausiblePoint]:
    for curve in map(sliding, curves):
        for point in curve.points:
            value = curve.against_motion * point.friction_n
            if value < 0:
                half = _half_width(point.u95_n, point.ci95_n, of_instruments(point))
                yield ImplausiblePoint(
                    **_series(curve),
                    v_m_s=point.v_m_s,
                    quantity="friction_n",
                    value=value,
                    u95=half,
                    beyond=value + (half or 0.0) < 0,
                )


def _of_efficiency(curves: Iterable[EfficiencyCurve]) -> Iterator[ImplausiblePoint]:
    for curve in curves:
        for point in curve.points:
            value = point.efficiency
            if value is not None and exceeds(value, 1.0):
                sigma = None if point.sigma is None else StandardUncertainty(point.sigma)
                half = _half_width(point.u95, point.ci95, sigma)
                yield ImplausiblePoint(
                    **_series(curve),
                    v_m_s=point.v_m_s,
                    quantity="efficiency",
                    value=value,
                    u95=half,
                    beyond=value - (half or 0.0) > 1,
                )


def _half_width(
    u95: float | None, ci95: float | None, instruments: StandardUncertainty | None
) -> float | None:
    """Return the half-width of an interval: of all, of the trials, or of the instruments alone."""
    if u95 is not None or ci95 is not None:
        return ci95 if u95 is None else u95
    return None if instruments is None else instruments.expanded()


def _series(curve: Curve | EfficiencyCurve) -> dict[str, Any]:
    return {name: getattr(curve, name) for name in SERIES_FIELDS}
