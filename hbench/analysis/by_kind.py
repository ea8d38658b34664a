"""Analysis of screened runs by kind of experiment: curves, loops, levels and leakage.

``ANALYSES`` has a function for each value of the column ``analysis`` of ``KINDS``.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from hbench.analysis.curves.average import curves
from hbench.analysis.curves.breakaway import breakaways, dwell_laws
from hbench.analysis.curves.hysteresis import hysteresis
from hbench.analysis.curves.leakage import chamber_leakage
from hbench.analysis.curves.over_distance import distance_trends
from hbench.analysis.curves.ramp_tests import ramp_comparisons
from hbench.analysis.curves.ramps import ramp_curves, sliding
from hbench.analysis.curves.step_levels import level_runs, step_levels
from hbench.analysis.curves.surface import friction_surfaces
from hbench.analysis.fitting.fit import fits
from hbench.analysis.fitting.joint import fitted
from hbench.analysis.uncertainty.budget import with_instruments
from hbench.config.fitting import Fitting
from hbench.config.setup import Setup
from hbench.parallel.forked import map_forked
from hbench.records import (
    KINDS,
    Breakaway,
    Curve,
    Leakage,
    Level,
    Loop,
    Motions,
    ScreenedRun,
)

_SHARED_STROKES = (
    "the points of a ramp's curve share their strokes, but the intervals of its fitted "
    "parameters assume independent points: they are too narrow"
)
_UNKNOWN_MASS = "the test side's mass is not known: friction of moving runs includes its inertia"
_NO_CHAMBERS = (
    "leakage needs volumes and bulk modulus: add 'chambers' to the import map, or a bench file "
    "bench.yaml beside runs.csv, and import again"
)
_NO_STROKE = (
    "leakage needs the stroke: add 'stroke' to the cylinder in the import map, or a column "
    "stroke_m to runs.csv, and import again"
)
_MANY_RUNS = 100  # the fits of fewer take less time than a fork
_WITH_INERTIA = {"ramp_curve", "hysteresis", "step_levels"}  # analyses that subtract m_T a


@dataclass(frozen=True)
class Settings:
    """Set-up and fit settings of an analysis."""

    setup: Setup
    fitting: Fitting

    @property
    def mass_kg(self) -> float:
        """Mass of the test side; with 0, for an unknown mass, friction includes the inertia."""
        return self.setup.test_mass_kg or 0.0


@dataclass(frozen=True)
class AnalysisProducts:
    """Results of one analysis; curves without the instruments' uncertainty."""

    curves: tuple[Curve, ...] = ()
    loops: tuple[Loop, ...] = ()
    levels: tuple[Level, ...] = ()
    leakages: tuple[Leakage, ...] = ()
    breakaways: tuple[Breakaway, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class AnalysedRuns:
    """Results of all analyses of a campaign."""

    steady: tuple[Curve, ...]
    moving: tuple[Curve, ...]  # of ramps and of the levels of steps
    motions: Motions
    notes: tuple[str, ...]


def analyse_runs(screened: Iterable[ScreenedRun], setup: Setup, fitting: Fitting) -> AnalysedRuns:
    """Analyse the runs of each kind of experiment, and compare ramps with steady curves."""
    screened = tuple(screened)
    runs: dict[str, list[ScreenedRun]] = defaultdict(list)
    for run in screened:
        runs[KINDS[run.run.plan.kind].analysis].append(run)
    settings = Settings(setup, fitting)
    products = {name: analyse(runs[name], settings) for name, analyse in ANALYSES.items()}
    instruments = setup.instruments
    steady = tuple(
        with_instruments(curve, instruments) for curve in products["steady_curve"].curves
    )
    ramps = products["ramp_curve"].curves
    moving = (
        curve for name in products if name != "steady_curve" for curve in products[name].curves
    )
    broken_away = products["breakaway"].breakaways
    leakages = products["leakage"].leakages
    accepted = {name for name in runs if any(run.accepted for run in runs[name])}
    return AnalysedRuns(
        steady=steady,
        moving=tuple(with_instruments(curve, instruments) for curve in moving),
        motions=Motions(
            comparisons=ramp_comparisons((*steady, *map(sliding, ramps))),
            loops=tuple(loop for product in products.values() for loop in product.loops),
            levels=tuple(level for product in products.values() for level in product.levels),
            leakages=leakages,
            breakaways=broken_away,
            dwell_laws=dwell_laws(broken_away),
            surfaces=friction_surfaces(steady),
            over_distance=distance_trends(screened, steady, broken_away, leakages),
        ),
        notes=(
            *(note for product in products.values() for note in product.notes),
            *([_UNKNOWN_MASS] if setup.test_mass_kg is None and accepted & _WITH_INERTIA else []),
        ),
    )


def _steady_curves(runs: Sequence[ScreenedRun], settings: Settings) -> AnalysisProducts:
    reach = settings.setup.reach
    apply = map_forked if len(runs) > _MANY_RUNS else map
    return AnalysisProducts(
        curves=tuple(apply(lambda curve: fitted(curve, settings.fitting, reach), curves(runs)))
    )


def _ramp_curves(runs: Sequence[ScreenedRun], settings: Settings) -> AnalysisProducts:
    ramps, notes = ramp_curves(runs, settings.mass_kg)
    how, reach = settings.fitting, settings.setup.reach
    ramps = tuple(replace(curve, fits=fits(sliding(curve), how, reach)) for curve in ramps)
    if any(curve.fits for curve in ramps):
        notes += (_SHARED_STROKES,)
    return AnalysisProducts(curves=ramps, notes=notes)


def _hysteresis(runs: Sequence[ScreenedRun], settings: Settings) -> AnalysisProducts:
    loops, notes = hysteresis(runs, settings.mass_kg)
    return AnalysisProducts(loops=loops, notes=notes)


def _step_levels(runs: Sequence[ScreenedRun], settings: Settings) -> AnalysisProducts:
    return AnalysisProducts(
        curves=curves(level_runs(runs)), levels=step_levels(runs, settings.mass_kg)
    )


def _leakage(runs: Sequence[ScreenedRun], settings: Settings) -> AnalysisProducts:
    holds, chambers = [run for run in runs if run.accepted], settings.setup.chambers
    notes = []
    if holds and chambers is None:
        notes.append(_NO_CHAMBERS)
    if any(run.run.plan.specimen.stroke_m is None for run in holds):
        notes.append(_NO_STROKE)
    leakages = () if chambers is None else chamber_leakage(holds, chambers)
    return AnalysisProducts(leakages=leakages, notes=tuple(notes))


def _breakaways(runs: Sequence[ScreenedRun], settings: Settings) -> AnalysisProducts:
    return AnalysisProducts(breakaways=breakaways(runs, settings.setup.instruments))


def _nothing(runs: Sequence[ScreenedRun], settings: Settings) -> AnalysisProducts:
    return AnalysisProducts()


ANALYSES: Mapping[str, Callable[[Sequence[ScreenedRun], Settings], AnalysisProducts]] = {
    "steady_curve": _steady_curves,
    "ramp_curve": _ramp_curves,
    "hysteresis": _hysteresis,
    "step_levels": _step_levels,
    "leakage": _leakage,
    "breakaway": _breakaways,
    "zero_check": _nothing,  # zeros are subtracted from all runs before the screening
    "verification": _nothing,  # `hbench identify` compares these runs with its models
}
