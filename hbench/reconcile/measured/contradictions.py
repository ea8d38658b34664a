"""Contradictions between logs and model that no physical effect explains.

A command that opens its valve the wrong way, pressures whose forces do not fit the cylinder's
areas, and positions outside the stroke are faults of the import map or of the model file. A search
would take them for an effect, so they are looked for first. Commands and areas are judged in
windows of motion far from a reversal:

- **Commands.** The oil that the motion needs flows into a chamber while the command of its valve
  empties it, and the further the faster the motion: the null of a valve alone may exceed the small
  command of a slow one. Or the command is beyond the valve's limit most of the time.
- **Friction** that drives both cylinders: the position counts from the other end.
- **Areas.** The applied force is A_p P_p - A_r P_r less friction (2.12) and inertia, at the load
  cylinder plus friction. A fit of the areas with friction, a mass and an offset gives their ratio.
  Friction is dry, viscous and in proportion to each pressure, so strokes in both directions are
  needed: in one alone, friction that grows with a pressure is like an area. So are pressures that
  differ between the directions alone. What the pressure on the rod side does and friction does not
  must also exceed several times what the fit leaves: friction of another law may do as much. An
  error of the load cell's gain changes both areas alike, so the ratio is free of it. Where both
  areas come out negative, the pressures are exchanged, or the force has the wrong sign.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from hbench.analysis.statistics.intervals import covariance_over_runs
from hbench.errors import DataError
from hbench.model.cylinders import pressure_force
from hbench.model.parameters import CylinderParameters
from hbench.reconcile.measured.balances import BalanceModel, driving_signals
from hbench.reconcile.measured.session import COMMANDS, Session
from hbench.records.diagnosis import REST_M_S

_FAR = 0.5  # relative change of the velocity over a window: the motion does not reverse near it
_OPEN_V = 0.1  # a smaller command may be within the null of its valve
_OUTSIDE = 0.05  # of the stroke: the zero of a position sensor may be off by so much
_BEYOND = 1.1  # times the limit: a command may be logged before it is limited
_FEWEST = 20  # windows
_WRONG = 0.9  # share of windows in which a command has the wrong sign
_AREAS = 0.08  # relative error of the areas' ratio; 11 % or more to the next rod of ISO 3320
_SIGMAS = 4.0  # of its standard error, at least
_LEAST_SHARE = 0.5  # of the piston's area by the fit
_LEAST_OWN = 0.05  # part of a pressure that neither friction nor the other pressure explains
_CLEAR = 3.0  # times the force that the fit leaves: what a wrong area must explain, at least
_FEEDS = {"u_t_v": ("T", 1), "u_l1_v": ("L1", 1), "u_l2_v": ("L2", -1)}  # sign of v it drives


_VISIBLE = 0.01  # of the applied force: load cells have such errors
_TURNED_HINT = (
    "x_m is 0 at the retracted end and rises while the test cylinder extends: a sensor that counts "
    "from the other end needs scale: -1, and the stroke as offset, in the import map."
)


@dataclass(frozen=True)
class _Moving:
    """Windows (w,) of motion: their means, and their runs."""

    v_m_s: np.ndarray
    a_m_s2: np.ndarray
    pressures_pa: np.ndarray  # (4, w) Tp, Tr, Lp, Lr
    force_n: np.ndarray  # applied
    commands_v: dict[str, np.ndarray]  # nan where not measured
    run: np.ndarray


def refuse_contradictions(logs: Sequence[Session], model: BalanceModel) -> None:
    """Raise ``DataError`` where positions, commands or areas contradict the logs."""
    _refuse_positions(logs, model.par.test.stroke_m)
    moving = _moving(logs, model)
    for name, u in moving.commands_v.items():
        _refuse_beyond(name, u[np.isfinite(u)], model.par.valve.limit_v)
    if wrong := dict(_wrong_commands(moving)):
        raise DataError("; ".join(wrong.values()), _command_hint(list(wrong)))
    p_tp, p_tr, p_lp, p_lr = moving.pressures_pa
    _refuse_driving_friction(moving, model)
    _refuse_areas("test_cylinder", model.par.test, p_tp, p_tr, moving)
    _refuse_areas("load_cylinder", model.par.load, p_lp, p_lr, moving)


def _moving(logs: Sequence[Session], model: BalanceModel) -> _Moving:
    parts, first = [], 0
    for log in logs:
        signals = driving_signals(log, model)
        v = log.rate(signals[0])
        a = log.second(signals[0])
        change = np.abs(a) * log.window.dt_s * len(log.window.value)
        at = (np.abs(v) > REST_M_S) & (change < _FAR * np.abs(v))
        has = {name: log.measured[name][log.run_of_window] for name in COMMANDS}
        parts.append(
            _Moving(
                v[at],
                a[at],
                log.mean(signals[2:6])[:, at],
                log.mean(log.channels["f_applied_n"])[at],
                {
                    name: np.where(own, log.mean(log.channels[name]), np.nan)[at]
                    for name, own in has.items()
                },
                log.run_of_window[at] + first,
            )
        )
        first += len(log.runs)
    return _Moving(
        np.concatenate([part.v_m_s for part in parts]),
        np.concatenate([part.a_m_s2 for part in parts]),
        np.concatenate([part.pressures_pa for part in parts], axis=1),
        np.concatenate([part.force_n for part in parts]),
        {name: np.concatenate([part.commands_v[name] for part in parts]) for name in COMMANDS},
        np.concatenate([part.run for part in parts]),
    )


def _refuse_positions(logs: Sequence[Session], stroke_m: float) -> None:
    """Raise ``DataError`` for positions that the stroke does not contain."""
    low = min(log.channels["x_m"].min() for log in logs)
    high = max(log.channels["x_m"].max() for log in logs)
    if max(-low, high - stroke_m) > _OUTSIDE * stroke_m:
        raise DataError(
            f"x_m: positions from {1e3 * low:.4g} to {1e3 * high:.4g} mm, the stroke of the test "
            f"cylinder in the model file is {1e3 * stroke_m:.4g} mm",
            "Correct test_cylinder.stroke in the model file, or the offset and scale of x_m in the "
            "import map: 0 is the retracted end.",
        )


def _refuse_beyond(name: str, u: np.ndarray, limit_v: float) -> None:
    """Raise ``DataError`` for a command that is beyond its valve's limit most of the time."""
    beyond = np.abs(u) > _BEYOND * limit_v
    if len(u) >= _FEWEST and beyond.mean() > 0.5:
        raise DataError(
            f"{name}: {np.median(np.abs(u)):.3g} V in the median of {len(u)} windows of motion "
            f"(limit of the valve: {limit_v:g} V)",
            "Correct its unit, scale and offset in the import map, or valve.limit in the model "
            "file.",
        )


