"""Steps of a log: the uncertainty of a channel's mean where its values are rounded coarsely.

Values with noise of the standard deviation s, rounded to steps q, have a mean whose error depends
on the place x of the true mean between two steps:

    error = q / pi exp(-2 pi^2 s^2 / q^2) sin(2 pi x / q) + higher harmonics
    u     = q / sqrt 12 exp(-2 pi^2 s^2 / q^2)

(B. Widrow and I. Kollar, Quantization Noise, 2008, 4.3; JCGM 100, F.2.2.1 without noise). Noise of
half a step is enough to average the rounding out. s is that of the samples less the rounding's own
part, s^2 = S^2 - q^2 / 12 (Sheppard). Between a tenth and a half of a step, this u is up to three
times too large.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from hbench.analysis.screening.friction_channels import friction_channels
from hbench.motion.noise import resolution
from hbench.records import Run, ScreenedRun

_LEAST = 0.01  # of friction; a smaller part of its uncertainty is neglected


def rounding_errors(run: Run, window: slice, friction_n: float) -> dict[str, float]:
    """Return the standard uncertainty of each mean over ``window`` by the log's steps, in SI.

    Only channels whose part in ``friction_n`` [N] matters are contained. The steps are those of the
    whole run, since a settled pressure may have one value in the window. It is NaN for a channel
    with one value in the whole run: other runs show its steps (``with_common_steps``).
    """
    found = {}
    for name, slope in _slopes(run).items():
        values = getattr(run, name)
        if values is not None:
            u = rounding_error(values[window], resolution(values)) if np.ptp(values) else np.nan
            if np.isnan(u) or u * slope > _LEAST * abs(friction_n):
                found[name] = u
    return found


def friction_step(run: Run) -> float:
    """Return the largest change [N] of a sample's friction by one step of a channel's log."""
    return max(slope * resolution(run.channel(name)) for name, slope in _slopes(run).items())


def _slopes(run: Run) -> dict[str, float]:
    """Return the change of friction [N] with each channel of it, in SI."""
    specimen = run.plan.specimen
    areas = {"p_tp_pa": specimen.area_piston_m2, "p_tr_pa": specimen.area_rod_m2}
    return {name: areas.get(name, 1.0) for name in friction_channels(run)}


def with_common_steps(screened: Iterable[ScreenedRun]) -> tuple[ScreenedRun, ...]:
    """Give channels with one value in a whole run the largest uncertainty that other runs show."""
    runs = tuple(screened)
    largest: dict[str, float] = {}
    for run in runs:
        for name, u in run.means.u_steps.items() if run.means else ():
            largest[name] = max(largest.get(name, 0.0), np.nan_to_num(u))
    return tuple(_with_steps(run, largest) for run in runs)


def _with_steps(run: ScreenedRun, largest: dict[str, float]) -> ScreenedRun:
    if run.means is None or not np.isnan(list(run.means.u_steps.values())).any():
        return run
    known = {name: largest[name] if np.isnan(u) else u for name, u in run.means.u_steps.items()}
    used = {name: u for name, u in known.items() if u > 0.0}
    return replace(run, means=replace(run.means, u_steps=used))


def rounding_error(values: np.ndarray, step: float) -> float:
    """Return the standard uncertainty of the mean of ``values`` (n,) that are rounded to ``step``.

    0 for a step of 0.
    """
    if step == 0.0:
        return 0.0
    noise = max(float(np.var(values)) / step**2 - 1 / 12, 0.0)
    return step / float(np.sqrt(12)) * float(np.exp(-2 * np.pi**2 * noise))
