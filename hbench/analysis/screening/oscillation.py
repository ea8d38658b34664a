"""Oscillation of the speed in a steady window, such as stick-slip faster than 0.1 s means show.

Where the controller's velocity was logged, its standard deviation counts. Otherwise the speed is
that between means of the position over blocks of the shortest time that has two samples,
in multiples of 20 ms, so that hum of 50 Hz averages out. It has an allowance for noise and for
the steps of the position, which may be the same in all samples of a block.
"""

from collections.abc import Iterator

import numpy as np

from hbench.analysis.rounding import exceeds
from hbench.analysis.screening.steadiness import BLOCK_S, Ripple, speed_ripple
from hbench.config.schedule import Screening
from hbench.motion.noise import noise_over_motion, position_noise, resolution
from hbench.motion.speeds import block_speeds
from hbench.records import Run

_SAMPLES = 2  # of a block, at least
_SHORTEST_S = 0.02
_LATE = 0.1  # of the speeds, which may be wrong by the time stamps of the log


def oscillation_of_velocity(run: Run, window: slice, rules: Screening) -> Iterator[str]:
    """Yield the reason if the controller's velocity oscillates by more than the limit."""
    known = _velocity(run, window)
    limit = _limit(run, rules)
    swing = float(np.std(known, ddof=1)) if len(known) > 1 else 0.0
    if exceeds(swing, limit):
        yield (
            f"not_steady: the controller's velocity oscillates by {1e3 * swing:.2f} mm/s "
            f"(standard deviation); limit {1e3 * limit:.2f} mm/s"
        )


def oscillation_of_position(run: Run, window: slice, rules: Screening) -> Iterator[str]:
    """Yield the reason if the speed of a foreign log without a velocity oscillates by more."""
    block_s = _block_s(run.t_s[window])
    if len(_velocity(run, window)) > 1 or run.plan.motion is not None or block_s >= BLOCK_S:
        return
    limit = _limit(run, rules)
    ripple = fast_ripple(run.t_s, run.x_m, window, block_s)
    if exceeds(ripple.total_m_s, np.hypot(limit, ripple.noise_m_s)):
        yield (
            f"not_steady: the speed over {block_s:g} s oscillates by {1e3 * ripple.total_m_s:.2f} "
            f"mm/s (standard deviation), as in stick-slip; limit {1e3 * limit:.2f} mm/s and "
            f"{1e3 * ripple.noise_m_s:.2f} mm/s noise"
        )


def _velocity(run: Run, window: slice) -> np.ndarray:
    known = np.zeros(0) if run.v_m_s is None else run.v_m_s[window]
    return known[np.isfinite(known)]


def _limit(run: Run, rules: Screening) -> float:
    return max(rules.speed_oscillation, rules.speed_oscillation_relative * abs(run.plan.v_ref_m_s))


def fast_ripple(t_s: np.ndarray, x_m: np.ndarray, window: slice, block_s: float) -> Ripple:
    """Return the standard deviation of the speed over blocks of ``block_s``, and its noise.

    t_s, x_m (n,) are those of the whole run: noise is that of its smoother samples. The largest
    deviations do not count: a late time stamp is no oscillation.
    """
    noise_m = min(position_noise(t_s[window], x_m[window]), noise_over_motion(t_s, x_m))
    noise = speed_ripple(t_s[window], x_m[window], noise_m, block_s).noise_m_s
    speeds = block_speeds(t_s[window], x_m[window], block_s, noise_m).v_m_s
    if len(speeds) < 2:
        return Ripple(0.0, 0.0)
    deviations = np.sort(np.abs(speeds - speeds.mean()))
    kept = deviations[: int(np.ceil((1.0 - _LATE) * len(deviations)))]
    of_steps = np.sqrt(2) * resolution(x_m) / np.sqrt(12) / block_s
    return Ripple(float(np.sqrt(np.mean(kept**2))), float(np.hypot(noise, of_steps)))


def _block_s(t_s: np.ndarray) -> float:
    needed = _SAMPLES * float(np.median(np.diff(t_s)))
    return _SHORTEST_S * max(1.0, np.ceil(needed / _SHORTEST_S - 1e-6))
