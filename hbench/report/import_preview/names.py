"""Channels of an import map in words, and their display units."""

_DISPLAY = {
    "s": ("s", 1.0),
    "m": ("mm", 1e3),
    "m/s": ("mm/s", 1e3),
    "Pa": ("bar", 1e-5),
}
_WORDS = {
    "t_s": ("t", "time"),
    "x_m": ("x", "position"),
    "v_m_s": ("v", "velocity"),
    "p_tp_pa": ("P_Tp", "test cylinder, piston side"),
    "p_tr_pa": ("P_Tr", "test cylinder, rod side"),
    "p_lp_pa": ("P_Lp", "load cylinder, piston side"),
    "p_lr_pa": ("P_Lr", "load cylinder, rod side"),
    "p_s_pa": ("P_S", "supply pressure"),
    "f_applied_n": ("F_applied", "load cell"),
    "f_drive_n": ("F_drive", "force of the drive"),
    "u_t_v": ("u_T", "command of the test valve"),
    "u_l1_v": ("u_L1", "command of load valve 1"),
    "u_l2_v": ("u_L2", "command of load valve 2"),
    "v_ref_m_s": ("v_ref", "velocity reference"),
    "p_lr_ref_pa": ("P_Lr,ref", "pressure reference"),
    "p_lp_ref_pa": ("P_Lp,ref", "pressure reference"),
    "temp_tank_k": ("T_tank", "oil temperature in the tank"),
    "temp_port_k": ("T_port", "oil temperature at a port of the test cylinder"),
    "temp_seal_k": ("T_seal", "oil temperature at the test cylinder's seal"),
}


def display(unit: str) -> tuple[str, float]:
    """Return the display unit of a channel in SI, and the factor from SI to it."""
    return _DISPLAY.get(unit, (unit, 1.0))


def symbol(channel: str) -> str:
    """Return the symbol of a channel."""
    return _WORDS.get(channel, (channel, ""))[0]


def words(channel: str) -> str:
    """Return what a channel is."""
    return _WORDS.get(channel, ("", channel))[1]
