"""A design as text: tables for a terminal, and the JSON file."""

import json
import math
from collections.abc import Iterable, Sequence
from typing import Any

from hbench.records import Check, ControlLoop, Design, LoopMerits, Proposal, Reproduced
from hbench.report.json_documents.values import json_value
from hbench.report.render.numbers import short, significant
from hbench.units import from_si

TextRows = list[tuple[str, ...]]

LOOP_HEAD = (
    *("loop", "K_c", "tau_c s", "chain", "bandwidth rad/s", "PM deg", "GM dB"),
    *("overshoot %", "settling s", "largest |z|"),
)
CHAINS = {
    "ideal valve": "the source's design: no dynamics of the valve, the other two loops inactive",
    "valve": "with the second-order dynamics of the valve",
    "board": "with valve, filters and 10 kHz sampling, the other two loops closed",
}
REPRODUCED_HEAD = ("number", "unit", "printed", "obtained", "error %", "agrees", "note")
LIMITS = (
    "Margins are the smallest over all operating points. The closed loop is simulated with the "
    "firmware on the bench as its file states it, and on a softer and a stiffer one."
)
POINT_LIMITS = (
    "Margins of the present gains on the board at the operating point below. With --propose, "
    "hbench design checks all operating points, and the closed loop with the firmware."
)
_CHAMBERS = ("p_tp", "p_tr", "p_lp", "p_lr")
_VALVES = {"u_T": "test valve", "u_L1": "load valve L1", "u_L2": "load valve L2"}
CHECK_HEAD = ("check", "value", "limit", "unit", "holds", "worst at")


def design_json(design: Design) -> str:
    """Return ``design.json``: everything but the curves. An infinite number is null."""
    document = {
        "schema": "hbench.design/1",
        "bench": design.bench,
        "operating_point": design.point,
        "coefficients": design.coefficients,
        "jacobian_difference": design.jacobian_difference,
        "loops": [_loop(loop) for loop in design.loops],
        "feedforward_v_s_m": {"rod": design.feedforward[0], "piston": design.feedforward[1]},
        "ramp_error_m_s": design.ramp_error_m_s,
        "coupled_modulus": design.coupled_modulus,
        "reproduced": [vars(number) for number in design.reproduced],
        "proposal": _proposal(design.proposal),
        "checks": [vars(check) for check in design.checks],
    }
    return json.dumps(json_value(document), indent=1, allow_nan=False) + "\n"


def _loop(loop: ControlLoop) -> dict[str, Any]:
    roots = loop.locus[0]
    return {
        "name": loop.name,
        "gain": loop.gain,
        "gain_unit": loop.gain_unit,
        "time_constant_s": loop.time_constant_s,
        "open_poles_rad_s": [_complex(root) for root in roots.open_poles_rad_s],
        "zeros_rad_s": [_complex(root) for root in roots.zeros_rad_s],
        "chains": [
            {
                **{name: getattr(merits, name) for name in _SCALARS},
                "gain_margin_db": gain_db(merits),
                "poles_rad_s": _roots(merits.poles_rad_s),
                "digital_poles": _roots(merits.digital_poles),
            }
            for merits in loop.merits
        ],
    }


_SCALARS = (
    *("chain", "bandwidth_rad_s", "phase_margin_deg", "phase_margin_rad_s", "gain_margin"),
    *("gain_margin_rad_s", "overshoot", "settling_s", "digital_modulus"),
)


def _roots(values: Iterable[complex] | None) -> list[list[float]] | None:
    return None if values is None else [_complex(value) for value in values]


def _complex(value: complex) -> list[float]:
    return [float(value.real), float(value.imag)]


def _proposal(proposal: Proposal | None) -> dict[str, Any] | None:
    if proposal is None:
        return None
    return {
        "holds": proposal.holds,
        "ratio": proposal.ratio,
        "gains": {
            name: {"gain": gain, "time_constant_s": tau}
            for name, (gain, tau) in proposal.gains.items()
        },
        "bandwidths_rad_s": proposal.bandwidths_rad_s,
        "feedforward_v_s_m": dict(zip(("rod", "piston"), proposal.feedforward, strict=True)),
        "points": proposal.points,
        "left_out": proposal.left_out,
        "margins": [vars(check) for check in proposal.margins],
        "closed_loop": [vars(check) for check in proposal.closed_loop],
    }


