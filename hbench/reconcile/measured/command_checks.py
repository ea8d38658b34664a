"""Commands that contradict the motion.

- **Sign.** The oil that the motion needs flows into a chamber while the command of its valve
  empties it, and the further the faster the motion: the null of a valve alone may exceed the small
  command of a slow one.
- **Limit.** The command is beyond the valve's limit most of the time.
- **Scale.** The flow by the command and the drops of pressure is several times what the motion
  needs, or a part of it. A first guess of a gain may be off by a factor of 2.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from hbench.analysis.statistics.intervals import covariance_over_runs
from hbench.errors import DataError
from hbench.reconcile.measured.moving_windows import FEWEST, SIGMAS, Moving
from hbench.sentences import listed

TURNED_HINT = (
    "x_m is 0 at the retracted end and rises while the test cylinder extends: a sensor that counts "
    "from the other end needs scale: -1, and the stroke as offset, in the import map."
)
_OPEN_V = 0.1  # a smaller command may be within the null of its valve
_BEYOND = 1.1  # times the limit: a command may be logged before it is limited
_WRONG = 0.9  # share of windows in which a command has the wrong sign
_FEEDS = {"u_t_v": ("T", 1), "u_l1_v": ("L1", 1), "u_l2_v": ("L2", -1)}  # sign of v it drives
_CHAMBERS = {"u_t_v": [0, 1], "u_l1_v": [3], "u_l2_v": [2]}  # among Tp, Tr, Lp, Lr
_SCALE = 3.0  # times too much or too little flow
_LARGE = 0.25  # of the largest flow: nulls and leaks are a small part of it


def refuse_commands(moving: Moving, limit_v: float) -> None:
    """Raise ``DataError`` for commands against the motion, or beyond their valve's limit."""
    for name, u in moving.commands_v.items():
        _refuse_beyond(name, u[np.isfinite(u)], limit_v)
    if wrong := dict(_wrong_commands(moving)):
        raise DataError("; ".join(wrong.values()), _command_hint(list(wrong)))
    if off := dict(_wrong_scales(moving)):
        raise DataError(
            "; ".join(off.values()),
            f"Correct the scale of {listed(list(off))} in the import map, or valve.gain in the "
            "model file.",
        )


def _refuse_beyond(name: str, u: np.ndarray, limit_v: float) -> None:
    """Raise ``DataError`` for a command that is beyond its valve's limit most of the time."""
    beyond = np.abs(u) > _BEYOND * limit_v
    if len(u) >= FEWEST and beyond.mean() > 0.5:
        raise DataError(
            f"{name}: {np.median(np.abs(u)):.3g} V in the median of {len(u)} windows of motion "
            f"(limit of the valve: {limit_v:g} V)",
            "Correct its unit, scale and offset in the import map, or valve.limit in the model "
            "file.",
        )


def _wrong_commands(moving: Moving) -> Iterator[tuple[str, str]]:
    """Yield commands that empty the chambers which the motion fills, with a sentence on each."""
    for name, (valve, sense) in _FEEDS.items():
        u = moving.commands_v[name]
        opened = np.abs(u) > _OPEN_V
        wrong = np.sign(u[opened]) != sense * np.sign(moving.v_m_s[opened])
        if len(wrong) >= FEWEST and wrong.mean() > _WRONG and _falls(u, sense, moving):
            yield (
                name,
                f"{name}: valve {valve} is commanded against the motion in {100 * wrong.mean():.0f}"
                f" % of {len(wrong)} windows of motion (limit: {100 * _WRONG:.0f} %)",
            )


def _wrong_scales(moving: Moving) -> Iterator[tuple[str, str]]:
    """Yield commands with which the model's flows are not those of the motion, with a sentence."""
    for name, chambers in _CHAMBERS.items():
        needed, by_law = moving.needed_m3_s[chambers].ravel(), moving.by_law_m3_s[chambers].ravel()
        known = np.tile(np.isfinite(moving.commands_v[name]), len(chambers))
        large = known & (np.abs(needed) > _LARGE * np.abs(needed).max(initial=0.0))
        if large.sum() < FEWEST:
            continue
        share = float(np.median(by_law[large] / needed[large]))
        if share > 0 and not 1 / _SCALE < share < _SCALE:
            yield (
                name,
                f"{name}: the flows of valve {_FEEDS[name][0]} by the model file's valve.gain are "
                f"{share:.2g} times what the motion needs, in the median of {large.sum()} windows "
                f"(limits: 1/{_SCALE:g} and {_SCALE:g} times)",
            )


def _falls(u: np.ndarray, sense: int, moving: Moving) -> bool:
    """Return whether a command falls where the velocity that it should drive rises."""
    known = np.isfinite(u)
    columns = np.column_stack([sense * moving.v_m_s[known], np.ones(known.sum())])
    fit = np.linalg.lstsq(columns, u[known], rcond=None)[0]
    covariance, _ = covariance_over_runs(columns, u[known] - columns @ fit, moving.run[known])
    return bool(fit[0] < -SIGMAS * np.sqrt(covariance[0, 0]))


def _command_hint(names: Sequence[str]) -> str:
    if len(names) == len(_FEEDS):
        return f"{TURNED_HINT} Otherwise the commands have the other sign: give them scale: -1."
    if set(names) == {"u_l1_v", "u_l2_v"}:
        return (
            "Exchange the columns of u_l1_v (feeds the rod side of the load cylinder) and u_l2_v "
            "(feeds its piston side) in the import map, or give both scale: -1."
        )
    return (
        "Give each of them scale: -1 in the import map. Positive commands feed: u_t_v the piston "
        "side of the test cylinder, u_l1_v the rod side and u_l2_v the piston side of the load "
        "cylinder."
    )
