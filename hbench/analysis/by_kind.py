"""Analysis of screened runs by kind of experiment: curves, loops, levels and leakage.

``ANALYSES`` has a function for each value of the column ``analysis`` of ``KINDS``.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from hbench.analysis.curves.average import curves
from hbench.analysis.curves.hysteresis import hysteresis
from hbench.analysis.curves.leakage import leakage
from hbench.analysis.curves.ramp_tests import comparisons
from hbench.analysis.curves.ramps import ramp_curves, slid
from hbench.analysis.curves.step_levels import level_runs, levels
from hbench.analysis.curves.surface import surfaces
from hbench.analysis.fitting.fit import fits
from hbench.analysis.fitting.joint import fitted
from hbench.analysis.uncertainty.budget import with_instruments
from hbench.config.bench import Bench
from hbench.config.fitting import Fitting
from hbench.records import KINDS, Curve, Leakage, Level, Loop, Motions, ScreenedRun

_SHARED_STROKES = (
    "the points of a ramp's curve share their strokes, while the intervals of its fitted "
    "parameters take them as independent: they are too narrow"
)
_UNKNOWN_MASS = "the test side's mass is not known: friction of moving runs holds its inertia"
_NO_BENCH = "leakage needs a bench file: volumes and bulk modulus are not known"
_WITH_INERTIA = {"ramp_curve", "hysteresis", "step_levels"}  # analyses that subtract m_T a


@dataclass(frozen=True)
class Settings:
    """Bench and fit settings of an analysis."""

    bench: Bench | None  # None: imported without a bench file
    fitting: Fitting

    @property
    def mass_kg(self) -> float:
        """Mass of the test side; 0 where it is not known, and then its inertia stays in."""
        return 0.0 if self.bench is None else self.bench.moving_mass.test


@dataclass(frozen=True)
class Products:
    """Results of one analysis, before the instruments' uncertainty is added."""

    curves: tuple[Curve, ...] = ()
    loops: tuple[Loop, ...] = ()
    levels: tuple[Level, ...] = ()
    leakages: tuple[Leakage, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class AnalysedRuns:
    """Results of all analyses of a campaign."""

    steady: tuple[Curve, ...]
    moving: tuple[Curve, ...]  # of ramps and of the levels of steps
    motions: Motions
    notes: tuple[str, ...]


def analyse_runs(
    screened: Iterable[ScreenedRun], bench: Bench | None, fitting: Fitting
) -> AnalysedRuns:
    """Analyse the runs of each kind of experiment, and compare ramps with steady curves."""
    runs: dict[str, list[ScreenedRun]] = defaultdict(list)
    for one in screened:
        runs[KINDS[one.run.plan.kind].analysis].append(one)
    settings = Settings(bench, fitting)
    found = {name: analyse(runs[name], settings) for name, analyse in ANALYSES.items()}
    instruments = None if bench is None else bench.instruments
    steady = tuple(with_instruments(curve, instruments) for curve in found["steady_curve"].curves)
    ramps = found["ramp_curve"].curves
    moving = (curve for name in found if name != "steady_curve" for curve in found[name].curves)
    accepted = {name for name in runs if any(one.accepted for one in runs[name])}
    return AnalysedRuns(
        steady=steady,
        moving=tuple(with_instruments(curve, instruments) for curve in moving),
        motions=Motions(
            comparisons=comparisons((*steady, *map(slid, ramps))),
            loops=tuple(loop for one in found.values() for loop in one.loops),
            levels=tuple(level for one in found.values() for level in one.levels),
            leakages=tuple(leak for one in found.values() for leak in one.leakages),
            surfaces=surfaces(steady),
        ),
        notes=(
            *(note for one in found.values() for note in one.notes),
            *([_UNKNOWN_MASS] if bench is None and accepted & _WITH_INERTIA else []),
            *([_NO_BENCH] if bench is None and "leakage" in accepted else []),
        ),
    )


def _steady_curves(runs: Sequence[ScreenedRun], settings: Settings) -> Products:
    return Products(curves=tuple(fitted(curve, settings.fitting) for curve in curves(runs)))


def _ramp_curves(runs: Sequence[ScreenedRun], settings: Settings) -> Products:
    found, notes = ramp_curves(runs, settings.mass_kg)
    found = tuple(replace(curve, fits=fits(slid(curve), settings.fitting)) for curve in found)
    if any(curve.fits for curve in found):
        notes += (_SHARED_STROKES,)
    return Products(curves=found, notes=notes)


def _hysteresis(runs: Sequence[ScreenedRun], settings: Settings) -> Products:
    loops, notes = hysteresis(runs, settings.mass_kg)
    return Products(loops=loops, notes=notes)


def _step_levels(runs: Sequence[ScreenedRun], settings: Settings) -> Products:
    return Products(curves=curves(level_runs(runs)), levels=levels(runs, settings.mass_kg))


def _leakage(runs: Sequence[ScreenedRun], settings: Settings) -> Products:
    if settings.bench is None:
        return Products()
    return Products(leakages=leakage(runs, settings.bench))


def _verification(runs: Sequence[ScreenedRun], settings: Settings) -> Products:
    return Products()  # `hbench identify` compares these runs with its models


ANALYSES: Mapping[str, Callable[[Sequence[ScreenedRun], Settings], Products]] = {
    "steady_curve": _steady_curves,
    "ramp_curve": _ramp_curves,
    "hysteresis": _hysteresis,
    "step_levels": _step_levels,
    "leakage": _leakage,
    "verification": _verification,
}
