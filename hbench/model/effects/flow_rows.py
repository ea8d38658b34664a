"""Rows of the catalogue for valves, oil, lines and leaks."""

from hbench.config.effects import Coefficient
from hbench.model.effects import flows, friction, openings
from hbench.model.effects.rows import FLOWS, FORCES, Effect, Separation

_VALVES = ("test", "load_1", "load_2")
_GAIN = Coefficient("%", 5, -95, 900)  # valves of a twentieth to ten times the size
_SHARES = {side: Coefficient("%", 5, -50, 50) for side in ("test", "load")}
_LEAK = Coefficient("l/min/bar", 3e-3, 0, 1)
_LINEAR = Coefficient("1", 0, 0.3, 3, 1)  # exponent

ROWS = {
    "valve_trim": Effect(
        description="each valve has a gain and a null of its own",
        coefficients={
            **{f"gain_{valve}": _GAIN for valve in _VALVES},
            **{f"null_{valve}": Coefficient("V", 0.05, -2, 2) for valve in _VALVES},
            "curvature": Coefficient("1/V", 0.005, -0.1, 0.1),
            "small": Coefficient("%", 5, -50, 50),
            "exponent": Coefficient("1", 0.02, -0.2, 0.5),
            "ports": Coefficient("%", 5, -50, 50),
            "inlets": Coefficient("%", 5, -50, 50),
            "hose": Coefficient("bar min/l", 0.02, -1, 10),
            **{leak: Coefficient("V", 0.005, 0, 1) for leak in ("leak", "null_leak")},
        },
        balances=FLOWS,
        laws={"openings": openings.valve_trim, "ports": flows.uneven_ports},
        law="opening = u (1 + gain + curvature |u|) + null, the slope lower by small within 2 V; "
        "Q grows with dP^(1/2 + exponent), and by 1 +- ports +- inlets at the test valve: + at the "
        "port to the piston side, + at inlets; hose Q is lost of each drop dP; closed edges leak "
        "as if open by leak + null_leak / (1 + (opening / 0.3 V)^2)",
        signals="Commands at a given speed, by a share or by a constant voltage; each valve alone.",
        confused_with={
            "valve_asymmetry": Separation(
                "steady", "both directions at several speeds: a gain is the same in both"
            ),
            "valve_deadband": Separation(
                "steady", "slow strokes in both directions: a null has one sign, an overlap two"
            ),
            "internal_leakage": Separation(
                "hold", "closed valves: what then still flows is leakage"
            ),
            "external_leakage": Separation(
                "hold", "closed valves: what then still flows is leakage"
            ),
        },
        inspect="the null adjustment and the flow gain of each valve, from a recorded flow curve",
        repair="Adjust the null and enter the measured flow gain in the bench file.",
        source="Merritt, Hydraulic Control Systems (1967), section 3.4",
    ),
    "valve_lag": Effect(
        description="each valve's opening follows its spool with a first-order lag",
        coefficients={
            "time": Coefficient("ms", 3, 0.1, 100),
            "second": Coefficient("1", 0, 0, 0.45),
        },
        balances=FLOWS,
        laws={"openings": openings.valve_lag},
        states=6,
        law="time dy/dt = u - y, y the opening, u the spool with the bandwidth of the model file; "
        "second: this share of time is a second lag in a row",
        signals="Velocity and pressures after a change of the command; nothing at constant speed.",
        confused_with={
            "added_mass": Separation(
                "steps", "a mass changes the measured force at once, a slow valve only the flow"
            ),
            "friction_lag": Separation(
                "triangle", "reversals at constant load: friction's lag changes force, not flow"
            ),
            "velocity_filter_lag": Separation(
                "steps", "position against logged velocity shows the filter alone"
            ),
            "entrained_air": Separation(
                "steps", "at low and at high chamber pressure: a valve is slow at both"
            ),
        },
        inspect=(
            "the valve's step response, its pilot pressure and filter, its amplifier, and the "
            "delay between the logs of command and position, which looks the same"
        ),
        repair="Clean or replace the pilot stage, or enter the measured bandwidth.",
        source="Merritt (1967), chapter 7",
    ),
    "valve_hysteresis": Effect(
        description="each valve's spool follows its command with play",
        coefficients={
            "test": Coefficient("V", 0.05, 0, 2),
            "load": Coefficient("V", 0.05, 0, 2),
        },
        balances=FLOWS,
        laws={"openings": openings.valve_hysteresis},
        states=3,
        law="the opening y stays until the spool's command u is w away, w = test or load: "
        "|u - y| <= w, and 2 w is the width of the loop",
        signals="After a command turns, its next change moves nothing; the same voltage at any "
        "rate. Noise or dither of the command that is faster than the log makes the play smaller.",
        confused_with={
            "valve_lag": Separation(
                "triangle", "slow and fast changes of the command: play is a voltage, a lag a time"
            ),
            "valve_deadband": Separation(
                "triangle", "commands that turn far from 0: an overlap acts at 0 alone"
            ),
        },
        inspect=(
            "the flow curve recorded up and down, the valve's dither, its position feedback, and "
            "dirt at the spool"
        ),
        repair="Clean the spool and set the dither, or replace the valve.",
        source="Krasnosel'skii and Pokrovskii, Systems with Hysteresis (1989), play operator",
    ),
    "valve_deadband": Effect(
        description="a valve opens only beyond a voltage; where it is negative, the edges underlap "
        "and leak",
        coefficients={
            "test": Coefficient("V", 0.05, -0.5, 5),
            "load": Coefficient("V", 0.05, -0.5, 5),
            "softness": Coefficient("1", 0, 0, 5),
        },
        balances=FLOWS,
        laws={"openings": openings.valve_deadband, "ports": flows.through_underlap},
        law="opening = sign(u) max(|u| - w, 0), w = test or load; softness rounds the edge; "
        "where w is negative, both edges of a port are open, to the supply by a and to the tank by "
        "b: a - b = u + |w| u / (|u| + |w|), a b = w^2",
        signals="Commands at low speed rise by the same voltage in both directions, or fall. With "
        "underlap, closed valves bring the chambers towards half the supply pressure.",
        confused_with={
            "valve_asymmetry": Separation(
                "steady", "slow and fast strokes: an overlap is a voltage, an asymmetry a share"
            ),
            "pressure_offset": Separation(
                "check", "the transducers' zeros with the supply off are free of the valves"
            ),
            "internal_leakage": Separation(
                "hold",
                "at several pressures: a piston's leak ends at equal pressures, an "
                "underlapped spool's at half the supply pressure",
            ),
        },
        inspect="the spool's overlap or its leakage at null against the data sheet, and the "
        "deadband compensation of the valve's amplifier",
        repair="Enter the compensation voltage, or replace a spool with worn edges.",
        source="Merritt (1967), section 5.5",
    ),
    "valve_asymmetry": Effect(
        description="a valve opens further in one direction than in the other",
        coefficients={
            **_SHARES,
            "load_apart": Coefficient("%", 5, -50, 50),
            "knee": Coefficient("V", 0, 0, 10),
        },
        balances=FLOWS,
        laws={"openings": openings.valve_asymmetry},
        law="opening = u (1 + k sign u), k = test (T), load + load_apart (L1), load - load_apart "
        "(L2), less below the knee",
        signals="Commands at the same speed differ between extending and retracting.",
        confused_with={
            "internal_leakage": Separation(
                "hold", "closed valves: what then still flows is leakage"
            ),
            "external_leakage": Separation(
                "hold", "closed valves: what then still flows is leakage"
            ),
            "pressure_offset": Separation(
                "check", "the transducers' zeros with the supply off are free of the valves"
            ),
        },
        inspect="the flow curve of the valve in both directions, and its metering edges for wear",
        repair="Enter a gain for each direction, or replace the spool.",
        source="Merritt (1967), section 5.5, with unequal edges",
    ),
    "entrained_air": Effect(
        description="free air makes the oil softer at low pressure",
        coefficients={"fraction": Coefficient("%", 2, 0, 20)},
        balances=FLOWS,
        laws={"oil": flows.entrained_air},
        law="1/beta grows by fraction p_0 / (p_0 + P)^2, p_0 = 1.013 bar",
        signals="Pressures rise more slowly and the piston yields, below some 30 bar.",
        confused_with={
            "tank_back_pressure": Separation(
                "steps", "the line's pressure follows the flow, the softness the chamber pressure"
            ),
        },
        inspect="the oil for foam, the level in the tank, and the suction line's fittings",
        repair="Bleed the chambers by full strokes at low load, and tighten the suction line.",
        source="Merritt (1967), section 2.5; Wylie and Streeter, Fluid Transients (1993), 1.3",
    ),
    "tank_back_pressure": Effect(
        description="the pressure at the valves' return ports rises with the return flow",
        coefficients={
            "resistance": Coefficient("bar min^2/l^2", 0.005, 0, 10),
            "lag": Coefficient("ms", 0, 1, 1e4, 5),
            "exponent": Coefficient("1", 0, 0.3, 3, 2),
        },
        balances=FLOWS,
        laws={"oil": flows.tank_back_pressure, "flows": flows.return_line},
        states=1,
        law="lag dp/dt = resistance Q_0^2 (Q / Q_0)^n - p, p added to the tank's pressure, "
        "Q the return flow, n = exponent (2: turbulent), Q_0 = 10 l/min",
        signals="Commands and the pressure of the emptying chamber rise faster than the speed.",
        confused_with={
            "supply_droop": Separation(
                "steady", "fast strokes: a droop shows in P_S, a return line does not"
            ),
            "valve_asymmetry": Separation(
                "steady",
                "several speeds: the share of the flow that a line takes grows with the flow",
            ),
        },
        inspect="the return filter and its by-pass, and the bore and length of the return line",
        repair="Change the filter element, or fit a wider return line.",
        source="Merritt (1967), section 3.2 (turbulent line)",
    ),
    "supply_droop": Effect(
        description="the supply pressure falls with the flow drawn",
        coefficients={
            "slope": Coefficient("bar min/l", 0.1, 0, 50),
            "lag": Coefficient("ms", 0, 1, 1e4, 20),
            "exponent": _LINEAR,
        },
        balances=("supply",),
        laws={"flows": flows.supply_droop},
        law="lag dP_S/dt = P_0 - slope Q_0 (Q / Q_0)^n - P_S, Q the flow drawn, n = exponent "
        "(1: in proportion), Q_0 = 10 l/min",
        signals="P_S falls while the piston moves fast, and recovers at rest.",
        confused_with={
            "pressure_gain": Separation(
                "steady", "several speeds: an error of the transducer does not follow the flow"
            ),
        },
        inspect="the pump's regulator, the accumulator's charge, and the pressure filter",
        repair="Readjust the regulator, or recharge the accumulator.",
        source="droop of a pressure-compensated pump, linear and with one lag",
    ),
    "oil_warming": Effect(
        description="the oil warms with the pump and the power drawn: less viscous friction, more "
        "leakage",
        coefficients={
            "rise": Coefficient("K/kW", 10, 0, 1e3),
            "pump": Coefficient("K", 10, 0, 200),
            "time": Coefficient("s", 0, 0.1, 1e5, 300),
            "viscosity": Coefficient("1/K", 0, 0, 0.1, 0.03),
        },
        balances=(*FORCES, *FLOWS),
        laws={"flows": flows.warmth, "friction": friction.thinner_film},
        states=1,
        builds_up=True,
        law="time dT/dt = pump + rise P_S Q - T; viscosity falls by exp(-viscosity T)",
        signals="Friction at high speed falls and leaks grow in the course of the session.",
        confused_with={
            "load_friction": Separation(
                "steady", "repeat the first point at the end: only warming changes it"
            ),
        },
        inspect="the oil's temperature over the session, the cooler, and the pump's relief valve",
        repair="Warm up before the campaign, control the temperature, or measure in passes.",
        source="heat balance of the tank; viscosity after Vogel and Barus, near one temperature",
    ),
    "internal_leakage": Effect(
        description="oil leaks across the piston with the pressure drop",
        coefficients={"test": _LEAK, "load": _LEAK, "exponent": _LINEAR},
        balances=FLOWS,
        laws={"flows": flows.internal_leakage},
        law="Q = G p_0 (|P_p - P_r| / p_0)^n to the side of lower pressure, G = test or load, "
        "n = exponent (1: laminar, 0.5: an orifice), p_0 = 50 bar",
        signals="The piston is slower than the command; with closed valves both pressures meet.",
        confused_with={
            "external_leakage": Separation(
                "hold", "closed valves: pressures of both chambers meet, or each falls to zero"
            ),
            "pressure_offset": Separation(
                "hold", "closed valves: a leak changes the pressures over time, an offset does not"
            ),
        },
        inspect="the piston seal of each leaking cylinder: how fast pressure equalises with closed "
        "valves, and the flow at a disconnected rod port",
        repair="If the test confirms the leak, replace that piston seal; look for scoring of the "
        "bore.",
        source="Merritt (1967), section 6.1",
    ),
    "external_leakage": Effect(
        description="oil leaks out of a chamber with its pressure",
        coefficients={"tp": _LEAK, "tr": _LEAK, "lp": _LEAK, "lr": _LEAK, "exponent": _LINEAR},
        balances=FLOWS,
        laws={"flows": flows.external_leakage},
        law="Q = G p_0 (P / p_0)^n out of each chamber, G = tp, tr, lp or lr, n = exponent, "
        "p_0 = 50 bar",
        signals="One chamber needs more oil; with closed valves its pressure falls to zero.",
        confused_with={
            "pressure_offset": Separation(
                "hold", "closed valves: a leak changes the pressures over time, an offset does not"
            ),
        },
        inspect="that chamber for leaking oil: rod seal, fittings and the valve's ports",
        repair="If oil leaks there, replace the rod seal, or tighten the fitting.",
        source="Merritt (1967), section 6.1",
    ),
}
