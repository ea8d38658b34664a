"""A design as text: tables for a terminal, and the JSON file."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

from hbench.records import Check, ControlLoop, Design, Proposal, Reproduced, WordTable
from hbench.report.design.checks import CHECK_HEAD, check_rows
from hbench.report.design.loops import (
    LOOP_HEAD,
    TextRows,
    decay_s,
    gain_db,
    loop_notes,
    loop_rows,
    margin,
    seconds,
)
from hbench.report.design.verdict import loops_verdict, proposal_verdict
from hbench.report.json_documents.values import json_text, json_value
from hbench.report.render.numbers import short, significant
from hbench.report.render.terminal_table import table_lines
from hbench.report.render.terminal_text import wrapped
from hbench.units import from_si

REPRODUCED_HEAD = ("number", "unit", "printed", "obtained", "error %", "agrees", "note")
GRID = (
    "both ends and the middle of the travel, both directions, three speeds up to "
    "half of limits.speed_max, and three loads against the motion up to 45 % of the supply "
    "pressure on the rod side of the test cylinder"
)
_GAINS = 3  # first columns of a row of the loops: name, gain, time constant
_CHAMBERS = ("p_tp", "p_tr", "p_lp", "p_lr")
_VALVES = {"u_T": "test valve", "u_L1": "load valve L1", "u_L2": "load valve L2"}


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
        "margin_ranges": {what: each[:2] for what, each in design.margin_ranges.items()},
        "points_failed": design.points_failed,
        "points": [point._asdict() for point in design.grid],
        "reproduced": [vars(number) for number in design.reproduced],
        "proposal": _proposal(design.proposal),
        "checks": [vars(check) for check in design.checks],
    }
    return json_text(json_value(document))


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
        "other_ratios": [
            {"ratio": ratio, "holds": holds} for ratio, holds in proposal.other_ratios.items()
        ],
        "gains": {
            name: {"gain": gain, "time_constant_s": tau}
            for name, (gain, tau) in proposal.gains.items()
        },
        "bandwidths_rad_s": proposal.bandwidths_rad_s,
        "feedforward_v_s_m": dict(zip(("rod", "piston"), proposal.feedforward, strict=True)),
        "points": proposal.points,
        "left_out": proposal.left_out,
        "loops": [_loop(loop) for loop in proposal.loops],
        "margins": [vars(check) for check in proposal.margins],
        "closed_loop": [vars(check) for check in proposal.closed_loop],
    }


def point_words(design: Design) -> str:
    """Write the operating point on one line."""
    point = design.point
    bar = {name: from_si(point[f"{name}_pa"], "bar") for name in ("p_tp", "p_tr", "p_lp", "p_lr")}
    pressures = ", ".join(f"P_{name[2:].title()} {value:.2f}" for name, value in bar.items())
    volts = ", ".join(
        f"{name} {point[f'{name.lower()}_v']:.3f}" for name in ("u_T", "u_L1", "u_L2")
    )
    return (
        f"x {1e3 * point['x_m']:.4g} mm, v {1e3 * point['v_m_s']:+.4g} mm/s, load "
        f"{design.f_load_n:+.0f} N, {pressures} bar, {volts} V, B {point['viscous_n_s_m']:.0f} "
        "N s/m"
    )


def point_facts(design: Design) -> tuple[tuple[str, str], ...]:
    """Return the operating point as names and values."""
    point = design.point
    bar = {name: f"{from_si(point[f'{name}_pa'], 'bar'):.1f}" for name in _CHAMBERS}
    volts = {name: f"{point[f'{name.lower()}_v']:.3f}".replace("-", "−") for name in _VALVES}
    motion = f"{short(1e3 * point['x_m'])} mm, moving at {short(1e3 * point['v_m_s'])} mm/s"
    return (
        ("Position and speed", f"{motion} (positive: extending)"),
        ("Load", f"{design.f_load_n:+.0f} N".replace("-", "−")),
        ("Test cylinder", f"piston side P_Tp {bar['p_tp']} bar, rod side P_Tr {bar['p_tr']} bar"),
        ("Load cylinder", f"piston side P_Lp {bar['p_lp']} bar, rod side P_Lr {bar['p_lr']} bar"),
        (
            "Valve commands",
            ", ".join(f"{_VALVES[name]} {name} {value} V" for name, value in volts.items()),
        ),
        (
            "Viscous friction",
            f"{point['viscous_n_s_m']:.0f} N s/m, the sum of test and load cylinder (section "
            "friction of the bench file)",
        ),
    )


def basis_facts(design: Design) -> tuple[tuple[str, str], ...]:
    """Return what the design was computed from, and when, as names and values."""
    basis = design.basis
    if basis is None:
        return ()
    sizes = (basis.bore_m, basis.rod_m, basis.stroke_m)
    bore, rod, stroke = (short(1e3 * each) for each in sizes)
    low, high = (short(1e3 * each) for each in basis.travel_m)
    supply, most = (
        short(from_si(each, "bar")) for each in (basis.supply_pa, basis.pressure_max_pa)
    )
    return (
        ("Computed", basis.day),
        ("Bench file", basis.file),
        ("Test cylinder", f"bore {bore} mm, rod {rod} mm, stroke {stroke} mm"),
        ("Supply", f"{supply} bar"),
        (
            "Limits of the board",
            f"position {low} to {high} mm, pressure {most} bar, speed "
            f"{short(1e3 * basis.speed_max_m_s)} mm/s",
        ),
    )


def _feedforward_words(design: Design) -> str:
    """Write the feedforward at the operating point, and that of the bench file beside it."""
    rod, piston = design.feedforward
    words = f"rod side C_ffLr {rod:.3g} V s/m, piston side C_ffLp {piston:.3g} V s/m"
    if design.basis is None:
        return words
    of_rod, of_piston = design.basis.feedforward
    state = "enabled" if design.basis.feedforward_enabled else "not enabled"
    return (
        f"{words}, at this operating point. The bench file has {of_rod:.3g} and {of_piston:.3g} "
        f"V s/m ({state}): the values depend on the operating point"
    )


def range_lines(design: Design) -> list[str]:
    """Return the ranges of the margins over all operating points; nothing without any."""
    ranges: dict[str, dict[str, str]] = {}
    for what, (low, high, _) in design.margin_ranges.items():
        loop, _, kind = what.partition(": ")
        unit, decimals = ("deg", 0) if "phase" in kind else ("dB", 1)
        words = f"{margin(low, decimals)} to {margin(high, decimals)} {unit}"
        ranges.setdefault(loop, {})[kind] = words
    if not ranges:
        return []
    head = ("loop", *dict.fromkeys(kind for kinds in ranges.values() for kind in kinds))
    rows = [(loop, *(kinds.get(kind, "") for kind in head[1:])) for loop, kinds in ranges.items()]
    title = f"margins at all {design.points} operating points: {GRID}"
    return [*wrapped(title), *_table(head, rows), ""]


def facts(design: Design) -> tuple[tuple[str, str], ...]:
    """Return the further results beside the loops as names and values."""
    slowest = decay_s(design.coupled_modulus, design.tick_s)
    together = "unstable" if math.isinf(slowest) else f"stable, slowest pole {seconds(slowest)} s"
    return (
        ("feedforward of the load valves", _feedforward_words(design)),
        (
            "velocity error on a ramp of 100 mm/s^2",
            f"{significant(1e3 * design.ramp_error_m_s, 3)} mm/s",
        ),
        ("three loops together on the board", together),
        (
            "check of the linearisation",
            "its coefficients differ from numerical derivatives of the simulated bench by at most "
            f"{design.jacobian_difference:.0e} of their size",
        ),
    )


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


def proposal_lines(proposal: Proposal) -> tuple[str, ...]:
    """Return the derivation of the gains, a sentence each."""
    order = ", ".join(f"{name} {w:.0f}" for name, w in proposal.bandwidths_rad_s.items())
    return (
        f"bandwidths of the design, a factor of {proposal.ratio:g} apart (--ratio): {order} rad/s",
        f"the fastest gains with these ratios that keep all margins at {proposal.points} points: "
        "positions, loads, speeds, both directions",
        f"feedforward, if it is used: C_ffLr {proposal.feedforward[0]:.3g}, "
        f"C_ffLp {proposal.feedforward[1]:.3g} V s/m",
        *(f"left out: {reason}" for reason in proposal.left_out),
    )


def design_text(design: Design) -> str:
    """Return the design for a terminal, in plain ASCII."""
    verdict = ""
    if design.proposal is not None:
        verdict = f"verdict: {proposal_verdict(design.proposal, design)}"
    elif design.checks:
        verdict = f"verdict: {loops_verdict(design)}"
    results = map(": ".join, facts(design))
    present = design.checks if design.proposal is None else ()
    lines = [
        design.bench,
        *wrapped(verdict),
        "",
        *([*_check_table(present), ""] if present else []),
        *range_lines(design),
        *wrapped(f"operating point: {point_words(design)}"),
        "",
        *_loop_lines(design.loops, design.tick_s),
        *(line for note in loop_notes(design) for line in wrapped(": ".join(note))),
        "",
        *(line for result in results for line in wrapped(result)),
    ]
    if design.reproduced:
        lines += ["", *_table(REPRODUCED_HEAD, reproduced_rows(design.reproduced))]
    if design.proposal is not None:
        proposal = design.proposal
        derived = [line for words in proposal_lines(proposal) for line in wrapped(words)]
        lines += ["", "proposal", *derived, "", gains_yaml(proposal), ""]
        lines += _loop_lines(proposal.loops, design.tick_s)
        checks = (*proposal.margins, *proposal.closed_loop)
        lines += _check_table(checks)
    text = "\n".join(lines).replace("−", "-").replace("–", "-")
    return text.replace("≥", ">=").replace("≤", "<=").replace("∞", "inf")


def _check_table(checks: Sequence[Check]) -> list[str]:
    """Return the checks, those that fail first, without columns that have no entry."""
    rows = [CHECK_HEAD, *check_rows(sorted(checks, key=lambda check: check.holds))]
    columns = [column for column in zip(*rows, strict=True) if any(column[1:])]
    head, *kept = zip(*columns, strict=True)
    return _table(head, kept)


def _loop_lines(loops: Sequence[ControlLoop], tick_s: float) -> list[str]:
    """Return the gains of the loops, then a row for each model of a loop."""
    rows = loop_rows(loops, tick_s)
    gains = [row[:_GAINS] for row in rows if row[0]]
    merits = [(row[0], *row[_GAINS:]) for row in rows]
    head = (LOOP_HEAD[0], *LOOP_HEAD[_GAINS:])
    return [*_table(LOOP_HEAD[:_GAINS], gains), "", *_table(head, merits), ""]


def _table(head: tuple[str, ...], rows: TextRows) -> list[str]:
    _, *lines = table_lines(WordTable("", head, tuple(rows)))
    return lines