def _wrong_commands(moving: _Moving) -> Iterator[tuple[str, str]]:
    """Yield commands that empty the chambers which the motion fills, with a sentence on each."""
    for name, (valve, sense) in _FEEDS.items():
        u = moving.commands_v[name]
        opened = np.abs(u) > _OPEN_V
        wrong = np.sign(u[opened]) != sense * np.sign(moving.v_m_s[opened])
        if len(wrong) >= _FEWEST and wrong.mean() > _WRONG and _falls(u, sense, moving):
            yield (
                name,
                f"{name}: valve {valve} is commanded against the motion in {100 * wrong.mean():.0f}"
                f" % of {len(wrong)} windows of motion (limit: {100 * _WRONG:.0f} %)",
            )


def _falls(u: np.ndarray, sense: int, moving: _Moving) -> bool:
    """Return whether a command falls where the velocity that it should drive rises."""
    known = np.isfinite(u)
    columns = np.column_stack([sense * moving.v_m_s[known], np.ones(known.sum())])
    fit = np.linalg.lstsq(columns, u[known], rcond=None)[0]
    covariance, _ = covariance_over_runs(columns, u[known] - columns @ fit, moving.run[known])
    return bool(fit[0] < -_SIGMAS * np.sqrt(covariance[0, 0]))


def _refuse_driving_friction(moving: _Moving, model: BalanceModel) -> None:
    """Raise ``DataError`` where the friction of both cylinders has the direction of the motion.

    An error of the load cell raises the friction of one cylinder and lowers that of the other.
    Offsets cancel in half the difference of both directions.
    """
    v, (p_tp, p_tr, p_lp, p_lr) = moving.v_m_s, moving.pressures_pa
    test, load = (
        pressure_force(p_p, p_r, cylinder)
        for p_p, p_r, cylinder in ((p_tp, p_tr, model.par.test), (p_lp, p_lr, model.par.load))
    )
    forces = test - moving.force_n, moving.force_n - load  # against extension
    extends = v > 0
    if min(extends.sum(), (~extends).sum()) < _FEWEST or not (moving.force_n.any() and load.any()):
        return
    columns = np.column_stack([np.sign(v), np.ones_like(v)])
    levels = []
    for force in forces:
        fit = np.linalg.lstsq(columns, force, rcond=None)[0]
        covariance, _ = covariance_over_runs(columns, force - columns @ fit, moving.run)
        levels.append(fit[0] + _SIGMAS * np.sqrt(covariance[0, 0]))
    if max(levels) < -_VISIBLE * np.sqrt(np.mean(moving.force_n**2)):
        raise DataError(
            f"friction of both cylinders has the direction of the motion ({levels[0]:.3g} N at the "
            f"test cylinder, {levels[1]:.3g} N at the load cylinder, or more)",
            _TURNED_HINT,
        )


