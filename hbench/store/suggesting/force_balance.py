"""Signs of position and force, and the piston's area, from the balance of forces at steady speed.

    F_applied = A_p P_p - A_r P_r - F_c sign(v) + c

with the friction F_c > 0, for a position that increases when the cylinder extends and a force that
is positive when it opposes extension. The coefficients are fitted to the means over the sections of
constant speed. One load alone does not determine them: its small changes with the speed are those
of friction too. Without P_r in the files, the rod side is taken as open to the air. If c shows that
it is not, the sign of the position and the area are not determined: a pressure that is not logged
may change with the direction, like friction, and with the load.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hbench.motion.plateaus import Plateau
from hbench.store.suggesting.choice import GUESS, Choice

_SIGMAS = 5.0  # a coefficient nearer to zero is not determined
_LEAST = 8  # sections
_EXACT = 0.03  # of a diameter, its standard error
_LEAST_CHANGE = 0.05  # of the largest force: its range in one direction, with several loads
_OPEN = 0.1  # of the largest A_p P_p: the constant c of a rod side that is open to the air


class ForceBalance(NamedTuple):
    """Result of the balance; 0 or None for what it does not determine."""

    force_sign: int  # -1: the force is positive in the direction of extension
    position_sign: int  # -1: the position decreases when the cylinder extends
    bore_m: float | None
    sections: int
    chambers_swapped: bool  # the rod side's pressure acts on the larger area


NOTHING = ForceBalance(0, 0, None, 0, False)


def force_balance(
    files: Sequence[Mapping[str, np.ndarray]], steady: Sequence[Sequence[Plateau]]
) -> ForceBalance:
    """Return the result for ``files``: channels in SI by the names of an import map, (n,) each.

    ``steady`` are the sections of constant speed of each file.
    """
    rows, forces = [], []
    has_rod = all("p_tr_pa" in file for file in files)
    for file, plateaus in zip(files, steady, strict=True):
        if not {"x_m", "p_tp_pa", "f_applied_n"} <= file.keys():
            return NOTHING
        for plateau in plateaus:
            known = {name: values[plateau.section] for name, values in file.items()}
            known = {name: values[np.isfinite(values)] for name, values in known.items()}
            if not all(map(len, known.values())):
                continue  # a channel has no value at this speed
            means = {name: float(values.mean()) for name, values in known.items()}
            rod = [-means["p_tr_pa"]] if has_rod else []
            rows.append([means["p_tp_pa"], *rod, -float(np.sign(plateau.v_m_s)), 1.0])
            forces.append(means["f_applied_n"])
    matrix, force = np.array(rows), np.array(forces)
    if len(rows) < _LEAST or len(set(matrix[:, -2])) < 2:
        return NOTHING
    by_direction, *_ = np.linalg.lstsq(matrix[:, -2:], force, rcond=None)
    if np.ptp(force - matrix[:, -2:] @ by_direction) < _LEAST_CHANGE * np.abs(force).max():
        return NOTHING
    scale = np.abs(matrix).max(axis=0)
    if not scale.all() or np.linalg.matrix_rank(matrix / scale, tol=1e-6) < matrix.shape[1]:
        return NOTHING
    found, *_ = np.linalg.lstsq(matrix / scale, force, rcond=None)
    rest = force - matrix / scale @ found
    variance = rest @ rest / (len(force) - len(found))
    se = np.sqrt(variance * np.diag(np.linalg.inv((matrix / scale).T @ (matrix / scale)))) / scale
    result = _result(found / scale, se, has_rod, len(rows))
    constant_n, its_se = abs(found[-1]), se[-1]
    closed = constant_n > _OPEN * abs(found[0]) and constant_n > _SIGMAS * its_se
    if not has_rod and closed:
        return result._replace(position_sign=0, bore_m=None)
    return result


def _result(found: np.ndarray, se: np.ndarray, has_rod: bool, sections: int) -> ForceBalance:
    signs = np.where(np.abs(found) > _SIGMAS * se, np.sign(found), 0).astype(int)
    force_sign, friction_sign = int(signs[0]), int(signs[-2])
    swapped = False
    if has_rod and signs[0] and signs[1]:
        swapped = bool(
            signs[0] == signs[1]
            and abs(found[1]) - abs(found[0]) > _SIGMAS * float(np.hypot(se[0], se[1]))
        )
    if not force_sign or swapped:
        return ForceBalance(0, 0, None, sections, swapped)
    bore = 2 * float(np.sqrt(abs(found[0]) / np.pi))
    exact = 0.5 * se[0] / abs(found[0]) < _EXACT
    return ForceBalance(
        force_sign, force_sign * friction_sign, bore if exact else None, sections, False
    )


def with_signs(
    choices: dict[str, Choice],
    channels: Sequence[Mapping[str, np.ndarray]],
    steady: Sequence[Sequence[Plateau]],
) -> dict[str, Choice]:
    """Return the choices with the signs that the mechanics determine, each with its reason.

    ``channels`` (n,) in SI and ``steady``, the sections of constant speed, are those of each file.
    """
    balance = force_balance(channels, steady)
    return _by_balance(_by_friction(choices, channels, steady), balance)


def _by_balance(choices: dict[str, Choice], balance: ForceBalance) -> dict[str, Choice]:
    """Turn the signs that contradict the balance of forces."""
    out = dict(choices)
    why = f"sign by the balance of forces in {balance.sections} sections"
    for sign, channels in (
        (balance.force_sign, ("f_applied_n",)),
        (balance.position_sign, ("x_m", "v_m_s", "v_ref_m_s")),
    ):
        for channel in channels if sign else ():
            choice = out.get(channel)
            if choice is not None and choice.scale is not None:
                out[channel] = replace(
                    choice, scale=float(sign) * choice.scale, reason=f"{choice.reason}; {why}"
                )
    if {"x_m", "p_tp_pa", "f_applied_n"} <= out.keys():
        for sign, channel in ((balance.position_sign, "x_m"), (balance.force_sign, "f_applied_n")):
            choice = out[channel]
            if not sign and choice.column.name != channel:
                reason = f"{choice.reason}; the balance of forces does not determine its sign"
                out[channel] = replace(choice, certainty=GUESS, reason=reason)
    if balance.chambers_swapped:
        warning = "check: by the balance of forces p_tr_pa acts on the larger area"
        for channel in ("p_tp_pa", "p_tr_pa"):
            choice = out[channel]
            out[channel] = replace(choice, certainty=GUESS, reason=f"{choice.reason}; {warning}")
    return out


def _by_friction(
    choices: dict[str, Choice],
    channels: Sequence[Mapping[str, np.ndarray]],
    steady: Sequence[Sequence[Plateau]],
) -> dict[str, Choice]:
    """Turn the sign of a drive's force that acts against the motion at constant speed."""
    choice = choices.get("f_drive_n")
    means: dict[bool, list[float]] = {True: [], False: []}
    for file, sections in zip(channels, steady, strict=True):
        for plateau in sections if "f_drive_n" in file else ():
            mean = float(np.nanmean(file["f_drive_n"][plateau.section]))
            means[plateau.v_m_s > 0].append(mean)
    if choice is None or not all(means.values()):
        return choices
    if np.mean(means[True]) >= np.mean(means[False]):
        return choices
    reason = f"{choice.reason}; sign by the friction, which opposes the motion"
    return choices | {"f_drive_n": replace(choice, scale=-1.0, reason=reason)}
