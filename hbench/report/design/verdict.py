"""Verdicts on a design: whether the gains pass their checks, and what to do next."""

import math
from collections.abc import Iterator, Mapping, Sequence

from hbench.records import Check, ControlLoop, Design, MarginRange, Proposal, Reproduced
from hbench.report.design.checks import cause_of, causes_of, check_value, shown, unstable
from hbench.report.design.loops import margin
from hbench.report.render.numbers import short, significant
from hbench.sentences import listed

_SEARCH = (
    "hbench design --propose searches for gains that pass at all operating points, and checks them "
    "with the firmware."
)
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
    """Return what the present gains fail, the worst point first, with a space; or nothing."""
    failed = [check for check in design.checks if not check.holds]
    everywhere = f"The present gains fail {_everywhere(design)} " if design.points_failed else ""
    if not failed:
        return everywhere
    count = f"{len(failed)} of {len(design.checks)} checks at {_here(design)}"
    return f"{everywhere}The present gains fail {count}: {', '.join(_worst(failed))}. "


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
    reproduced = reproduced_words(design.reproduced)
    if not failed and not design.points_failed:
        smallest = _smallest(design.margin_ranges, {})
        smallest = f" The smallest margins of all points are {smallest}." if smallest else ""
        return (
            f"PASS: the present gains pass all {len(checks)} checks at {_here(design)}"
            f"{_margins(checks)}.{smallest} hbench design --propose checks all operating points "
            f"with the firmware. {reproduced}"
        ).rstrip()
    here = list(_failed_here(design, failed)) if failed else []
    if not design.points_failed:
        return " ".join(("FAIL: the present gains fail", *here, _SEARCH, reproduced)).rstrip()
    if here and _is_worst(design):
        there = here[-1].replace("To pass at this point alone", "To pass there alone")
        fail = f"FAIL: the present gains fail {_everywhere(design)}"
        return " ".join((fail, there, _SEARCH, reproduced)).rstrip()
    if here:
        here[0] = f"The gains also fail {here[0]}"
    return " ".join(
        ("FAIL: the present gains fail", _everywhere(design), _SEARCH, *here, reproduced)
    ).rstrip()


def _failed_here(design: Design, failed: Sequence[Check]) -> Iterator[str]:
    """Yield the checks that fail at the operating point of the page, and the step for it alone."""
    margins = _worst([check for check in failed if not unstable([check])])
    worst = f": {', '.join(margins)}" if margins else ""
    yield f"{len(failed)} of {len(design.checks)} checks at {_here(design)}{worst}."
    if unstable(failed):
        yield "There the three loops together are unstable."
    steps = [
        step
        for loop in design.loops
        if (step := _step(loop, [c for c in failed if c.what.startswith(f"{loop.name}: ")]))
    ]
    yield f"To pass at this point alone, {'; '.join(steps or ['lower the gains K_c'])}."


def _is_worst(design: Design) -> bool:
    """Return whether the operating point of the page is that of all smallest margins that fail."""
    x_mm, v_mm_s = 1e3 * design.point["x_m"], 1e3 * design.point["v_m_s"]
    here = f"position {x_mm:.0f} mm, speed {v_mm_s:+.0f} mm/s, load {design.f_load_n:+.0f} N"
    worst = min(design.margin_ranges.values(), key=lambda each: each.low, default=None)
    return worst is not None and worst.where == here


def _here(design: Design) -> str:
    """Return the operating point of the page in words."""
    x_mm, v_mm_s = 1e3 * design.point["x_m"], 1e3 * design.point["v_m_s"]
    return (
        f"the operating point of this design (position {x_mm:.4g} mm, speed {v_mm_s:+.4g} mm/s, "
        f"load {design.f_load_n:+.0f} N)"
    )


def reproduced_words(numbers: Sequence[Reproduced]) -> str:
    """Return how many numbers of the source agree with those computed here; empty without any."""
    agree = sum(number.agrees for number in numbers)
    words = f"{agree} of {len(numbers)} numbers of the source agree with the computed ones."
    return words if numbers else ""


def _everywhere(design: Design) -> str:
    """Return at how many operating points a check fails, the worst margins and what they mean."""
    limits = {check.unit: check.limit for check in design.checks}
    below = {
        what: each
        for what, each in design.margin_ranges.items()
        if each.low < limits.get(_unit(what), -math.inf)
    }
    words = f"a check at {design.points_failed} of {design.points} operating points"
    if smallest := _smallest(below, limits):
        words += f", worst with {smallest}"
    gains = [each.low for what, each in below.items() if _unit(what) == "dB"]
    if gains and min(gains) > 0:
        more = 100 * (10 ** (min(gains) / 20) - 1)
        return (
            f"{words}. Oscillations decay slowly there, and a loop gain {significant(more, 2)} % "
            "above that of the model makes the loop unstable."
        )
    return f"{words}. {'There the loop is unstable: do not run there.' if gains else ''}".rstrip()


def _smallest(ranges: Mapping[str, MarginRange], limits: Mapping[str, float]) -> str:
    """Return the smallest phase margin and gain margin of ranges with their operating points.

    The place is stated once where both have the same.
    """
    sizes, places = [], []
    for unit, decimals in (("deg", 0), ("dB", 1)):
        known = {what: each for what, each in ranges.items() if _unit(what) == unit}
        if known:
            name = min(known, key=lambda what: known[what].low)
            limit = f" (limit {short(limits[unit])} {unit})" if unit in limits else ""
            sizes.append(f"{margin(known[name].low, decimals)} {unit}{limit}")
            places.append(f"in the {name.partition(':')[0]} loop at {known[name].where}")
    if len(set(places)) == 1:
        return f"{listed(sizes)} {places[0]}"
    return listed([f"{size} {place}" for size, place in zip(sizes, places, strict=True)])


def _unit(what: str) -> str:
    """Return the unit of a margin."""
    return "deg" if what.endswith("phase margin") else "dB"


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
