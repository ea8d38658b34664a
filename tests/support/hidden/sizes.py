"""How large each hidden effect is at severity 1, in SI, and what else is drawn with it.

A law's coefficients are ``amounts``, times severity and a draw of +-20 %, and ``shape``, drawn
between two limits. Where there are several amounts one or more of them are chosen, or always
one: of the transducers' gains, since pressures that are all wrong by a share are a wrong load cell.

A sensor's error is an effect only beyond its class, which is 1 % of the reading for forces and
0.8 % for pressures in ``configs/bench-aau.yaml``. The smallest error hidden, 0.4 times the amount
at severity 0.5, is therefore larger than the class at the largest reading: 50 N at 5 kN and
1.2 bar at the supply's 150 bar. The amounts of 4 bar, 150 N and 4 % give 1.6 bar, 60 N and 1.6 %;
3 % of a pressure give 1.2 %.
Errors outside the catalogue have severities of 1 and 2 and are 0.8 times the amount at least:
3.2 bar of drift, and 64 N of crosstalk at 50 bar.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

BAR, LITRE_MIN = 1e5, 1e-3 / 60


@dataclass(frozen=True)
class Size:
    """One effect's numbers."""

    amounts: Mapping[str, float]
    signed: bool = False  # either sign is physical
    shape: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    one: bool = False  # one of the amounts is chosen


_LEAK = 0.1 * LITRE_MIN  # at 30 bar
_LOST = 0.15 * LITRE_MIN  # at 50 bar

# Effects that the catalogue has, each by its name there.
KNOWN: dict[str, Size] = {
    "valve_lag": Size({"time": 2.3e-3}, shape={"damping": (0.75, 1.1)}),
    "valve_deadband": Size({"test": 0.08, "load": 0.08}),
    "valve_asymmetry": Size({"test": 0.06, "load": 0.06}, signed=True, shape={"knee": (0.5, 1.0)}),
    "entrained_air": Size({"fraction": 0.017}, shape={"dissolved": (50 * BAR, 80 * BAR)}),
    "tank_back_pressure": Size(
        {"resistance": 0.09 * BAR / LITRE_MIN}, shape={"lag": (5e-3, 12e-3)}
    ),
    "supply_droop": Size(
        {"slope": 0.008 * BAR / LITRE_MIN**2}, shape={"lag": (15e-3, 40e-3)}
    ),
    "oil_warming": Size(
        {"rise": 12.0}, shape={"time": (200.0, 400.0), "viscosity": (0.025, 0.035)}
    ),
    "internal_leakage": Size({"test": _LEAK, "load": _LEAK}, shape={"exponent": (0.5, 0.7)}),
    "external_leakage": Size(
        {"tp": _LOST, "tr": _LOST, "lp": _LOST, "lr": _LOST}, shape={"exponent": (1.2, 1.4)}
    ),
    "seal_pressure_friction": Size({"test": 50.0, "load": 50.0}, shape={"exponent": (0.6, 0.8)}),
    "load_friction": Size({"test": 0.03, "load": 0.03}, shape={"limit": (6e3, 1e4)}),
    "direction_asymmetry": Size(
        {"test": 0.085, "load": 0.085}, signed=True, shape={"speed": (0.2, 0.4)}
    ),
    "friction_lag": Size({"time": 85e-3}, shape={"speed": (3e-3, 8e-3)}),
    "presliding": Size(
        {"force": 140.0}, shape={"short": (0.8e-3, 1.5e-3), "long": (3e-3, 5e-3)}
    ),
    "position_friction": Size(
        {"bump": 35.0, "wave": 15.0},
        signed=True,
        shape={
            "middle": (0.12, 0.28), "width": (0.05, 0.07),
            "period": (0.35, 0.5), "phase": (0.0, 6.28),
        },
    ),
    "end_cushion": Size({"damping": 1.7e5}, shape={"length": (0.09, 0.11)}),
    "added_mass": Size({"test": 20.0, "load": 20.0}, shape={"time": (0.8e-3, 1.2e-3)}),
    "load_cell_gain": Size({"error": 0.04}, signed=True),
    "load_cell_offset": Size({"force": 150.0}, signed=True),
    "pressure_offset": Size(
        {f"p_{name}": 4.0 * BAR for name in ("tp", "tr", "lp", "lr", "s")}, signed=True
    ),
    "velocity_filter_lag": Size({"time": 2e-3}),
    "valve_hysteresis": Size({"test": 0.05, "load": 0.05}),
    "pressure_gain": Size(
        {f"p_{name}": 0.03 for name in ("tp", "tr", "lp", "lr", "s")}, signed=True, one=True
    ),
}  # fmt: skip

# Effects that it does not have.
OUTSIDE: dict[str, Size] = {
    "flow_force": Size({"share": 0.05}),
    "position_error": Size(
        {"bow": 0.03, "wave": 0.03}, signed=True, shape={"period": (0.03, 0.06)}
    ),
    "hose_volume": Size({"tr": 60e-6, "lr": 60e-6}, shape={"time": (0.04, 0.08)}),
    "worn_bore": Size(
        {"leak": 4 * _LEAK}, shape={"middle": (0.18, 0.26), "width": (0.02, 0.03)}
    ),
    "guide_misalignment": Size({"share": 0.05}),
    "bore_chatter": Size({"force": 25.0}, shape={"period": (0.03, 0.05), "phase": (0.0, 6.28)}),
    "rest_film": Size({"share": 0.5}, shape={"length": (0.05, 0.08), "time": (0.3, 0.8)}),
    "cell_crosstalk": Size({"p_tp": 1.6 / BAR, "p_tr": 1.6 / BAR}, signed=True),
    "pressure_drift": Size({"p_tp": 4.0 * BAR, "p_lp": 4.0 * BAR}, signed=True),
}  # fmt: skip

# What good benches have. A spool with two ports leaks 0.2 l/min from the supply to the tank at
# 150 bar with both ports blocked, 0.5 % of its flow at 10 V and 70 bar.
WITHIN_CLASS: dict[str, Size] = {
    "spool_leak": Size({"conductance": 2.2e-13}, shape={"overlap": (0.2, 0.5)}),
}
