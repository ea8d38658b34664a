"""The control loops of a design in words: a row for each model of a loop, and its notes."""

import math
from collections.abc import Sequence

from hbench.records import ControlLoop, Design, LoopMerits
from hbench.report.render.numbers import NONE, number, significant

TextRows = list[tuple[str, ...]]

LOOP_HEAD = (
    *("loop", "K_c", "tau_c s", "chain", "bandwidth rad/s", "PM deg", "GM dB"),
    *("overshoot %", "settling s", "slowest pole s"),
)
LOOP_NOTES = (
    ("K_c, tau_c", "gain and time constant of the PI controller K_c (tau_c s + 1) / s"),
    ("settling", "time until the response to a step of the reference stays within 2 % of the step"),
    (
        "slowest pole",
        "time constant -T / ln |z| of the sampled loop's slowest pole; T = {tick} ms. A slow pole "
        "close to a zero hardly shows in the step response",
    ),
)
_UNSTABLE = (
    "unstable",
    "a pole of the sampled loop is outside the unit circle. A margin on the board is that of one "
    "loop with the other two closed: if these are unstable, it does not show stability",
)
CHAINS = {
    "ideal valve": "the loop alone, without dynamics of the valve",
    "valve": "the loop alone, with the second-order dynamics of the valve",
    "board": "as the board runs it: with valve, filters and {rate} kHz sampling, the other two "
    "loops closed",
}
PRESENT, PROPOSED = "present", "proposed"
AT_POINT = "At the operating point of the section above, with the {gains} gains."
FOLDED = "Those with the {gains} gains are folded at the end of this section."


def rate_khz(design: Design) -> str:
    """Write the sampling rate of the board's loops in kHz."""
    return f"{1e-3 / design.tick_s:g}"


def gain_db(merits: LoopMerits) -> float:
    """Return the gain margin in dB."""
    return 20 * math.log10(merits.gain_margin)


def decay_s(modulus: float, tick_s: float) -> float:
    """Return the time constant of a sampled pole, -T / ln |z| [s]; infinite if it does not decay.

    ``tick_s`` is the sampling period T [s].
    """
    return -tick_s / math.log(modulus) if 0.0 < modulus < 1.0 else math.inf


def loops_by_gains(design: Design) -> dict[str, tuple[ControlLoop, ...]]:
    """Return the loops with the gains to be used first: the proposed ones if they pass."""
    loops = {PRESENT: design.loops}
    if design.proposal is not None and design.proposal.loops:
        proposed = {PROPOSED: design.proposal.loops}
        loops = proposed | loops if design.proposal.holds else loops | proposed
    return loops


def loop_notes(design: Design) -> tuple[tuple[str, str], ...]:
    """Return what the rows and columns of the loops' tables mean."""
    every = [loop for loops in loops_by_gains(design).values() for loop in loops]
    stable = all(merits.stable for loop in every for merits in loop.merits)
    notes = (*CHAINS.items(), *LOOP_NOTES, *(() if stable else (_UNSTABLE,)))
    tick, rate = f"{1e3 * design.tick_s:g}", rate_khz(design)
    return tuple((name, text.format(tick=tick, rate=rate)) for name, text in notes)


def loop_rows(loops: Sequence[ControlLoop], tick_s: float) -> TextRows:
    """Return a row for each loop and chain, as ``LOOP_HEAD``; ``tick_s`` is T [s]."""
    rows: TextRows = []
    for loop in loops:
        for merits in loop.merits:
            first = merits is loop.merits[0]
            overshoot = number(100 * merits.overshoot, 0 if merits.overshoot >= 0.1 else 1)
            rows.append(
                (
                    loop.name if first else "",
                    f"{loop.gain:.4g} {loop.gain_unit}" if first else "",
                    f"{loop.time_constant_s:.4g}" if first else "",
                    merits.chain,
                    number(merits.bandwidth_rad_s, 0),
                    margin(merits.phase_margin_deg, 0),
                    margin(gain_db(merits), 1),
                    overshoot if merits.stable else NONE,
                    seconds(merits.settling_s),
                    seconds(decay_s(merits.digital_modulus, tick_s))
                    if merits.stable
                    else "UNSTABLE",
                )
            )
    return rows


def margin(value: float, decimals: int) -> str:
    """Write a phase or gain margin, which is infinite where nothing limits it."""
    return "∞" if value == math.inf else number(value, decimals)


def seconds(value: float) -> str:
    """Write a time with two significant digits; an infinite one is a dash."""
    return significant(value, 2)
