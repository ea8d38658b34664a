"""Oil temperature of a campaign, and its steady friction reduced to a reference temperature."""

from collections.abc import Sequence
from statistics import fmean

from hbench.analysis.curves.average import temperature_sensor
from hbench.analysis.fitting.joint import fitted
from hbench.analysis.summary.drift import friction_drift
from hbench.analysis.summary.drift_uncertainty import with_drift
from hbench.analysis.summary.run_clock import RunClock
from hbench.analysis.temperature.reduction import reduced_curves
from hbench.config.fitting import Fitting
from hbench.config.setup import Setup
from hbench.records import KINDS, Curve, OilTemperature, Reduction, ScreenedRun

NO_VISCOSITY = "the oil's viscosity is not known; give oil.viscosity at two temperatures"
_TOO_FEW = "no point was measured often enough at different temperatures"


def oil_temperature(
    curves: Sequence[Curve],
    screened: Sequence[ScreenedRun],
    setup: Setup,
    how: Fitting,
    clock: RunClock,
) -> OilTemperature | None:
    """Return the temperature of the accepted steady runs; None where none has one.

    ``curves`` are their steady curves, which are reduced as far as the data allows.
    """
    steady = [run for run in screened if KINDS[run.run.plan.kind].analysis == "steady_curve"]
    sensor = temperature_sensor(steady)
    if sensor is None:
        return None
    means = [run.means for run in steady if run.accepted and run.means is not None]
    temps_k = [temp for mean in means if (temp := getattr(mean, sensor)) is not None]
    reduction, reason = _reduction(curves, screened, setup, how, clock)
    return OilTemperature(
        sensor=sensor,
        mean_k=fmean(temps_k),
        low_k=min(temps_k),
        high_k=max(temps_k),
        runs=len(temps_k),
        reduction=reduction,
        reason=reason,
    )


def _reduction(
    curves: Sequence[Curve],
    screened: Sequence[ScreenedRun],
    setup: Setup,
    how: Fitting,
    clock: RunClock,
) -> tuple[Reduction | None, str]:
    """Return the reduction, or why there is none."""
    if setup.oil.line is None:
        return None, NO_VISCOSITY
    t_ref = how.reference_temperature
    effects, reduced = reduced_curves(curves, setup.oil, t_ref, setup.instruments)
    if not effects:
        return None, _TOO_FEW
    drift = friction_drift(reduced, screened, clock) if reduced else None
    fits = tuple(fitted(curve, how, setup.reach) for curve in reduced)
    reduced = with_drift(fits, drift, clock, how.weights)
    ranges = [curve.temp_range_k for curve in reduced if curve.temp_range_k is not None]
    lows, highs = [low for low, _ in ranges], [high for _, high in ranges]
    outside = bool(ranges) and not min(lows) <= t_ref <= max(highs)
    return Reduction(t_ref, outside, effects, reduced, drift), ""
