"""Times of the runs of a campaign, for its drift: start times, or else the order of the runs."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from statistics import fmean

from hbench.analysis.summary.setups import setups_of
from hbench.records import Curve, CurvePoint, ScreenedRun


@dataclass(frozen=True)
class RunClock:
    """Time of each run by its id: start in s after the first run, or its place in the order."""

    times: Mapping[str, float]
    known: bool  # whether these are start times
    setups: Mapping[str, str] = field(default_factory=dict)  # of runs that are not independent

    @classmethod
    def of(
        cls,
        runs: Iterable[ScreenedRun],
        start_times_s: Mapping[str, float],
        files: Mapping[str, str] | None = None,
    ) -> "RunClock":
        """Return a clock of start times [s], or of the order of ``runs`` if there are none.

        ``files`` are those that imported runs were cut from.
        """
        runs = tuple(runs)
        order = {run.run.plan.run: float(place) for place, run in enumerate(runs)}
        known = bool(order) and order.keys() <= start_times_s.keys()
        times = {run: start_times_s[run] for run in order} if known else order
        return cls(times, known, setups_of(runs, files or {}))

    def of_point(self, point: CurvePoint) -> float:
        """Return the mean time of a point's runs."""
        return fmean(self.times[run] for run in point.runs)

    def span(self, curves: Iterable[Curve]) -> float:
        """Return the time from the first to the last run of the points of ``curves``."""
        runs = (run for curve in curves for point in curve.points for run in point.runs)
        times = [self.times[run] for run in runs]
        return max(times) - min(times)


def campaign_place(curves: Iterable[Curve], clock: RunClock) -> Callable[[CurvePoint], float]:
    """Return the function (t_i - t) / span of a point: its place about the campaign's mean time."""
    curves = tuple(curves)
    middle = fmean(clock.of_point(point) for curve in curves for point in curve.points)
    span = clock.span(curves)
    return lambda point: (clock.of_point(point) - middle) / span