def _command_hint(names: Sequence[str]) -> str:
    if len(names) == len(_FEEDS):
        return f"{_TURNED_HINT} Otherwise the commands have the other sign: give them scale: -1."
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


def _refuse_areas(
    name: str,
    cylinder: CylinderParameters,
    p_p: np.ndarray,
    p_r: np.ndarray,
    moving: _Moving,
) -> None:
    """Raise ``DataError`` for areas that do not fit.

    The standard error of the ratio leaves out the correlation of both areas.
    """
    v, piston_m2, rod_m2 = moving.v_m_s, cylinder.area_piston_m2, cylinder.area_rod_m2
    way = np.sign(v)
    friction = way, v, way * p_p, way * p_r
    inertia = moving.a_m_s2, np.ones_like(v)
    columns = np.column_stack([p_p * piston_m2, -p_r * rod_m2, *friction, *inertia])
    size = np.linalg.norm(columns, axis=0)
    if min(np.sum(way > 0), np.sum(way < 0)) < _FEWEST or not size.all():
        return
    columns = columns / size
    fit = np.linalg.lstsq(columns, moving.force_n, rcond=None)[0]
    left = moving.force_n - columns @ fit
    covariance, _ = covariance_over_runs(columns, left, moving.run)
    (piston, rod), se = fit[:2] / size[:2], np.sqrt(np.diag(covariance)[:2]) / size[:2]
    if not np.isfinite(se).all():
        return
    own = _own_part(columns, 0), _own_part(columns, 1)
    clear = _CLEAR * np.linalg.norm(left)
    if piston < -_SIGMAS * se[0] and rod < -_SIGMAS * se[1] and -rod * size[1] * own[1] > clear:
        raise _negative_areas(name, piston, rod, rod_m2 / piston_m2)
    if min(own) < _LEAST_OWN:
        return  # friction may follow the pressures
    if piston < max(_LEAST_SHARE, _SIGMAS * se[0]):
        return  # the force does not follow the pressures
    if abs(rod - piston) * size[1] * own[1] < clear:
        return  # friction of another law may do the same
    off, error = rod / piston - 1, np.hypot(*se) / piston
    if abs(off) > max(_AREAS, _SIGMAS * error):
        given, found = rod_m2 / piston_m2, rod_m2 / piston_m2 * (1 + off)
        raise DataError(
            f"{name}: pressures and force give a ratio of rod side to piston side area of "
            f"{found:.3f}, the model file {given:.3f} ({100 * off:+.0f} %, limit: "
            f"{100 * _AREAS:.0f} %){_fitting_rod(piston_m2, found)}",
            "Correct the cylinder's diameters in the model file, or the scale of a pressure in the "
            "import map.",
        )


def _negative_areas(name: str, piston: float, rod: float, ratio: float) -> DataError:
    """Return the error for areas by the fit that are negative, in shares of the model file's."""
    side = name.removesuffix("_cylinder")
    exchanged = abs(np.log(rod / piston) + 2 * np.log(ratio)) < abs(np.log(rod / piston))
    p_p, p_r = ("p_tp_pa", "p_tr_pa") if side == "test" else ("p_lp_pa", "p_lr_pa")
    return DataError(
        f"{name}: the force falls where {p_p} rises, and rises with {p_r} (areas by a fit: "
        f"{100 * piston:.0f} and {100 * rod:.0f} % of the model file's)",
        f"Exchange the columns of {p_p} and {p_r} in the import map."
        if exchanged
        else "Give f_applied_n scale: -1 in the import map: positive, it opposes extension.",
    )


def _own_part(columns: np.ndarray, which: int) -> float:
    """Return the length of a column (n,) of length 1 that the others (n, p - 1) leave over."""
    others = np.delete(columns, which, axis=1)
    left = columns[:, which] - others @ np.linalg.lstsq(others, columns[:, which], rcond=None)[0]
    return float(np.linalg.norm(left))


def _fitting_rod(piston_m2: float, ratio: float) -> str:
    """Return which rod would have an area ratio; empty for a ratio that no rod has."""
    if not 0 < ratio < 1:
        return ""
    bore_mm = 1e3 * sqrt(4 * piston_m2 / pi)
    return (
        f"; with the bore of {bore_mm:.4g} mm a rod of {bore_mm * sqrt(1 - ratio):.3g} mm would fit"
    )
