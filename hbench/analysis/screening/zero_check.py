"""Zeros of the sensors from zero checks, and their correction.

With the supply off and all chambers at the pressure p_0, a transducer that shows p has the zero
error p - p_0; a load cell without force shows its own. A zero is a mean over the time with closed
valves. Between two checks it is taken as a straight line over time, before the first and after the
last as constant.

A corrected reading still has the error of p_0, which all transducers share. It may also be off by
the drift from check to check, if the zero moved at once, not along the line. Both count as limits
(rectangular; JCGM 100, 4.3.7). The instruments' class stays in the budget as it is: it also covers
gain, linearity and hysteresis.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from hbench.config.bench import Bench
from hbench.config.sensors import ErrorSource, Instrument, Instruments
from hbench.model.sensors import sensor_gains
from hbench.records import Run, Zero, ZeroCheck

Zeros = Mapping[str, tuple[np.ndarray, np.ndarray]]  # times and errors, (n,) each, by channel
CHAMBERS = ("p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa")  # which are vented, not the supply
_FORCE = "f_applied_n"
_SETTLE_S = 0.3  # after the valves have closed
_SOURCE = "zero check"


def closed_part(run: Run) -> slice:
    """Return the samples with closed, settled valves; all of a run without a planned motion."""
    segments = run.plan.motion.segments if run.plan.motion else ()
    begin = sum(segment.duration_s for segment in segments if segment.vented)
    first = int(np.searchsorted(run.t_s, begin + _SETTLE_S)) if segments else 0
    return slice(first, None)


def zero_check(run: Run, time_s: float | None, bench: Bench) -> ZeroCheck | None:
    """Return the zeros that an accepted run of a zero check found; None without a reference.

    A sensor that reads the lowest value of its converter, within one count, may be off by more: the
    part of its error that shows is subtracted, and the rest is not known.
    """
    level, instruments = run.plan.level, bench.instruments
    if level is None:
        return None
    closed, gains = closed_part(run), sensor_gains(bench.sensors)
    zeros = []
    for channel in (*CHAMBERS, *([_FORCE] if level.load_cell_free else [])):
        values = getattr(run, channel)
        if values is None:
            continue
        mean, (count, lowest) = float(values[closed].mean()), gains[channel.rpartition("_")[0]]
        of_force = channel == _FORCE
        instrument = instruments.force if of_force else instruments.pressure
        expected = 0.0 if of_force else level.pressure_pa
        clipped = mean < lowest + count
        zeros.append(Zero(channel, mean - expected, instrument.largest, clipped))
    return ZeroCheck(
        run.plan.run, time_s, level.pressure_pa, level.limit_pa, tuple(zeros), run.plan.kind
    )


def zeros_over_time(checks: Sequence[ZeroCheck]) -> Zeros:
    """Return the times (n,) and errors (n,) of each channel; without times, in their order."""
    times = [float(number) if c.time_s is None else c.time_s for number, c in enumerate(checks)]
    found: dict[str, list[tuple[float, float]]] = {}
    for time, check in sorted(zip(times, checks, strict=True), key=lambda pair: pair[0]):
        for zero in check.zeros:
            found.setdefault(zero.channel, []).append((time, zero.error))
    return {channel: tuple(np.array(pairs).T) for channel, pairs in found.items()}


def corrected(run: Run, zeros: Zeros, time_s: float | None) -> Run:
    """Return a run with the zeros subtracted, as they were at its time [s]."""
    changes = {}
    for channel, (times, errors) in zeros.items():
        values = getattr(run, channel)
        if values is not None:
            now = float(errors.mean()) if time_s is None else np.interp(time_s, times, errors)
            changes[channel] = values - now
    return replace(run, **changes)


def with_zero_checks(
    instruments: Instruments | None, checks: Sequence[ZeroCheck]
) -> Instruments | None:
    """Return the instruments with what the correction of their zeros leaves."""
    if instruments is None or not checks:
        return instruments
    zeros = zeros_over_time(checks)
    drifts = {channel: float(np.ptp(errors)) for channel, (_, errors) in zeros.items()}
    pressure = {
        "zero reference": (max(check.pressure_limit_pa for check in checks), True),
        "zero drift": (
            max((drifts[name] for name in CHAMBERS if name in drifts), default=0.0),
            False,
        ),
    }
    force = {"zero drift": (drifts[_FORCE], False)} if _FORCE in drifts else {}
    return instruments.model_copy(
        update={
            "pressure": _with_sources(instruments.pressure, pressure),
            "force": _with_sources(instruments.force, force),
        }
    )


def _with_sources(instrument: Instrument, limits: Mapping[str, tuple[float, bool]]) -> Instrument:
    """Add sources of error by name: their limit [SI], and whether all transducers share it."""
    sources = {
        name: ErrorSource(
            tolerance=limit / instrument.full_scale,
            of="full_scale",
            distribution="rectangular",
            common=common,
            source=_SOURCE,
        )
        for name, (limit, common) in limits.items()
    }
    return instrument.model_copy(update={"further": {**instrument.further, **sources}})


def checked_zeros(
    runs: Iterable[Run], times_s: Mapping[str, float], bench: Bench
) -> tuple[ZeroCheck, ...]:
    """Return the zeros of the accepted checks ``runs``; ``times_s`` are their starts by run."""
    found = (zero_check(run, times_s.get(run.plan.run), bench) for run in runs)
    return tuple(check for check in found if check is not None)