def gain_db(merits: LoopMerits) -> float:
    """Return the gain margin in dB."""
    return 20 * math.log10(merits.gain_margin)


def point_words(design: Design) -> str:
    """Write the operating point on one line."""
    point = design.point
    bar = {name: from_si(point[f"{name}_pa"], "bar") for name in ("p_tp", "p_tr", "p_lp", "p_lr")}
    pressures = ", ".join(f"P_{name[2:].title()} {value:.2f}" for name, value in bar.items())
    volts = ", ".join(
        f"{name} {point[f'{name.lower()}_v']:.3f}" for name in ("u_T", "u_L1", "u_L2")
    )
    return (
        f"x {1e3 * point['x_m']:.4g} mm, v {1e3 * point['v_m_s']:+.4g} mm/s, {pressures} bar, "
        f"{volts} V, B {point['viscous_n_s_m']:.0f} N s/m"
    )


def point_facts(design: Design) -> tuple[tuple[str, str], ...]:
    """Return the operating point as names and values."""
    point = design.point
    bar = {name: f"{from_si(point[f'{name}_pa'], 'bar'):.1f}" for name in _CHAMBERS}
    volts = {name: f"{point[f'{name.lower()}_v']:.3f}".replace("-", "−") for name in _VALVES}
    motion = f"{short(1e3 * point['x_m'])} mm, moving at {short(1e3 * point['v_m_s'])} mm/s"
    return (
        ("Position and speed", f"{motion} (positive: extending)"),
        ("Test cylinder", f"piston side P_Tp {bar['p_tp']} bar, rod side P_Tr {bar['p_tr']} bar"),
        ("Load cylinder", f"piston side P_Lp {bar['p_lp']} bar, rod side P_Lr {bar['p_lr']} bar"),
        (
            "Valve commands",
            ", ".join(f"{_VALVES[name]} {name} {value} V" for name, value in volts.items()),
        ),
        ("Viscous friction", f"{point['viscous_n_s_m']:.0f} N s/m"),
    )


def fact_lines(design: Design) -> tuple[str, ...]:
    """Return the further results beside the loops, a sentence each."""
    rod, piston = design.feedforward
    stable = "stable" if design.coupled_modulus < 1 else "UNSTABLE"
    board = [(loop.name, loop.merits[-1]) for loop in design.loops]
    phase, of_phase = min((merits.phase_margin_deg, name) for name, merits in board)
    gain, of_gain = min((gain_db(merits), name) for name, merits in board)
    return (
        f"smallest margins on the board: {_finite(phase, 1)} deg ({of_phase}), "
        f"{_finite(gain, 1)} dB ({of_gain})",
        f"feedforward of the load valves: rod side C_ffLr {rod:.4g} V s/m, piston side C_ffLp "
        f"{piston:.4g} V s/m",
        f"ramp error of the velocity at 100 mm/s^2: {1e3 * design.ramp_error_m_s:.3f} mm/s",
        f"three loops together on the board: largest |z| {design.coupled_modulus:.6f}, {stable}",
        f"largest relative difference of the linearisation by hand and that of the plant's code: "
        f"{design.jacobian_difference:.0e}",
    )


def loop_rows(design: Design) -> TextRows:
    """Return a row for each loop and chain, as ``LOOP_HEAD``."""
    rows: TextRows = []
    for loop in design.loops:
        for merits in loop.merits:
            first = merits is loop.merits[0]
            rows.append(
                (
                    loop.name if first else "",
                    f"{loop.gain:.4g} {loop.gain_unit}" if first else "",
                    f"{loop.time_constant_s:.4g}" if first else "",
                    merits.chain,
                    _finite(merits.bandwidth_rad_s, 1),
                    _finite(merits.phase_margin_deg, 1),
                    _finite(gain_db(merits), 1),
                    _finite(100 * merits.overshoot, 2),
                    _finite(merits.settling_s, 3),
                    f"{merits.digital_modulus:.6f}",
                )
            )
    return rows


def reproduced_rows(numbers: Sequence[Reproduced]) -> TextRows:
    """Return a row for each number of the source, as ``REPRODUCED_HEAD``."""
    return [
        (
            number.quantity,
            number.unit,
            number.printed,
            significant(number.obtained, 5),
            "" if number.error is None else f"{100 * number.error:+.2f}",
            "yes" if number.agrees else "NO",
            number.note,
        )
        for number in numbers
    ]


