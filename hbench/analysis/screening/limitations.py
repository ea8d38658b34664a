"""What a bench's channels and files are not enough for, each said once, with what would help."""

from collections import Counter
from collections.abc import Sequence

from hbench.analysis.screening.screen import missing_channels
from hbench.config.sensors import Instruments
from hbench.records import KINDS, EfficiencyCurve, Run, ScreenedRun

_CHAMBER = "where its chamber is open to air or tank, give its pressure as a constant of the map"
_HELP = {
    "p_tp_pa": _CHAMBER,
    "p_tr_pa": _CHAMBER,
    "f_applied_n": "where a known weight is the load, give it as a constant of the map",
}


def not_computed(
    screened: Sequence[ScreenedRun],
    curves: Sequence[EfficiencyCurve],
    instruments: Instruments | None,
) -> tuple[str, ...]:
    """Return what can't be computed from all that was measured, and why."""
    return (*_friction(screened), *_efficiency(curves), *_tolerances(curves, instruments))


def _friction(screened: Sequence[ScreenedRun]) -> list[str]:
    rejected = [one.run for one in screened if not one.accepted and _moves(one.run)]
    lacking = Counter(tuple(missing_channels(run)) for run in rejected if len(run.t_s))
    notes = []
    for missing, runs in lacking.items():
        if missing:
            helps = "; ".join(dict.fromkeys(_HELP[name] for name in missing))
            notes.append(
                f"no friction and no efficiency of {runs} of {len(screened)} runs: "
                f"{', '.join(missing)} not measured; {helps}. "
                "Their speeds and what was measured stand in runs.csv"
            )
    return notes


def _moves(run: Run) -> bool:
    return not KINDS[run.plan.kind].is_at_rest


def _efficiency(curves: Sequence[EfficiencyCurve]) -> list[str]:
    points = [point for curve in curves for point in curve.points]
    if not points or any(point.efficiency is not None for point in points):
        return []
    return [f"no efficiency at any point; the first: {points[0].reason}"]


def _tolerances(curves: Sequence[EfficiencyCurve], instruments: Instruments | None) -> list[str]:
    if instruments is not None or not any(curve.points for curve in curves):
        return []
    return [
        "no U95 of friction and no sigma of the efficiency: without a bench file the tolerances of "
        "the instruments are not known; intervals are those of the trials alone"
    ]
