"""Open-loop replay: a model simulates measured runs under their commands and supply pressure.

The model starts from a run's first record and receives only the commands, so its position drifts
with every flow error. The errors of the modelled sensors are removed from its inputs and added to
its outputs, as is the lag of the board's velocity filter.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hbench.analysis.screening.calibrate import RUN_FIELDS
from hbench.config.bench import Bench, Plant
from hbench.model.effects.catalogue import changed_by, read_effects
from hbench.model.sensors import SENSORS, sensor_gains, sensor_parameters
from hbench.reconcile.measured.balances import balance_model
from hbench.reconcile.measured.comparable_runs import incomplete_reason
from hbench.reconcile.measured.window_signals import INPUTS, OPEN_LOOP_CHANNELS, SIGNALS, open_loop
from hbench.records import Run, SignalError

_UNITS = {"p": "bar", "f": "N", "v": "mm/s", "x": "mm"}
_PER_SI = {"bar": 1e-5, "N": 1.0, "mm/s": 1e3, "mm": 1e3}
_OUTPUTS = tuple(name for name in SIGNALS if name not in INPUTS and name != "friction")


def replay_runs(
    runs: Sequence[Run], bench: Bench, plant: Plant
) -> tuple[tuple[Run, ...], tuple[str, ...]]:
    """Return the runs as simulated with ``plant`` on ``bench``, and the reasons of omitted runs."""
    model = balance_model(bench, plant)
    errors = _sensor_errors(bench, plant)
    corrections = {name: (1 / a, -b / a) for name, (a, b) in errors.items()}
    replays, omitted = [], []
    for run in runs:
        reason = _omission_reason(run)
        if not reason:
            simulated = open_loop(_with_linear_maps(run, corrections), model)
            replay = replace(_with_linear_maps(simulated, errors), p_s_pa=run.p_s_pa)
            if all(np.isfinite(getattr(replay, RUN_FIELDS[name])).all() for name in _OUTPUTS):
                replays.append(replay)
                continue
            reason = "the simulation diverges"
        omitted.append(f"run {run.plan.run}: {reason}")
    return tuple(replays), tuple(omitted)


def signal_errors(measured: Sequence[Run], replays: Sequence[Run]) -> tuple[SignalError, ...]:
    """Return the root mean square error of each signal of the replays, in a bench's units."""
    measured_by_run = {run.plan.run: run for run in measured}
    errors = []
    for name in _OUTPUTS:
        unit = _UNITS[name[0]]
        squares = {}
        for replay in replays:
            logged = getattr(measured_by_run[replay.plan.run], RUN_FIELDS[name])
            if logged is not None:
                error = _PER_SI[unit] * (getattr(replay, RUN_FIELDS[name]) - logged)
                squares[replay.plan.run] = error**2
        if squares:
            worst = max(squares, key=lambda run: squares[run].mean())
            pooled = np.concatenate(list(squares.values()))
            all_runs, worst_run = _root_mean(pooled), _root_mean(squares[worst])
            errors.append(SignalError(name, unit, all_runs, worst_run, worst))
    return tuple(errors)


def _root_mean(squares: np.ndarray) -> float:
    return float(np.sqrt(squares.mean()))


def _omission_reason(run: Run) -> str:
    fields = [RUN_FIELDS[name] for name in OPEN_LOOP_CHANNELS]
    missing = [field for field in fields if getattr(run, field) is None]
    if missing:
        return f"the model needs {', '.join(missing)}"
    return incomplete_reason(run)


def _sensor_errors(bench: Bench, plant: Plant) -> dict[str, tuple[float, float]]:
    """Return each channel's reading as a * true value + b: (a, b) by channel."""
    own = sensor_parameters(plant.sensors or bench.sensors)
    actual = changed_by("sensors", own, read_effects(plant.effects))
    assumed = sensor_gains(bench.sensors)
    return {
        name: (assumed[name][0] * per_unit, assumed[name][0] * zero + assumed[name][1])
        for name, per_unit, zero in zip(SENSORS, actual.per_unit, actual.zero, strict=True)
    }


def _with_linear_maps(run: Run, maps: Mapping[str, tuple[float, float]]) -> Run:
    """Return a run with a * value + b in the sensors' channels."""
    by_field = {RUN_FIELDS[name]: coefficients for name, coefficients in maps.items()}
    return replace(
        run,
        **{
            field: a * getattr(run, field) + b
            for field, (a, b) in by_field.items()
            if getattr(run, field) is not None
        },
    )
