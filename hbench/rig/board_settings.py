"""The board's settings, from the bench file."""

from math import pi, sqrt

from hbench.config.bench import Bench, LoadFriction
from hbench.errors import ConfigError
from hbench.model.sensors import sensor_gains
from hbench.protocol.dictionary import LOAD_CONTROLS, SENSORS, SETTING_RANGES

STEPS_PER_COUNT = 16  # the board's sensor words are in sixteenths of an ADC count

_NO_FRICTION = LoadFriction.model_validate(
    {"coulomb": "0 N", "stiction": "0 N", "stribeck_velocity": "1 m/s", "viscous": "0 N s/m"}
)
_FORCE_BANDWIDTH = 0.05  # of the valve's: far enough from it for any position and pressure


def board_settings(bench: Bench) -> dict[str, float]:
    """Return every setting of the dictionary, in SI.

    Raises ``ConfigError`` for a value with which the board refuses to start.
    """
    settings = _settings(bench)
    for name, value in settings.items():
        low, high = SETTING_RANGES[name]
        if not low <= value <= high:
            raise ConfigError(
                f"bench '{bench.name}': the board's setting {name} = {value:.4g}; limits "
                f"{low:g} to {high:g}",
                "Check the units in the bench file.",
            )
    return settings


def _settings(bench: Bench) -> dict[str, float]:
    control, limits, gains = bench.controllers, bench.limits, sensor_gains(bench.sensors)
    acceleration = gains.get("acceleration", (0.0, 0.0))
    friction = control.load.friction or _NO_FRICTION
    return {
        **{f"gain_{name}": gains[name][0] / STEPS_PER_COUNT for name in SENSORS},
        **{f"offset_{name}": gains[name][1] for name in SENSORS},
        "velocity_gain_v_m": control.velocity.gain,
        "velocity_time_constant_s": control.velocity.time_constant,
        "force_gain_v_n": _force_gain(bench),
        "rod_gain_v_pa_s": control.rod_pressure.gain,
        "rod_time_constant_s": control.rod_pressure.time_constant,
        "piston_gain_v_pa_s": control.piston_pressure.gain,
        "piston_time_constant_s": control.piston_pressure.time_constant,
        "velocity_filter_s": control.velocity_filter,
        "pressure_filter_s": control.pressure_filter,
        "feedforward_on": float(control.feedforward.enabled),
        "feedforward_rod_v_s_m": control.feedforward.rod,
        "feedforward_piston_v_s_m": control.feedforward.piston,
        "voltage_limit_v": bench.valve.limit,
        "pressure_slew_pa_s": control.pressure_slew,
        "return_speed_m_s": control.return_speed,
        "acceleration_m_s2": control.acceleration,
        "travel_min_m": limits.travel_min,
        "travel_max_m": limits.travel_max,
        "pressure_max_pa": limits.pressure_max,
        "speed_max_m_s": limits.speed_max,
        "stopping_time_s": limits.stopping_time,
        "speed_error_max_m_s": limits.speed_error,
        "speed_error_time_s": limits.speed_error_time,
        "heartbeat_s": limits.heartbeat,
        "area_piston_m2": bench.test_cylinder.area_piston_m2,
        "area_rod_m2": bench.test_cylinder.area_rod_m2,
        "log_divider": control.rate / control.log_rate,
        "acceleration_gain_m_s2": acceleration[0] / STEPS_PER_COUNT,
        "acceleration_offset_m_s2": acceleration[1],
        "load_control": float(LOAD_CONTROLS.index(control.load.by)),
        "load_time_constant_s": control.load.time_constant,
        "load_area_piston_m2": bench.load_cylinder.area_piston_m2,
        "load_area_rod_m2": bench.load_cylinder.area_rod_m2,
        "load_coulomb_n": friction.coulomb,
        "load_stiction_n": friction.stiction,
        "load_stribeck_m_s": friction.stribeck_velocity,
        "load_viscous_n_s_m": friction.viscous,
    }


def _force_gain(bench: Bench) -> float:
    """Return the gain K [V/N] of the force loop that raises F_T on a resting piston.

    At rest the oil integrates the valve's flow to pressure (2.3, 2.4), here in the middle of the
    stroke with half the supply pressure across each edge of the valve:

        dF_T/dt = c u,   c = beta k_s sqrt(P_s / 2) (A_p / V_p + A_r / V_r)

    K = omega / c gives the loop the bandwidth omega.
    """
    cylinder, oil, valve = bench.test_cylinder, bench.oil, bench.valve
    flow = valve.gain * sqrt(2 / oil.density) * sqrt(bench.supply.pressure / 2)
    half = cylinder.stroke / 2
    piston, rod = cylinder.area_piston_m2, cylinder.area_rod_m2
    per_volume = piston / (cylinder.dead_volume_piston + piston * half)
    per_volume += rod / (cylinder.dead_volume_rod + rod * half)
    return _FORCE_BANDWIDTH * 2 * pi * valve.bandwidth / (oil.bulk_modulus * flow * per_volume)
