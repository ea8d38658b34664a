"""Verdicts on a design: whether the gains pass their checks, and what to do next."""

import math
from collections.abc import Sequence

from hbench.records import Check, ControlLoop, Design, Proposal, Reproduced
from hbench.report.design.checks import cause_of, causes_of, check_value, shown, unstable
from hbench.report.render.numbers import short
from hbench.report.render.symbols import capital

_NAMED = 3  # failed checks in the verdict


def proposal_verdict(proposal: Proposal, tick_s: float) -> str:
    """Return the verdict on a proposal, the next step, and the checks that it fails."""
    checks = (*proposal.margins, *proposal.closed_loop)
    failed = [check for check in checks if not check.holds]
    causes = causes_of(failed)
    if not failed:
        return (
            f"PASS. The proposed gains pass all {len(checks)} checks, in simulation"
            f"{_margins(checks)}. To use them, repeat the command with --write."
        )
    named = [_failed(check, tick_s) for check in failed if not cause_of(check)]
    more = [f"{len(named) - _NAMED} more"] if len(named) > _NAMED else []
    stopped = sum(map(bool, map(cause_of, failed)))
    because = [f"{stopped} because the board stopped itself"] if stopped else []
    listed = "; ".join([*because, *named[:_NAMED], *more])
    several = len(causes) > 1
    why = "".join(
        f" Cause{f' {i}' if several else ''} of the stop: {each}."
        for i, each in enumerate(causes, start=1)
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
            f"{_margins(checks)}. --propose checks all operating points. "
            f"{reproduced_words(design.reproduced)}"
        ).rstrip()
    together = "The three loops together are unstable." if unstable(failed) else ""
    steps = [
        capital(step)
        for loop in design.loops
        if (step := _step(loop, [c for c in failed if c.what.startswith(f"{loop.name}: ")]))
    ]
    return " ".join(
        (
            "FAIL.",
            *filter(None, (together, *(steps or ["Lower the gains K_c."]))),
            f"The present gains fail {len(failed)} of {len(checks)} checks at this operating "
            "point. Run hbench design with --propose to find gains for all operating points.",
            *filter(None, (reproduced_words(design.reproduced),)),
        )
    )


def reproduced_words(numbers: Sequence[Reproduced]) -> str:
    """Return how many numbers of the source agree with those computed here; empty without any."""
    agree = sum(number.agrees for number in numbers)
    words = f"{agree} of {len(numbers)} numbers of the source agree with the computed ones."
    return words if numbers else ""


def _margins(checks: Sequence[Check]) -> str:
    """Return the smallest phase margin and gain margin, after a colon."""
    smallest = [
        min(some, key=lambda check: check.value)
        for unit in ("deg", "dB")
        if (some := [check for check in checks if check.unit == unit])
    ]
    words = " and ".join(f"{check_value(check)} {check.unit}" for check in smallest)
    return f": the smallest margins are {words}" if len(smallest) > 1 else ""


def _step(loop: ControlLoop, failed: Sequence[Check]) -> str:
    """Return how to change a loop's gains so that it keeps its margins, and why."""
    if not failed:
        return ""
    why = " and ".join(
        f"its {check.what.partition(': ')[2]} is {check_value(check)} {check.unit} (limit "
        f"{short(check.limit)} {check.unit})"
        for check in failed
    )
    low_gain = [check for check in failed if check.unit == "dB"]
    step = f"lower the gain K_c of the {loop.name} loop"
    if low_gain:  # the open loop is proportional to K_c
        factor = 10 ** ((low_gain[0].value - low_gain[0].limit) / 20)
        step += f" from {loop.gain:.4g} to {_floor(factor * loop.gain):.4g} {loop.gain_unit}"
    if len(failed) > len(low_gain):
        step += " or further" if low_gain else ""
        step += ", or raise its time constant tau_c"
    return f"{step}: {why}."


def _floor(value: float) -> float:
    """Round a positive number down to three significant digits."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return math.floor(value / digit) * digit


def _failed(check: Check, tick_s: float) -> str:
    what, value, limit, unit = shown(check, tick_s)
    unit = "" if unit == "runs" else f" {unit}".rstrip()
    return f"{what} {value}{unit}, limit {limit.lstrip('≥≤ ')}{unit}"
