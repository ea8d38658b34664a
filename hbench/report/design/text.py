"""A design as text: tables for a terminal, and the JSON file."""

import json
import math
import re
from collections.abc import Iterable, Sequence
from typing import Any

from hbench.records import Check, ControlLoop, Design, LoopMerits, Proposal, Reproduced
from hbench.report.json_documents.values import json_value
from hbench.report.render.numbers import number, short, significant
from hbench.units import from_si

TextRows = list[tuple[str, ...]]

LOOP_HEAD = (
    *("loop", "K_c", "tau_c s", "chain", "bandwidth rad/s", "PM deg", "GM dB"),
    *("overshoot %", "settling s", "slowest pole s"),
)
LOOP_NOTES = (
    ("K_c, tau_c", "gain and time constant of the PI controller K_c (tau_c s + 1) / s"),
    ("settling", "time until the response to a step of the reference stays within 2 % of the step"),
    ("slowest pole", "time constant -T / ln |z| of the sampled loop's slowest pole; T = {tick} ms"),
)
CHAINS = {
    "ideal valve": "the loop alone, without dynamics of the valve",
    "valve": "the loop alone, with the second-order dynamics of the valve",
    "board": "as the board runs it: with valve, filters and 10 kHz sampling, the other two loops "
    "closed",
}
REPRODUCED_HEAD = ("number", "unit", "printed", "obtained", "error %", "agrees", "note")
LIMITS = (
    "Margins are the smallest over all operating points. The closed loop is simulated with the "
    "firmware on the bench as its file states it, and on a softer and a stiffer one: bulk "
    "modulus, masses and viscous friction are off by 20 %, and on the stiffer one the valves too."
)
POINT_LIMITS = (
    "Margins of the present gains on the board at the operating point below. With --propose, "
    "hbench design checks all operating points, and the closed loop with the firmware."
)
PRESENT = (
    "The table and the figures show the present gains of the bench file, at the operating point "
    "below."
)
_WRITE = (
    " They do not show the proposed gains: write these with --write, then run hbench design again."
)
_CHAMBERS = ("p_tp", "p_tr", "p_lp", "p_lr")
_VALVES = {"u_T": "test valve", "u_L1": "load valve L1", "u_L2": "load valve L2"}
_DECIMALS = {"deg": 0, "dB": 1, "runs": 0}  # of a check's value; two digits in other units
_MOST_DECIMALS = 6
_NAMED = 3  # failed checks in the verdict
_STOPPED = re.compile(r"^run \d+: (the board stopped itself: )(?:\w+: )?")
_LIMIT = re.compile(r"limits\.(\w+)")
_ALLOWED = {"speed_error_time": "longer than allowed", "travel": "the allowed travel"}
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


