"""Measured runs made again by a model in open loop: under their own commands and supply pressure.

The model begins with a run's first record and knows nothing of what follows but the commands, so
position drifts with every error of the flows. Errors of its sensors are taken from what the model
is given, and are in what it shows; so is the lag of the board's velocity filter.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hbench.analysis.screening.calibrate import FIELDS
from hbench.config.bench import Bench, Plant
from hbench.errors import DataError
from hbench.model.effects.catalogue import changed_by, read_effects
from hbench.model.sensors import CHANNELS, sensor_gains, sensor_parameters
from hbench.model.simulated_bench import as_run
from hbench.reconcile.measured.balances import incomplete, model
from hbench.reconcile.measured.weak import sampling
from hbench.reconcile.measured.window_signals import INPUTS, NEEDED, SIGNALS, open_loop
from hbench.records import Off, Run

_UNITS = {"p": "bar", "f": "N", "v": "mm/s", "x": "mm"}
_PER_SI = {"bar": 1e-5, "N": 1.0, "mm/s": 1e3, "mm": 1e3}
_SHOWN = tuple(name for name in SIGNALS if name not in INPUTS and name != "friction")


def replayed(
    runs: Sequence[Run], bench: Bench, plant: Plant
) -> tuple[tuple[Run, ...], tuple[str, ...]]:
    """Return the runs as ``plant`` makes them on ``bench``, and why others are left out."""
    known = model(as_run(bench, plant), plant)
    errors = _sensor_errors(bench, plant)
    true = {name: (1 / a, -b / a) for name, (a, b) in errors.items()}
    made, left_out = [], []
    for run in runs:
        why = _why_not(run)
        if not why:
            shown = replace(
                _through(open_loop(_through(run, true), known), errors), p_s_pa=run.p_s_pa
            )
            if all(np.isfinite(getattr(shown, FIELDS[name])).all() for name in _SHOWN):
                made.append(shown)
                continue
            why = "the model goes astray beyond all bounds"
        left_out.append(f"run {run.plan.run}: {why}")
    return tuple(made), tuple(left_out)


def off_by(measured: Sequence[Run], made: Sequence[Run]) -> tuple[Off, ...]:
    """Return how far off each signal of the runs that were made is, in a bench's units."""
    own = {run.plan.run: run for run in measured}
    found = []
    for name in _SHOWN:
        unit = _UNITS[name[0]]
        squares = {}
        for run in made:
            seen = getattr(own[run.plan.run], FIELDS[name])
            if seen is not None:
                lacks = _PER_SI[unit] * (getattr(run, FIELDS[name]) - seen)
                squares[run.plan.run] = lacks**2
        if squares:
            worst = max(squares, key=lambda run: squares[run].mean())
            every = np.concatenate(list(squares.values()))
            found.append(Off(name, unit, _root(every), _root(squares[worst]), worst))
    return tuple(found)


def _root(squares: np.ndarray) -> float:
    return float(np.sqrt(squares.mean()))


def _why_not(run: Run) -> str:
    lacks = [FIELDS[name] for name in NEEDED if getattr(run, FIELDS[name]) is None]
    if lacks:
        return f"the model needs {', '.join(lacks)}"
    if why := incomplete(run):
        return why
    try:
        sampling(run)
    except DataError as error:
        return error.message
    return ""


def _sensor_errors(bench: Bench, plant: Plant) -> dict[str, tuple[float, float]]:
    """Return what each channel shows: a times the true value, and b."""
    own = changed_by("sensors", sensor_parameters(plant.sensors), read_effects(plant.effects))
    told = sensor_gains(bench.sensors)
    return {
        name: (told[name][0] * per_unit, told[name][0] * zero + told[name][1])
        for name, per_unit, zero in zip(CHANNELS, own.per_unit, own.zero, strict=True)
    }


def _through(run: Run, lines: Mapping[str, tuple[float, float]]) -> Run:
    """Return a run with a * value + b in the sensors' channels."""
    known = {FIELDS[name]: line for name, line in lines.items()}
    return replace(
        run,
        **{
            field: a * getattr(run, field) + b
            for field, (a, b) in known.items()
            if getattr(run, field) is not None
        },
    )
