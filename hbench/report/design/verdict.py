"""Verdicts on a design: whether the gains pass their checks, and what to do next."""

import math
from collections.abc import Sequence

from hbench.records import Check, ControlLoop, Design, Proposal, Reproduced
from hbench.report.design.checks import cause_of, causes_of, check_value, shown, unstable
from hbench.report.design.loops import margin
from hbench.report.render.numbers import short
from hbench.report.render.symbols import listed

_BENCHES = {"bench": " on the bench"}
_BENCHES |= {name: f" on the {name} bench" for name in ("softer", "stiffer")}


def proposal_verdict(proposal: Proposal, design: Design) -> str:
    """Return the verdict on a design's proposal, the next step, and the checks that it fails."""
    checks = (*proposal.margins, *proposal.closed_loop)
    failed = [check for check in checks if not check.holds]
    if not failed:
        return (
            f"PASS: the proposed gains pass all {len(checks)} checks, in simulation"
            f"{_margins(checks)}. {_present(design)}To use the proposed gains, repeat the command "
            "with --write."
        )
    causes = causes_of(failed)
    stopped = sum(map(bool, map(cause_of, failed)))
    stops = f"{stopped} of them fail because the board stopped itself: {'; '.join(causes)}."
    worst = _worst([check for check in failed if not cause_of(check)])
    others = f"{'The worst of the others' if stopped else 'The worst'}: {', '.join(worst)}."
    return " ".join(
        (
            f"FAIL: the proposed gains fail {len(failed)} of {len(checks)} checks in simulation. "
            "Do not use them.",
            *([stops] if stopped else []),
            *([others] if worst else []),
            _next_step(proposal),
            _present(design),
        )
    ).rstrip()


def _present(design: Design) -> str:
    """Return what the present gains fail at the operating point, with a space; empty if nothing."""
    failed = [check for check in design.checks if not check.holds]
    if not failed:
        return ""
    count = f"{len(failed)} of {len(design.checks)} checks at the operating point"
    worst = ", ".join(_worst(failed))
    return f"The present gains fail {count}: {worst}. "


def _next_step(proposal: Proposal) -> str:
    """Return the ratio that passes, or else what failed with every ratio that was tried."""
    for ratio, holds in proposal.other_ratios.items():
        if holds:
            return (
                f"With --ratio {ratio:g} the proposed gains pass all checks: propose again with it."
            )
    tried = listed([f"{ratio:g}" for ratio in (proposal.ratio, *proposal.other_ratios)])
    return (
        f"No ratio of the bandwidths that was tried passes ({tried}): correct the bench file, "
        "first the values that the failed checks depend on."
    )


def _worst(failed: Sequence[Check]) -> list[str]:
    """Return the worst failed check of each quantity, the first of equals, with its limit."""
    words: dict[str, str] = {}
    for check in sorted(failed, key=_excess, reverse=True):
        place, _, quantity = check.what.rpartition(": ")
        _, value, limit, unit = shown(check)
        unit = "" if unit == "runs" else f" {unit}".rstrip()
        where = _BENCHES.get(place, f" in the {place} loop" if place else "")
        text = f"{quantity} {value}{unit} (limit {limit.lstrip('≥≤ ')}{unit}){where}"
        words.setdefault(quantity, text)
    return list(words.values())


def _excess(check: Check) -> float:
    """Return how far a check is beyond its limit, as a share of the limit."""
    beyond = abs(check.value - check.limit)
    return beyond / abs(check.limit) if check.limit else math.inf


def loops_verdict(design: Design) -> str:
    """Return the verdict on the present gains, the next step, and the checks that they fail."""
    checks = design.checks
    failed = [check for check in checks if not check.holds]
    if not checks:
        return ""
    if not failed:
        return (
            f"PASS: the present gains pass all {len(checks)} checks at this operating point"
            f"{_margins(checks)}. {_everywhere(design)}hbench design --propose checks all "
            f"operating points. {reproduced_words(design.reproduced)}"
        ).rstrip()
    margins = _worst([check for check in failed if not unstable([check])])
    count = f"{len(failed)} of {len(checks)} checks at this operating point"
    worst = f": {', '.join(margins)}" if margins else ""
    steps = [
        step
        for loop in design.loops
        if (step := _step(loop, [c for c in failed if c.what.startswith(f"{loop.name}: ")]))
    ]
    return " ".join(
        (
            f"FAIL: the present gains fail {count}{worst}.",
            *(["The three loops together are unstable."] if unstable(failed) else []),
            f"{_everywhere(design)}hbench design --propose finds gains for all operating points.",
            f"For this operating point alone, {'; '.join(steps or ['lower the gains K_c'])}.",
            *filter(None, (reproduced_words(design.reproduced),)),
        )
    )


def reproduced_words(numbers: Sequence[Reproduced]) -> str:
    """Return how many numbers of the source agree with those computed here; empty without any."""
    agree = sum(number.agrees for number in numbers)
    words = f"{agree} of {len(numbers)} numbers of the source agree with the computed ones."
    return words if numbers else ""


def _everywhere(design: Design) -> str:
    """Return the smallest margins over all operating points, with a space; empty if not known."""
    limits = {check.unit: check.limit for check in design.checks}
    parts, worse = [], False
    for kind, unit, decimals in (("phase margin", "deg", 0), ("gain margin", "dB", 1)):
        known = {w: each for w, each in design.margin_ranges.items() if w.endswith(kind)}
        if known:
            name = min(known, key=lambda what: known[what].low)
            low, _, where = known[name]
            loop = name.partition(":")[0]
            parts.append(f"{margin(low, decimals)} {unit} ({loop} loop, at {where})")
            worse |= low < limits.get(unit, -math.inf)
    if not parts:
        return ""
    others = "Other operating points are beyond the limits: over" if worse else "Over"
    count = f"{others} all {design.points} operating points"
    return f"{count}, the smallest margins are {listed(parts)}. "


def _margins(checks: Sequence[Check]) -> str:
    """Return the smallest phase margin and gain margin, after a colon."""
    smallest = [
        min(some, key=lambda check: check.value)
        for unit in ("deg", "dB")
        if (some := [check for check in checks if check.unit == unit])
    ]
    words = " and ".join(
        f"{check_value(check)} {check.unit} (limit {short(check.limit)} {check.unit})"
        for check in smallest
    )
    return f": the smallest margins are {words}" if len(smallest) > 1 else ""


def _step(loop: ControlLoop, failed: Sequence[Check]) -> str:
    """Return how to change a loop's gains so that it keeps its margins; empty if it does."""
    if not failed:
        return ""
    low_gain = [check for check in failed if check.unit == "dB"]
    step = f"lower the gain K_c of the {loop.name} loop"
    if low_gain:  # the open loop is proportional to K_c
        factor = 10 ** ((low_gain[0].value - low_gain[0].limit) / 20)
        step += f" from {loop.gain:.4g} to {_floor(factor * loop.gain):.4g} {loop.gain_unit}"
    if len(failed) > len(low_gain):
        step += " or further" if low_gain else ""
        step += ", or raise its time constant tau_c"
    return step


def _floor(value: float) -> float:
    """Round a positive number down to three significant digits."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return math.floor(value / digit) * digit
