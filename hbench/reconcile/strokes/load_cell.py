"""Load cell's force in a model, at the velocity and the pressures of a steady stroke."""

from dataclasses import dataclass

import numpy as np

from hbench.config.stroke_model import StrokePlant
from hbench.model.build import friction_parameters, lone_cylinder
from hbench.model.effects.applied import friction_effects
from hbench.model.effects.catalogue import read_effects, with_effects
from hbench.model.friction.laws import steady_parts
from hbench.model.parameters import CylinderParameters, PlantParameters
from hbench.model.plant import P_TP, P_TR, V, bristles_end, n_states
from hbench.model.sensors import SensorParameters

_STROKE_M = 1.0  # arbitrary: the piston is at mid-stroke
_STEP = 1e-3  # finite difference of an effect's state
_P_TP, _P_TR, _FORCE = 1, 2, 6  # of sensors.SENSORS


@dataclass(frozen=True)
class Stroke:
    """Means over one steady stroke, or over the strokes of one trial."""

    t_s: float  # centre of its window
    v_m_s: float
    p_tp_pa: float
    p_tr_pa: float  # 0 for a plunger
    f_applied_n: float
    change_n: float = 0.0  # of F_T - F_applied over its window, in the sense of extension
    x_m: float = 0.0  # mean position
    travel_m: float = 0.0  # over its window


def plant_with_test_cylinder(plant: StrokePlant) -> PlantParameters:
    """Return plant parameters in which only the test cylinder has values of the model."""
    bore, friction = plant.test_cylinder, friction_parameters(plant.friction.test)
    areas = bore.area_piston_m2, bore.area_rod_m2
    test = CylinderParameters(*areas, _STROKE_M, 1e-3, 1e-3, 0.5 * _STROKE_M, friction)
    return with_effects(lone_cylinder(test), read_effects(plant.effects))


def load_cell_reading(stroke: Stroke, par: PlantParameters, sensors: SensorParameters) -> float:
    """Return the load cell's reading [N] in a model at a stroke's velocity and pressures."""
    p_tp, p_tr = (
        (logged - sensors.zero[i]) / sensors.per_unit[i]
        for i, logged in ((_P_TP, stroke.p_tp_pa), (_P_TR, stroke.p_tr_pa))
    )
    state = np.zeros(n_states(par))
    state[[V, P_TP, P_TR]] = stroke.v_m_s, p_tp, p_tr
    _set_to_equilibrium(state, par)
    level, _, more, _ = friction_effects(1.0, 1.0, state, par, par.effects, np.zeros(len(state)))
    dry, viscous = steady_parts(stroke.v_m_s, p_tp, p_tr, level, par.test.friction)
    force = p_tp * par.test.area_piston_m2 - p_tr * par.test.area_rod_m2 - dry - viscous - more
    return float(sensors.per_unit[_FORCE] * force + sensors.zero[_FORCE])


def _set_to_equilibrium(state: np.ndarray, par: PlantParameters) -> None:
    """Set the effects' own states to equilibrium by one Newton step.

    Their rates are linear in them at constant speed.
    """
    first = bristles_end(par)
    count = len(state) - first
    if not count:
        return

    def rates(stepped: int | None) -> np.ndarray:
        at, out = state.copy(), np.zeros(len(state))
        if stepped is not None:
            at[first + stepped] += _STEP
        friction_effects(1.0, 1.0, at, par, par.effects, out)
        return out[first:]

    initial = rates(None)
    if not initial.any():
        return
    slope = np.column_stack([(rates(i) - initial) / _STEP for i in range(count)])
    state[first:] -= np.linalg.lstsq(slope, initial, rcond=None)[0]
