"""Acceptance of a cylinder for the terminal, and its words for all documents."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from hbench.records import DIRECTION_WORDS, WordTable
from hbench.records.conformity.acceptance import (
    WORST_FIRST,
    Acceptance,
    Conformity,
    ConformityCheck,
    LimitQuantity,
    Measurement,
    Requirement,
    Rule,
)
from hbench.records.motions import BULK_MODULUS_ERROR, TEMPERATURE_RATE_K_S
from hbench.records.rod_pressure import differs_in_rod_pressure
from hbench.report.campaign.motion_rows import LEAKS
from hbench.report.render.numbers import NONE, short, significant, with_interval
from hbench.report.render.terminal_table import lines_by_row
from hbench.report.render.terminal_text import plain, wrapped
from hbench.sentences import listed
from hbench.units import from_si

QUANTITIES: dict[LimitQuantity, str] = {
    "friction": "friction",
    "breakaway": "breakaway",
    "efficiency": "efficiency",
    "leakage": "leakage",
    "speed_ripple": "speed ripple",
    "drift": "drift of friction",
}
RULES = {
    "simple": "simple acceptance: the measured value decides",
    "shared_risk": "shared risk: the measured value decides where U is at most {share} of the "
    "limit",
    "guard_band": "guard band: PASS inside the limit by at least U, MARGINAL inside by less, FAIL "
    "beyond the limit",
}
_CONFORMS = (
    "conforms: probability that the true value is within its limit, for a Student distribution "
    "with the 95 % interval of measured value ± U{leakage}"
)
_OF_LEAKAGE = "; an assumption for leakage, whose U has no coverage factor"
_TRIALS_ALONE: tuple[LimitQuantity, ...] = ("speed_ripple", "drift")
_OF_FORCE: tuple[LimitQuantity, ...] = ("friction", "breakaway")
U_OF_LEAKAGE = (
    "the root sum of squares of three parts: the 95 % interval of the fit to all holds, but at "
    "least the leak that changes a pressure by the smallest step of its logged values{step} during "
    f"a hold; an assumed change of the oil temperature at {60 * TEMPERATURE_RATE_K_S:g} K/min, or "
    "at the largest rate measured in a hold if it is larger; "
    f"an assumed error of {100 * BULK_MODULUS_ERROR:.0f} % of the effective bulk modulus"
)
NOT_IN_U_OF_LEAKAGE = "Not in U: errors of dead volumes, drift of transducers, leakage of valves"
_STEPS: dict[Conformity, str] = {
    "FAIL": "check the zeros and the calibration of the instruments, then repeat the test; "
    "if it fails again, do not deliver the cylinder",
    "MARGINAL": "repeat the test with more trials or more accurate instruments (hbench report "
    "shows the parts of U), or agree on another rule with the customer",
}
POOR_STEP = "complete the campaign with --resume, or measure again, before you rely on the decision"
_MEASURE = "measure what is missing"
_CORRECT = "check the signs, zeros and units of the channels, and the areas"
_CORRECT_HOLDS = (
    "check the oil temperature, the drift of the pressure transducers and the leakage of the valves"
)
_REDUCE = "reduce U with more trials or more accurate instruments"


def _decision_lines(checks: Sequence[ConformityCheck]) -> Iterator[str]:
    """Yield the decisions in columns, those on one quantity and limit below a line with both."""
    rows = tuple(
        (
            check.decision,
            measured_words(check),
            probability_words(check.probability),
            ": ".join(
                filter(None, (series_words(check.requirement, check.measurement), check.reason))
            ),
        )
        for check in checks
    )
    table = WordTable("", ("decision", "measured, U", "conforms", "test"), rows)
    head, *decisions = lines_by_row(table)
    yield from head
    above = ""
    for check, decision in zip(checks, decisions, strict=True):
        quantity = requirement_words(check.requirement, check.measurement)
        of = f"{quantity}, limit {limit_words(check.requirement)}"
        if of != above:
            yield from wrapped(of)
        above = of
        yield from decision


def acceptance_text(acceptance: Acceptance) -> str:
    """Return the decision first, then the table, the rule and the notes."""
    cylinder = f"cylinder {acceptance.serial}" if acceptance.serial else acceptance.provenance.name
    product = f", product {acceptance.product}" if acceptance.product else ""
    rule = rule_words(acceptance.rule, acceptance.largest_uncertainty)
    load, checks = without_common_load(without_common_rod_pressure(acceptance.checks))
    poor = acceptance.data == "poor"
    decision = f"{acceptance.decision}{', data poor' if poor else ''}"
    lines = [
        *wrapped(f"{decision}: {cylinder}{product} ({acceptance.provenance.source})"),
        *_decision_lines(checks),
    ]
    remarks = [
        *([f"load: {load}"] if load else []),
        f"rule: {rule}; limits of {acceptance.limits}",
        "U: expanded uncertainty, coverage probability 95 %; hbench report states what it contains",
        *legend(checks),
        *(f"note: {note}" for note in acceptance.notes),
        *([f"next, as the data is poor: {POOR_STEP}"] if poor else []),
        *(f"next, after {each}: {step}" for each, step in next_steps(acceptance.checks)),
    ]
    for remark in remarks:
        lines += wrapped(plain(remark))
    return plain("\n".join(lines))


def conforms_words(checks: Sequence[ConformityCheck]) -> str:
    """Explain the probability of conformity."""
    leaks = any(_measured(check, "leakage") for check in checks)
    return _CONFORMS.format(leakage=_OF_LEAKAGE if leaks else "")


def legend(checks: Sequence[ConformityCheck]) -> Iterator[str]:
    """Explain the symbol of the rod-side pressure, speeds and parts of U where a check has them."""
    without = [q for q in QUANTITIES if any(_lacks_instruments(check, q) for check in checks)]
    if without:
        yield (
            f"U of {listed([QUANTITIES[q] for q in without])}: without the errors of the "
            "instruments, whose tolerances are not known"
        )
    pressures = [q for q in _OF_FORCE if any(_in_bar(check, q) for check in checks)]
    if pressures:
        yield (
            f"{listed([QUANTITIES[q] for q in pressures])} in bar: the force over the driven area, "
            "the piston's while extending and the rod side's while retracting"
        )
    if any(check.requirement.quantity == "breakaway" for check in checks):
        yield "breakaway: the largest friction of the force ramp"
    if any(_measured(check, "speed_ripple") for check in checks):
        yield (
            "speed ripple: standard deviation of the speeds between mean positions over 0.1 s; it "
            "contains 97 % of a ripple of 1 Hz, 41 % at 5 Hz and none at 10 Hz"
        )
    alone = [q for q in _TRIALS_ALONE if any(_measured(check, q) for check in checks)]
    if alone:
        yield f"U of {listed([QUANTITIES[q] for q in alone])}: of the trials alone"
    if any(check.at_worst_speed for check in checks):
        yield (
            "speed: where a limit states none, each series is decided at the speed with the lowest "
            "probability"
        )
    if any("P_Lr" in series_words(c.requirement, c.measurement) for c in checks):
        yield "P_Lr: set pressure on the rod side of the load cylinder"


def leakage_legend(checks: Sequence[ConformityCheck]) -> Iterator[str]:
    """Yield what the U of a leakage contains, where a check has one."""
    if leaks := [check.measurement for check in checks if _measured(check, "leakage")]:
        steps = [leak.step_pa for leak in leaks if leak and leak.step_pa]
        words = U_OF_LEAKAGE.format(step=step_words(max(steps, default=None)))
        yield f"U of {QUANTITIES['leakage']}: {words}. {NOT_IN_U_OF_LEAKAGE}"


def step_words(step_pa: float | None) -> str:
    """Write the smallest step of the logged pressures in brackets; empty where it is not known."""
    return f" ({significant(from_si(step_pa, 'bar'), 2)} bar)" if step_pa else ""


def complete_u(checks: Sequence[ConformityCheck]) -> str:
    """Name the U that contain the instruments, such as ``U of friction``; empty if none does.

    Of speed ripple, drift and leakage they do not; where no such check exists it is just ``U``.
    """
    decided = [q for q in QUANTITIES if any(_measured(check, q) for check in checks)]
    complete = [q for q in decided if q not in (*_TRIALS_ALONE, "leakage")]
    if complete == decided:
        return "U"
    return f"U of {listed([QUANTITIES[q] for q in complete])}" if complete else ""


def _measured(check: ConformityCheck, quantity: LimitQuantity) -> bool:
    return check.requirement.quantity == quantity and check.measurement is not None


def _in_bar(check: ConformityCheck, quantity: LimitQuantity) -> bool:
    return _measured(check, quantity) and check.requirement.unit == "bar"


def _lacks_instruments(check: ConformityCheck, quantity: LimitQuantity) -> bool:
    measured = check.measurement if _measured(check, quantity) else None
    return measured is not None and measured.without_instruments


def next_steps(checks: Sequence[ConformityCheck]) -> Iterator[tuple[Conformity, str]]:
    """Yield each kind of decision but PASS and what to do about it, the worst first."""
    untested = [check for check in checks if check.decision == "NOT TESTED"]
    ways = [_MEASURE] if any(check.measurement is None for check in untested) else []
    decided = [c for c in untested if c.measurement]
    impossible = [
        c for c in decided if c.measurement and c.requirement.is_impossible(c.measurement)
    ]
    of_holds = [check.requirement.quantity == "leakage" for check in impossible]
    ways += [_CORRECT] if not all(of_holds) else []
    ways += [_CORRECT_HOLDS] if any(of_holds) else []
    ways += [_REDUCE] if len(impossible) < len(decided) else []
    steps = _STEPS | {"NOT TESTED": f"{' and '.join(ways)}, then repeat hbench accept"}
    for decision in WORST_FIRST:
        if any(check.decision == decision for check in checks) and decision in steps:
            yield decision, steps[decision]


def check_words(requirement: Requirement, measured: Measurement | None) -> str:
    """Write the quantity and its series."""
    parts = (requirement_words(requirement, measured), series_words(requirement, measured))
    return ", ".join(filter(None, parts))


def rule_words(rule: Rule, largest_uncertainty: float | None) -> str:
    """Write the decision rule; shared risk has the largest U as a share of the limit."""
    return RULES[rule].format(share=f"{100 * (largest_uncertainty or 0):g} %")


def requirement_words(requirement: Requirement, measured: Measurement | None) -> str:
    """Write the quantity, after the name that the file gives it."""
    words = QUANTITIES[requirement.quantity]
    if requirement.leak is not None and requirement.pressure_pa is not None:
        at = short(from_si(requirement.pressure_pa, "bar"))
        words += f" {LEAKS[requirement.leak]} at {at} bar"
    speed = requirement.v_m_s if measured is None else measured.v_m_s
    if speed is not None:
        words += f" at {short(1e3 * speed)} mm/s"
    dwell = requirement.dwell_s if measured is None else measured.dwell_s
    if dwell is not None:
        words += f" after {short(dwell)} s at rest"
    named = requirement.name and requirement.name.lower() != QUANTITIES[requirement.quantity]
    return f"{requirement.name}: {words}" if named else words


def series_words(requirement: Requirement, measured: Measurement | None) -> str:
    """Write label, direction and load of the series; those required where nothing was measured."""
    series = measured or requirement
    words = [series.label, DIRECTION_WORDS[series.direction] if series.direction else ""]
    if series.f_load_n is not None and (series.f_load_n or series.label != "no load"):
        words.append(f"load {short(series.f_load_n)} N")
    if series.p_lr_ref_pa is not None:
        words.append(f"P_Lr {short(from_si(series.p_lr_ref_pa, 'bar'))} bar")
    return ", ".join(filter(None, words))


def without_common_load(
    checks: Sequence[ConformityCheck],
) -> tuple[str, list[ConformityCheck]]:
    """Return the load that all series with one have, in words, and the checks without it.

    The words have the loads of a leakage's holds too.
    """
    loaded = [c for c in checks if c.measurement and c.measurement.f_load_n is not None]
    loads = {check.measurement.f_load_n for check in loaded if check.measurement}
    if len(loads) != 1:
        return "", list(checks)
    quantities = dict.fromkeys(QUANTITIES[check.requirement.quantity] for check in loaded)
    words = [f"{listed(list(quantities))}: {short(loads.pop())} N", *_hold_loads(checks)]
    without = [
        replace(check, measurement=check.measurement and replace(check.measurement, f_load_n=None))
        for check in checks
    ]
    return "; ".join(words), without


def _hold_loads(checks: Sequence[ConformityCheck]) -> Iterator[str]:
    """Yield the set loads of the holds that leakages are from."""
    leaks = [check.measurement for check in checks if _measured(check, "leakage")]
    lows = [leak.lowest_load_n for leak in leaks if leak and leak.lowest_load_n is not None]
    highs = [leak.highest_load_n for leak in leaks if leak and leak.highest_load_n is not None]
    if lows and highs:
        low, high = short(min(lows)), short(max(highs))
        yield f"leakage: holds at {low}" + (f" to {high} N" if high != low else " N")


def without_common_rod_pressure(checks: Sequence[ConformityCheck]) -> list[ConformityCheck]:
    """Return the checks without P_Lr, unless series differ in nothing else."""
    measured = [check.measurement for check in checks if check.measurement]
    if differs_in_rod_pressure(measured):
        return list(checks)
    return [
        replace(
            check, measurement=check.measurement and replace(check.measurement, p_lr_ref_pa=None)
        )
        for check in checks
    ]


def measured_words(check: ConformityCheck) -> str:
    """Write the measured value with U and its unit."""
    if check.measurement is None:
        return NONE
    unit = check.requirement.unit
    value, u95 = check.measurement.value, check.measurement.u95
    half = None if u95 is None else from_si(u95, unit)
    return f"{with_interval(from_si(value, unit), half)} {unit}"


def limit_words(requirement: Requirement) -> str:
    """Write the limits with their unit, such as ``at most 400 N``."""
    unit = requirement.unit
    low, high = (
        None if limit is None else short(from_si(limit, unit))
        for limit in (requirement.low, requirement.high)
    )
    if low is not None and high is not None:
        return f"{low} to {high} {unit}"
    return f"at least {low} {unit}" if high is None else f"at most {high} {unit}"


def probability_words(probability: float | None) -> str:
    """Write the probability of conformity; certainty is not claimed."""
    if probability is None:
        return NONE
    percent = 100 * probability
    if percent > 99.9:
        return "> 99.9 %"
    return "< 0.1 %" if percent < 0.1 else f"{significant(percent, 3)} %"
