"""Changes that an effect makes: at the working point, and along the measured logs.

Each balance is evaluated with the effect at its fitted coefficients and without it; all else in the
model is the same. The difference is what the effect adds to that balance. Solved for one signal, at
the measured values of the others, it is a change of

    speed       the fed chamber's flow over its area, at the same commands and pressures
    pressure    the friction over the fed chamber's area, at the same speed and load

The fed chamber is Tp while the piston extends and Tr while it retracts. An error of a sensor
changes neither, but its own reading, and the friction that is computed from it.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from hbench.analysis.statistics.student import student_factor
from hbench.model.effects.catalogue import EFFECTS, lookalikes
from hbench.model.parameters import PlantParameters
from hbench.reconcile.estimates import ParameterEstimates, whole_dof
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.measured.balances import BALANCES, FLOWS, BalanceModel
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.nuisance import nuisances
from hbench.reconcile.practice.working_point import (
    READINGS,
    steady_balances,
    true_value,
    window_means,
    working_point,
)
from hbench.reconcile.steps import stepped
from hbench.records import Change, EffectInPractice, WorkingPoint
from hbench.records.diagnosis import REST_M_S
from hbench.units import parse_unit

UNITS = {  # of each quantity that an effect may change, in the order in which they are listed
    **{channel: "N" if channel == "f_applied" else "bar" for channel in READINGS},
    **dict.fromkeys(FLOWS, "l/min"),
    "speed": "mm/s",
    "force_test": "N",
    "force_load": "N",
    "pressure": "bar",
    "supply": "bar",
    "kinematics": "mm/s",
}
_LARGEST = 0.95  # quantile of the magnitudes that counts as the largest
_STEP = 0.05  # of a typical size, for derivatives by the coefficients
_Quantities = Mapping[str, np.ndarray]  # (w,) each, in the units above


def in_practice(
    measured: MeasuredCampaign, windows: GapMap, fits: Mapping[str, ParameterEstimates]
) -> tuple[WorkingPoint | None, tuple[EffectInPractice, ...]]:
    """Return the working point, and what each effect changes; ``fits`` are by its name."""
    point = working_point(measured.logs, windows)
    effects = tuple(
        EffectInPractice(
            name=name,
            changes=_changes(measured, windows, point, estimates, name) if point else (),
            inspect=EFFECTS[name].inspect,
            repair=EFFECTS[name].repair,
            lookalikes={
                other: f"{separation.kind}: {separation.why}"
                for other, separation in lookalikes(name).items()
            },
        )
        for name, estimates in fits.items()
    )
    return point, effects


def _changes(
    measured: MeasuredCampaign,
    windows: GapMap,
    point: WorkingPoint,
    estimates: ParameterEstimates,
    name: str,
) -> tuple[Change, ...]:
    """Return the quantities that an effect changes, with the intervals of its coefficients."""
    fitted = estimates.hypothesis(estimates.beta)
    at_point = _at_point(measured, point, fitted, name)
    half_widths = _half_widths(measured, point, estimates, fitted, name, at_point)
    along_logs = _along_logs(measured, windows, fitted, name)
    moving = np.abs(windows.v_m_s) > REST_M_S
    changes = []
    for quantity, values in along_logs.items():
        here, half = float(at_point[quantity][0]), half_widths[quantity]
        changes.append(
            Change(
                quantity=quantity,
                unit=UNITS[quantity],
                at_point=here,
                ci95=(here - half, here + half) if np.isfinite(half) else None,
                along=_root_mean_square(values[moving]),
                largest=_largest(values),
            )
        )
    return tuple(change for change in changes if change.largest > 0 or change.at_point)


def _half_widths(
    measured: MeasuredCampaign,
    point: WorkingPoint,
    estimates: ParameterEstimates,
    fitted: Hypothesis,
    name: str,
    at_point: _Quantities,
) -> dict[str, float]:
    """Return the half widths of the 95 % intervals: sqrt(g' C g) times Student's factor.

    g are derivatives by the effect's coefficients that are not at a bound, C their covariance. nan
    where all are at their bounds.
    """
    free = [key for key, p in estimates.of_effect(name).items() if p.at_bound is None]
    if not free:
        return dict.fromkeys(at_point, float("nan"))
    columns = [estimates.model.column((name, key)) for key in free]
    places = [estimates.chosen.index(column) for column in columns]
    covariance = estimates.covariance[np.ix_(places, places)]
    factor = min(estimates.degrees_of_freedom((name, key)) for key in free)
    slopes = []
    for key in free:
        at_step, share = stepped(fitted, f"{name}.{key}", nuisances(measured.plant), _STEP)
        after = _at_point(measured, point, at_step, name)
        slopes.append({q: float(after[q][0] - at_point[q][0]) / share for q in at_point})
    half_widths = {}
    for quantity in at_point:
        g = np.array([slope[quantity] for slope in slopes])
        half_widths[quantity] = student_factor(whole_dof(factor)) * float(
            np.sqrt(g @ covariance @ g)
        )
    return half_widths


def _at_point(
    measured: MeasuredCampaign, point: WorkingPoint, hypothesis: Hypothesis, name: str
) -> _Quantities:
    model, without = _with_and_without(measured, hypothesis, name)
    change = steady_balances(point, without) - steady_balances(point, model)
    readings = {channel: np.array([getattr(point, f)]) for channel, f in READINGS.items()}
    v = np.array([point.v_m_s])
    return dict(_quantities(name, change[None], readings, v, (model, without)))


def _along_logs(
    measured: MeasuredCampaign, windows: GapMap, hypothesis: Hypothesis, name: str
) -> _Quantities:
    change = (
        measured.gap_map(_without(hypothesis, name), windows).difference
        - measured.gap_map(hypothesis, windows).difference
    )
    readings = {channel: window_means(measured.logs, f) for channel, f in READINGS.items()}
    models = _with_and_without(measured, hypothesis, name)
    return dict(_quantities(name, change, readings, windows.v_m_s, models))


def _with_and_without(
    measured: MeasuredCampaign, hypothesis: Hypothesis, name: str
) -> tuple[BalanceModel, BalanceModel]:
    without = _without(hypothesis, name)
    return measured.balance_model(hypothesis), measured.balance_model(without)


def _without(hypothesis: Hypothesis, name: str) -> Hypothesis:
    """Return a hypothesis with the effect's coefficients at their defaults."""
    rows = EFFECTS[name].coefficients.items()
    neutral = {key: row.to_si(row.default) for key, row in rows}
    return replace(hypothesis, effects={**hypothesis.effects, name: neutral})


def _quantities(
    name: str,
    change: np.ndarray,
    readings: Mapping[str, np.ndarray],
    v: np.ndarray,
    models: tuple[BalanceModel, BalanceModel],
) -> Iterator[tuple[str, np.ndarray]]:
    """Yield what an effect changes; ``change`` (w, 8) is of the balances, without less with it.

    Forces are friction against the motion, flows are into a chamber.
    """
    row, (model, without) = EFFECTS[name], models
    si: dict[str, np.ndarray] = {}
    for channel, reading in readings.items():
        if model.sensors[channel] != without.sensors[channel]:
            si[channel] = true_value(reading, channel, without) - true_value(
                reading, channel, model
            )
    way = np.sign(v)
    for balance in row.balances:
        column = change[:, BALANCES.index(balance)]
        si[balance] = way * column if balance.startswith("force") else column
    if "kinematics" in si:  # position's slope less the logged velocity
        si["kinematics"] = -si["kinematics"]
    if not row.of_sensor:
        si.update(_solved(si, v, model.par))
    for quantity in UNITS:
        if quantity in si:
            yield quantity, parse_unit(UNITS[quantity]).from_si(si[quantity])


def _solved(
    si: Mapping[str, np.ndarray], v: np.ndarray, par: PlantParameters
) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the changes of speed and pressure that correspond to those of flow and friction."""
    extends, moves = v > 0, np.abs(v) > REST_M_S
    area = np.where(extends, par.test.area_piston_m2, par.test.area_rod_m2)
    if "flow_tp" in si and "flow_tr" in si:
        fed = np.where(extends, si["flow_tp"], si["flow_tr"])
        yield "speed", np.where(moves, fed / area, np.nan)
    if "force_test" in si:
        yield "pressure", np.where(moves, si["force_test"] / area, np.nan)


def _root_mean_square(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else float("nan")


def _largest(values: np.ndarray) -> float:
    known = np.abs(values[np.isfinite(values)])
    return float(np.quantile(known, _LARGEST)) if len(known) else float("nan")
