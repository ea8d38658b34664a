"""Channels of logs: their units, and their symbols in the drawing of the hydraulic circuit."""

from typing import NamedTuple


class Channel(NamedTuple):
    """Channel of a log, or of an import map."""

    unit: str  # SI
    symbol: str
    words: str


CHANNELS = {
    "t_s": Channel("s", "t", "time"),
    "x_m": Channel("m", "x", "position"),
    "v_m_s": Channel("m/s", "v", "velocity"),
    "p_tp_pa": Channel("Pa", "P_Tp", "test cylinder, piston side"),
    "p_tr_pa": Channel("Pa", "P_Tr", "test cylinder, rod side"),
    "p_lp_pa": Channel("Pa", "P_Lp", "load cylinder, piston side"),
    "p_lr_pa": Channel("Pa", "P_Lr", "load cylinder, rod side"),
    "p_s_pa": Channel("Pa", "P_S", "supply pressure"),
    "f_applied_n": Channel("N", "F_applied", "load cell"),
    "f_drive_n": Channel("N", "F_drive", "force of a drive without hydraulics, such as a motor"),
    "u_t_v": Channel("V", "u_T", "command of the test valve"),
    "u_l1_v": Channel("V", "u_L1", "command of load valve 1"),
    "u_l2_v": Channel("V", "u_L2", "command of load valve 2"),
    "v_ref_m_s": Channel("m/s", "v_ref", "velocity reference"),
    "p_lr_ref_pa": Channel("Pa", "P_Lr,ref", "pressure reference"),
    "p_lp_ref_pa": Channel("Pa", "P_Lp,ref", "pressure reference"),
    "temp_tank_k": Channel("K", "T_tank", "oil temperature in the tank"),
    "temp_port_k": Channel("K", "T_port", "oil temperature at a port of the test cylinder"),
    "temp_seal_k": Channel("K", "T_seal", "oil temperature at the test cylinder's seal"),
}
