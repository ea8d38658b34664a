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

from hbench.analysis.rounding import ROUNDING
from hbench.model.effects.catalogue import EFFECTS
from hbench.model.parameters import PlantParameters
from hbench.reconcile.estimates import ParameterEstimates
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.measured.balances import BALANCES, FLOWS, BalanceModel
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.practice.fitted import (
    change,
    effect_in_practice,
    half_widths,
    without_effect,
)
from hbench.reconcile.practice.working_point import (
    READINGS,
    steady_balances,
    true_value,
    window_means,
    working_point,
)
from hbench.records import Change, EffectInPractice, WorkingPoint
from hbench.records.reconcile.diagnosis import REST_M_S
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
_Quantities = Mapping[str, np.ndarray]  # (w,) each, in the units above


def in_practice(
    measured: MeasuredCampaign, windows: GapMap, fits: Mapping[str, ParameterEstimates]
) -> tuple[WorkingPoint | None, tuple[EffectInPractice, ...]]:
    """Return the working point, and what each effect changes; ``fits`` are by its name."""
    point = working_point(measured.logs, windows)
    if point is not None:
        par = measured.balance_model(measured.start).par
        point = replace(point, residuals={**point.residuals, **_residual_signals(point, par)})
    effects = tuple(
        effect_in_practice(
            name, _changes(measured, windows, point, fits[name], name) if point else ()
        )
        for name in fits
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

    def at_point(hypothesis: Hypothesis) -> dict[str, float]:
        return {
            q: float(each[0]) for q, each in _at_point(measured, point, hypothesis, name).items()
        }

    fitted = estimates.hypothesis
    here, half = at_point(fitted), half_widths(measured.plant, estimates, name, at_point)
    along_logs = _along_logs(measured, windows, fitted, name)
    moving = np.abs(windows.v_m_s) > REST_M_S
    return tuple(
        change(quantity, UNITS[quantity], here[quantity], half[quantity], values[moving])
        for quantity, values in along_logs.items()
        if np.isfinite([here[quantity], *values[moving]]).any()  # else its channels are not logged
    )


def _at_point(
    measured: MeasuredCampaign, point: WorkingPoint, hypothesis: Hypothesis, name: str
) -> _Quantities:
    model, without = _with_and_without(measured, hypothesis, name)
    missing = _less(steady_balances(point, without), steady_balances(point, model))
    readings = {channel: np.array([getattr(point, f)]) for channel, f in READINGS.items()}
    v = np.array([point.v_m_s])
    return dict(_quantities(name, missing[None], readings, v, (model, without)))


def _along_logs(
    measured: MeasuredCampaign, windows: GapMap, hypothesis: Hypothesis, name: str
) -> _Quantities:
    missing = _less(
        measured.gap_map(without_effect(hypothesis, name), windows).difference,
        measured.gap_map(hypothesis, windows).difference,
    )
    readings = {channel: window_means(measured.logs, f) for channel, f in READINGS.items()}
    models = _with_and_without(measured, hypothesis, name)
    return dict(_quantities(name, missing, readings, windows.v_m_s, models))


def _less(without: np.ndarray, with_effect: np.ndarray) -> np.ndarray:
    """Return the difference of two evaluations; 0 where they differ by rounding alone."""
    same = np.isclose(without, with_effect, rtol=ROUNDING, atol=0.0)
    return np.where(same, 0.0, without - with_effect)


def _with_and_without(
    measured: MeasuredCampaign, hypothesis: Hypothesis, name: str
) -> tuple[BalanceModel, BalanceModel]:
    without = without_effect(hypothesis, name)
    return measured.balance_model(hypothesis), measured.balance_model(without)


def _quantities(
    name: str,
    missing: np.ndarray,
    readings: Mapping[str, np.ndarray],
    v: np.ndarray,
    models: tuple[BalanceModel, BalanceModel],
) -> Iterator[tuple[str, np.ndarray]]:
    """Yield what an effect changes; ``missing`` (w, 8) are the balances without it less with it.

    Forces are friction against the motion, flows are into a chamber.
    """
    row, (model, without) = EFFECTS[name], models
    si: dict[str, np.ndarray] = {}
    for channel, reading in readings.items():
        if model.sensors[channel] != without.sensors[channel]:
            true = true_value(reading, channel, model)
            scale, zero = without.sensors[channel]
            si[channel] = reading - (scale * true + zero)
    way = np.sign(v)
    for balance in row.balances:
        column = missing[:, BALANCES.index(balance)]
        si[balance] = way * column if balance.startswith("force") else column
    if "kinematics" in si:  # position's slope less the logged velocity
        si["kinematics"] = -si["kinematics"]
    if not row.of_sensor:
        si.update(_solved(si, v, model.par))
    for quantity in UNITS:
        if quantity in si:
            yield quantity, parse_unit(UNITS[quantity]).from_si(si[quantity])


def _residual_signals(point: WorkingPoint, par: PlantParameters) -> dict[str, float]:
    """Return the speed and the pressure that correspond to the residuals at a working point."""
    v = np.array([point.v_m_s])
    si = {name: np.array([value]) for name, value in point.residuals.items()}
    si["force_test"] = np.sign(v) * si["force_test"]
    return {quantity: float(value[0]) for quantity, value in _solved(si, v, par)}


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
