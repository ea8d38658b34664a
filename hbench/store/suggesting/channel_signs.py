"""Signs of chosen channels that contradict the mechanics of the bench."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hbench.motion.plateaus import Plateau
from hbench.store.suggesting.choice import GUESS, Choice
from hbench.store.suggesting.force_balance import ForceBalance, force_balance


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