def facts(design: Design) -> tuple[tuple[str, str], ...]:
    """Return the further results beside the loops as names and values."""
    rod, piston = design.feedforward
    slowest = decay_s(design.coupled_modulus, design.tick_s)
    together = "UNSTABLE" if math.isinf(slowest) else f"stable, slowest pole {_seconds(slowest)} s"
    return (
        (
            "feedforward of the load valves",
            f"rod side C_ffLr {rod:.3g} V s/m, piston side C_ffLp {piston:.3g} V s/m",
        ),
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


def decay_s(modulus: float, tick_s: float) -> float:
    """Return the time constant of a sampled pole, -T / ln |z| [s]; infinite if it does not decay.

    ``tick_s`` is the sampling period T [s].
    """
    return -tick_s / math.log(modulus) if 0.0 < modulus < 1.0 else math.inf


def about_loops(design: Design) -> str:
    """Return which gains the loops' table and figures are of."""
    proposal = design.proposal
    return PRESENT + (_WRITE if proposal is not None and proposal.holds else "")


def loop_notes(design: Design) -> tuple[tuple[str, str], ...]:
    """Return what the rows and columns of the loops' table mean."""
    notes = (*CHAINS.items(), *LOOP_NOTES)
    return tuple((name, text.format(tick=f"{1e3 * design.tick_s:g}")) for name, text in notes)


def loop_rows(design: Design) -> TextRows:
    """Return a row for each loop and chain, as ``LOOP_HEAD``."""
    rows: TextRows = []
    for loop in design.loops:
        for merits in loop.merits:
            first = merits is loop.merits[0]
            overshoot = _finite(100 * merits.overshoot, 0 if merits.overshoot >= 0.1 else 1)
            rows.append(
                (
                    loop.name if first else "",
                    f"{loop.gain:.4g} {loop.gain_unit}" if first else "",
                    f"{loop.time_constant_s:.4g}" if first else "",
                    merits.chain,
                    _finite(merits.bandwidth_rad_s, 0),
                    _finite(merits.phase_margin_deg, 0),
                    _finite(gain_db(merits), 1),
                    overshoot if merits.stable else "none",
                    _seconds(merits.settling_s),
                    _seconds(decay_s(merits.digital_modulus, design.tick_s))
                    if merits.stable
                    else "UNSTABLE",
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


def check_rows(checks: Sequence[Check], tick_s: float) -> TextRows:
    """Return a row for each check, as ``CHECK_HEAD``; ``tick_s`` is the sampling period [s]."""
    causes = _causes(checks)
    return [
        (
            *_shown(check, tick_s),
            "yes" if check.holds else "NO",
            _cause_name(check, causes) or check.where,
        )
        for check in checks
    ]


def _causes(checks: Sequence[Check]) -> tuple[str, ...]:
    """Return why the board stopped itself in the runs of the checks, each cause once."""
    return tuple(dict.fromkeys(filter(None, map(_cause, checks))))


def _cause(check: Check) -> str:
    """Return why the board stopped itself in a check's first failed run; empty if it did not."""
    if check.holds or not _STOPPED.match(check.where):
        return ""
    words = _STOPPED.sub(r"\1", check.where)
    return _LIMIT.sub(lambda found: _ALLOWED.get(found[1], "allowed"), words)


def _cause_name(check: Check, causes: Sequence[str]) -> str:
    """Return which of the verdict's causes is that of a check; empty if none is."""
    cause = _cause(check)
    if not cause:
        return ""
    return "see the cause" if len(causes) == 1 else f"see cause {causes.index(cause) + 1}"


def _shown(check: Check, tick_s: float) -> tuple[str, str, str, str]:
    """Return what a check is of, its value, its limit and their unit."""
    if "modulus" in check.what:
        if check.holds:
            slowest = _seconds(decay_s(check.value, tick_s))
            return "all loops together: time constant of the slowest pole", slowest, "stable", "s"
        return "all loops together: largest |z|", f"{check.value:.6f}", "< 1", ""
    least = "≥ " if "margin" in check.what else "≤ " if check.limit else ""
    return check.what, _value(check), f"{least}{short(check.limit)}", check.unit


def _value(check: Check) -> str:
    """Write a check's value, with as many decimals as show on which side of the limit it is."""
    if not math.isfinite(check.value):
        return "none"
    decimals = _DECIMALS.get(check.unit)
    if decimals is None:
        decimals = len(significant(check.value, 2).partition(".")[2])
    side = check.value >= check.limit, check.value <= check.limit
    while decimals < _MOST_DECIMALS:
        rounded = round(check.value, decimals)
        shown = rounded >= check.limit, rounded <= check.limit
        if shown == side or (check.holds and rounded == check.limit):
            break
        decimals += 1
    return number(check.value, decimals)


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


def proposal_verdict(proposal: Proposal, tick_s: float) -> str:
    """Return the verdict on a proposal, the next step, and the checks that it fails."""
    checks = (*proposal.margins, *proposal.closed_loop)
    failed = [check for check in checks if not check.holds]
    causes = _causes(failed)
    if not failed:
        return (
            f"PASS. The proposed gains pass all {len(checks)} checks, in simulation"
            f"{_margins(checks)}. To use them, repeat the command with --write."
        )
    named = [_failed(check, tick_s) for check in failed if not _cause(check)]
    more = [f"{len(named) - _NAMED} more"] if len(named) > _NAMED else []
    stopped = sum(map(bool, map(_cause, failed)))
    because = [f"{stopped} because the board stopped itself"] if stopped else []
    listed = "; ".join([*because, *named[:_NAMED], *more])
    several = len(causes) > 1
    why = "".join(
        f" Cause{f' {i}' if several else ''}: {each}." for i, each in enumerate(causes, start=1)
    )
    return (
        f"FAIL. Do not use the proposed gains: propose again with another --ratio (now "
        f"{proposal.ratio:g}), or correct the bench file. They fail {len(failed)} of {len(checks)} "
        f"checks, in simulation: {listed}.{why}"
    )


def loops_verdict(design: Design) -> str:
    """Return the verdict on the present gains, the next step, and the checks that they fail."""
    checks = design.checks
    failed = [check for check in checks if not check.holds]
    if not checks:
        return ""
    if not failed:
        return (
            f"PASS. The present gains pass all {len(checks)} checks at this operating point"
            f"{_margins(checks)}. --propose checks all operating points."
        )
    steps = [
        step
        for loop in design.loops
        if (step := _step(loop, [c for c in failed if c.what.startswith(f"{loop.name}: ")]))
    ]
    if any("modulus" in check.what for check in failed):
        steps.append("lower the gains K_c, since the three loops together are unstable")
    text = "; ".join(steps)
    return (
        f"FAIL. {text[:1].upper()}{text[1:]}. The present gains fail {len(failed)} of "
        f"{len(checks)} checks at this operating point. Run hbench design with --propose to find "
        "gains for all operating points."
    )


def _margins(checks: Sequence[Check]) -> str:
    """Return the smallest phase margin and gain margin, after a colon."""
    smallest = [
        min(some, key=lambda check: check.value)
        for unit in ("deg", "dB")
        if (some := [check for check in checks if check.unit == unit])
    ]
    words = " and ".join(f"{_value(check)} {check.unit}" for check in smallest)
    return f": the smallest margins are {words}" if len(smallest) > 1 else ""


def _step(loop: ControlLoop, failed: Sequence[Check]) -> str:
    """Return how to change a loop's gains so that it keeps its margins, and why."""
    if not failed:
        return ""
    why = " and ".join(
        f"its {check.what.partition(': ')[2]} is {_value(check)} {check.unit} (limit "
        f"{short(check.limit)} {check.unit})"
        for check in failed
    )
    low_gain = [check for check in failed if check.unit == "dB"]
    step = f"lower the gain K_c of the {loop.name} loop"
    if low_gain:  # the open loop is proportional to K_c
        factor = 10 ** ((low_gain[0].value - low_gain[0].limit) / 20)
        step += f" from {loop.gain:.3g} to {_floor(factor * loop.gain):.3g} {loop.gain_unit}"
    if len(failed) > len(low_gain):
        step += " or further" if low_gain else ""
        step += ", or raise its time constant tau_c"
    return f"{step}: {why}"


def _floor(value: float) -> float:
    """Round a positive number down to three significant digits."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return math.floor(value / digit) * digit


def _failed(check: Check, tick_s: float) -> str:
    what, value, limit, unit = _shown(check, tick_s)
    unit = "" if unit == "runs" else f" {unit}".rstrip()
    return f"{what} {value}{unit}, limit {limit.lstrip('≥≤ ')}{unit}"


def proposal_lines(proposal: Proposal) -> tuple[str, ...]:
    """Return the derivation of the gains, a sentence each."""
    order = ", ".join(f"{name} {w:.0f}" for name, w in proposal.bandwidths_rad_s.items())
    return (
        f"bandwidths, a factor of {proposal.ratio:g} apart (ideal valve): {order} rad/s",
        f"margins computed at {proposal.points} points: positions, loads, speeds, both directions",
        f"feedforward, if it is used: C_ffLr {proposal.feedforward[0]:.3g}, "
        f"C_ffLp {proposal.feedforward[1]:.3g} V s/m",
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
        *(f"{name}: {text}" for name, text in loop_notes(design)),
        "",
        _smallest_margins(design),
        *(f"{name}: {text}" for name, text in facts(design)),
    ]
    if design.reproduced:
        agree = sum(number.agrees for number in design.reproduced)
        lines += ["", *_table(REPRODUCED_HEAD, reproduced_rows(design.reproduced))]
        lines += [f"{agree} of {len(design.reproduced)} numbers of the source agree"]
    if design.proposal is not None:
        proposal = design.proposal
        lines += ["", "proposal", *proposal_lines(proposal), "", gains_yaml(proposal), ""]
        checks = (*proposal.margins, *proposal.closed_loop)
        lines += _table(CHECK_HEAD, check_rows(checks, design.tick_s))
        lines += [f"verdict: {proposal_verdict(proposal, design.tick_s)}"]
    elif design.checks:
        lines += ["", *_table(CHECK_HEAD, check_rows(design.checks, design.tick_s))]
        lines += [f"verdict: {loops_verdict(design)}"]
    text = "\n".join(lines).replace("−", "-").replace("–", "-")
    return text.replace("≥", ">=").replace("≤", "<=")


def _smallest_margins(design: Design) -> str:
    board = [(loop.name, loop.merits[-1]) for loop in design.loops]
    phase, of_phase = min((merits.phase_margin_deg, name) for name, merits in board)
    gain, of_gain = min((gain_db(merits), name) for name, merits in board)
    return (
        f"smallest margins on the board: {_finite(phase, 0)} deg ({of_phase}), "
        f"{_finite(gain, 1)} dB ({of_gain})"
    )


def _table(head: tuple[str, ...], rows: TextRows) -> list[str]:
    rows = [head, *rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]


def _finite(value: float, decimals: int) -> str:
    return f"{value:.{decimals}f}" if math.isfinite(value) else "none"


def _seconds(value: float) -> str:
    return significant(value, 2) if math.isfinite(value) else "none"