def check_rows(checks: Sequence[Check]) -> TextRows:
    """Return a row for each check, as ``CHECK_HEAD``."""
    return [
        (
            check.what,
            f"{check.value:.6f}" if "modulus" in check.what else short(check.value),
            short(check.limit),
            check.unit,
            "yes" if check.holds else "NO",
            check.where,
        )
        for check in checks
    ]


def gains_yaml(proposal: Proposal) -> str:
    """Return the proposal as the lines of a bench file."""
    units = {"velocity": "V/m"}
    lines = ["controllers:"]
    for name, (gain, tau) in proposal.gains.items():
        key = name.split()
        lines += [
            f"  {'_'.join(key)}:",
            f"    gain: {gain:.4g} {units.get(name, 'V/(Pa s)')}",
            f"    time_constant: {1e3 * tau:.4g} ms",
        ]
    return "\n".join(lines)


def design_verdict(proposal: Proposal) -> str:
    """Return one sentence on whether the proposal holds."""
    checks = (*proposal.margins, *proposal.closed_loop)
    failed = sum(not check.holds for check in checks)
    if failed:
        return f"verdict: the proposal FAILS {failed} of {len(checks)} checks"
    return f"verdict: the proposal passes all {len(checks)} checks, in simulation"


def page_verdict(proposal: Proposal) -> str:
    """Return the verdict on a proposal, with the checks that it fails."""
    return _verdict((*proposal.margins, *proposal.closed_loop), "The proposal", ", in simulation")


def loops_verdict(design: Design) -> str:
    """Return the verdict on the present gains, with the checks that they fail."""
    if not design.checks:
        return ""
    return _verdict(design.checks, "The present gains", " at this operating point")


def _verdict(checks: Sequence[Check], who: str, where: str) -> str:
    failed = [
        f"{check.what} {short(check.value)} {check.unit}, limit {short(check.limit)} {check.unit}"
        for check in checks
        if not check.holds
    ]
    one = who.endswith("proposal")
    if failed:
        count = f"{len(failed)} of {len(checks)} checks{where}"
        return f"FAIL. {who} {'fails' if one else 'fail'} {count}: {'; '.join(failed)}."
    return f"PASS. {who} {'passes' if one else 'pass'} all {len(checks)} checks{where}."


def proposal_lines(proposal: Proposal) -> tuple[str, ...]:
    """Return the derivation of the gains, a sentence each."""
    order = ", ".join(f"{name} {w:.0f}" for name, w in proposal.bandwidths_rad_s.items())
    return (
        f"bandwidths, a factor of {proposal.ratio:g} apart (ideal valve): {order} rad/s",
        f"margins computed at {proposal.points} points: positions, loads, speeds, both directions",
        f"feedforward, if it is used: C_ffLr {proposal.feedforward[0]:.4g}, "
        f"C_ffLp {proposal.feedforward[1]:.4g} V s/m",
        *(f"left out: {reason}" for reason in proposal.left_out),
    )


def design_text(design: Design) -> str:
    """Return the design for a terminal, in plain ASCII."""
    lines = [
        design.bench,
        f"operating point: {point_words(design)}",
        "",
        *_table(LOOP_HEAD, loop_rows(design)),
        "",
        *(f"{name}: {text}" for name, text in CHAINS.items()),
        *fact_lines(design),
    ]
    if design.reproduced:
        agree = sum(number.agrees for number in design.reproduced)
        lines += ["", *_table(REPRODUCED_HEAD, reproduced_rows(design.reproduced))]
        lines += [f"{agree} of {len(design.reproduced)} numbers of the source agree"]
    if design.proposal is not None:
        proposal = design.proposal
        lines += ["", "proposal", *proposal_lines(proposal), "", gains_yaml(proposal), ""]
        lines += _table(CHECK_HEAD, check_rows((*proposal.margins, *proposal.closed_loop)))
        lines += [design_verdict(proposal)]
    return "\n".join(lines).replace("−", "-").replace("–", "-")


def _table(head: tuple[str, ...], rows: TextRows) -> list[str]:
    rows = [head, *rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]


def _finite(value: float, decimals: int) -> str:
    return f"{value:.{decimals}f}" if math.isfinite(value) else "none"
