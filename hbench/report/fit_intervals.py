"""What the intervals of fitted parameters contain, and what they leave out."""

from hbench.records import KINDS, CurvePoint, Results
from hbench.records.numbers import NORMAL_95
from hbench.report.render.numbers import half_width


def fit_interval_words(results: Results) -> str:
    """State what the intervals of fits contain, and how far the instruments may shift friction."""
    points = [
        point
        for curve in results.curves
        for point in curve.points
        if KINDS[curve.kind].has_constant_speed
    ]
    drifts = any(point.sigma_drift_n is not None for point in points)
    of_drift = " and the drift" if drifts else ""
    drift = "" if drifts else " or of a drift"
    return (
        f"Intervals are those of 95 % by the scatter of the points{of_drift}, without the errors "
        f"of the instruments{_size(points)}{drift}."
    )


def _size(points: list[CurvePoint]) -> str:
    sigmas = [p.sigma_instruments_n for p in points if p.sigma_instruments_n is not None]
    if not sigmas:
        return ""
    return f", which shift friction by up to ±{half_width(NORMAL_95 * max(sigmas))} N (95 %),"
