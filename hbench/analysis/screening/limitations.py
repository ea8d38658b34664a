"""Notes on quantities that missing channels or files make impossible, each with a remedy."""

from collections import Counter
from collections.abc import Sequence

from hbench.analysis.screening.friction_channels import missing_friction_channels
from hbench.config.sensors import Instruments
from hbench.records import KINDS, EfficiencyCurve, Run, ScreenedRun

_CHAMBER = "if the chamber is open to air or tank, give its pressure as a constant in the map"
_REMEDIES = {
    "p_tp_pa": _CHAMBER,
    "p_tr_pa": _CHAMBER,
    "f_applied_n": "if the load is a known weight, give it as a constant in the map",
}


def not_computed(
    screened: Sequence[ScreenedRun],
    curves: Sequence[EfficiencyCurve],
    instruments: Instruments | None,
) -> tuple[str, ...]:
    """Return notes on the quantities that the measurement does not permit."""
    return (
        *_friction(screened),
        *_efficiency(curves),
        *_tolerances(curves, instruments),
        *_steps(screened, instruments),
        *_far(screened, instruments),
    )


def overdue(instruments: Instruments | None, started: str) -> tuple[str, ...]:
    """Return notes on instruments whose calibration was due before ``started`` (ISO 8601).

    None if ``started`` is empty: the date of the measurement is not known.
    """
    if instruments is None or not started:
        return ()
    return tuple(
        f"calibration of {name}: due {due}, before the measurement of {started[:10]}"
        for name, instrument in (
            ("the load cell", instruments.force),
            ("the pressure transducers", instruments.pressure),
        )
        if (due := instrument.calibration.due) is not None and str(due) < started[:10]
    )


def _friction(screened: Sequence[ScreenedRun]) -> list[str]:
    rejected = [r.run for r in screened if not r.accepted and _moves(r.run)]
    counts = Counter(tuple(missing_friction_channels(run)) for run in rejected if len(run.t_s))
    notes = []
    for missing, runs in counts.items():
        if missing:
            remedies = "; ".join(dict.fromkeys(_REMEDIES[name] for name in missing))
            notes.append(
                f"no friction and no efficiency of {runs} of {len(screened)} runs: "
                f"{', '.join(missing)} not measured; {remedies}. "
                "runs.csv contains their speeds and measured values"
            )
    return notes


def _steps(screened: Sequence[ScreenedRun], instruments: Instruments | None) -> list[str]:
    """Report channels whose values are logged in steps that matter for friction."""
    found = [run for run in screened if run.accepted and run.means and run.means.u_steps]
    if not found:
        return []
    channels = dict.fromkeys(name for run in found if run.means for name in run.means.u_steps)
    most = max(map(_half_step_n, found))
    contained = "is part of U" if instruments else "is not part of the intervals"
    return [
        f"resolution: {', '.join(channels)} logged in steps that change friction by up to "
        f"+-{most:.3g} N in {len(found)} of {len(screened)} runs; this {contained}. Log more digits"
    ]


def _far(screened: Sequence[ScreenedRun], instruments: Instruments | None) -> list[str]:
    """Report samples far from all others that matter for the friction of accepted runs."""
    found = [r.means for r in screened if r.accepted and r.means and r.means.far_samples]
    if not found:
        return []
    most = max(found, key=lambda means: abs(means.far_shift_n))
    samples = sum(means.far_samples for means in found)
    contained = "is part of U" if instruments else "is not part of the intervals"
    return [
        f"{samples} samples in {len(found)} of {len(screened)} runs are far from all others, such "
        "as dropouts of a sensor or a number that stands for no value. They change mean friction "
        f"by up to {most.far_shift_n:+.3g} N; this {contained}. Find their cause; cells without a "
        "value are left empty in a log"
    ]


def _half_step_n(run: ScreenedRun) -> float:
    """Return the largest error of friction [N] by the steps of all channels together."""
    specimen = run.run.plan.specimen
    areas = {"p_tp_pa": specimen.area_piston_m2, "p_tr_pa": specimen.area_rod_m2}
    u_steps = run.means.u_steps if run.means else {}
    return float(3**0.5 * sum(areas.get(name, 1.0) * u for name, u in u_steps.items()))


def _moves(run: Run) -> bool:
    return not KINDS[run.plan.kind].is_at_rest


def _efficiency(curves: Sequence[EfficiencyCurve]) -> list[str]:
    points = [point for curve in curves for point in curve.points]
    if not points or any(point.efficiency is not None for point in points):
        return []
    return [f"no efficiency at any point; reason at the first: {points[0].reason}"]


def _tolerances(curves: Sequence[EfficiencyCurve], instruments: Instruments | None) -> list[str]:
    if instruments is not None or not any(curve.points for curve in curves):
        return []
    return [
        "U does not contain the instruments and the efficiency has no sigma: the tolerances of "
        "the instruments are not known (instruments in an import map or a bench file)"
    ]
