"""Section of the campaign's report with the decisions of the last ``hbench accept``."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace

from hbench.records.conformity.acceptance import (
    WORST_FIRST,
    Conformity,
    ConformityCheck,
    Requirement,
    Rule,
)
from hbench.report.conformity.decision_figure import DecisionRow, draw_decisions
from hbench.report.conformity.text import (
    check_words,
    conforms_words,
    leakage_legend,
    legend,
    limit_words,
    measured_words,
    probability_words,
    requirement_words,
    rule_words,
    series_words,
    without_common_load,
    without_common_rod_pressure,
)
from hbench.report.render.document import Section
from hbench.report.render.figures import Drawing
from hbench.report.render.numbers import NONE, significant
from hbench.report.render.word_tables import Cell, Table
from hbench.sentences import capital, listed, plural
from hbench.units import from_si

_HEAD = ("Quantity", "Limit", "Test", "Measured ± U", "Conforms", "Decision")
_SURE = 0.999  # probability of conformity that is not worth a word
_NUMBERS = {"Measured ± U", "Conforms"}
_OUTCOMES: dict[Conformity, tuple[str, str]] = {  # of one check and of several
    "PASS": ("passes", "pass"),
    "FAIL": ("fails", "fail"),
    "MARGINAL": ("is too near its limit for its U", "are too near their limits for their U"),
    "NOT TESTED": ("is not decided", "are not decided"),
}


def decision_section(
    decision: Conformity,
    checks: Sequence[ConformityCheck],
    rule: Rule | None = None,
    largest_uncertainty: float | None = None,
    limits: str = "",
    drawings: tuple[Drawing, ...] = (),
) -> Section:
    """Return the decision on the cylinder and a row for each of its checks, the worst first.

    ``rule`` is the decision rule with its largest uncertainty, ``limits`` the name of the file of
    limits. The only paragraph states the decision, and the value that decides it with its limit
    and its probability of conformity. What is the same in all checks is a fact beside the figure;
    the table is below. ``drawings`` are those of ``decision_drawings``.
    """
    load, checks = _shown(checks)
    table = Table(_HEAD, tuple(_rows(checks)), frozenset(_HEAD) - _NUMBERS, title="Decisions")
    known = [check.probability for check in checks if check.probability is not None]
    words = [f"load: {load}"] if load else []
    words += [f"limits: the file {limits}, applied by the last hbench accept"] if limits else []
    words += [f"rule: {rule_words(rule, largest_uncertainty)}"] if rule else []
    terms = [conforms_words(checks)] if known else []
    terms += [*legend(checks), *leakage_legend(checks)]
    inner = Section("Probability of conformity, and U", facts=tuple(map(_fact, terms)), folded=True)
    paragraph = " ".join(filter(None, (_which(decision, checks), nearest_words(decision, checks))))
    if not checks:
        return Section("Decision", (paragraph,))
    return Section(
        "Decision",
        (paragraph,),
        drawings=drawings,
        facts=(*_undecided(checks), *map(_fact, words)),
        parts=(Section(tables=(table,)), *([inner] if terms else [])),
    )


def decision_drawings(
    checks: Sequence[ConformityCheck], rule: Rule | None, simulated: bool, png: bool = False
) -> tuple[Drawing, ...]:
    """Draw the checks in the order of the table; ``png`` draws them as PNG too."""
    _, shown = _shown(checks)
    rows = [
        DecisionRow(
            check,
            f"{capital(requirement_words(check.requirement, check.measurement))}, "
            f"{limit_words(check.requirement)}",
            series_words(check.requirement, check.measurement),
            check.decision,
        )
        for check in shown
    ]
    return draw_decisions(rows, rule, simulated, png)


def _shown(checks: Sequence[ConformityCheck]) -> tuple[str, list[ConformityCheck]]:
    """Return the load that all series have in words, and the checks without it, worst first."""
    return without_common_load(sorted(without_common_rod_pressure(checks), key=_worst_first))


def _rows(checks: Sequence[ConformityCheck]) -> Iterator[tuple[Cell, ...]]:
    """Yield a row for each check; one of the same quantity and limit as above does not repeat them.

    A decision other than PASS is marked.
    """
    above = ("", "")
    for check in checks:
        of = (
            capital(requirement_words(check.requirement, check.measurement)),
            limit_words(check.requirement),
        )
        quantity, limit = ("", "") if of == above else of
        above = of
        yield (
            Cell(quantity),
            Cell(limit),
            Cell(series_words(check.requirement, check.measurement) or NONE),
            Cell(measured_words(check)),
            Cell(probability_words(check.probability)),
            Cell("PASS") if check.decision == "PASS" else Cell("", check.decision),
        )


def _undecided(checks: Sequence[ConformityCheck]) -> Iterator[tuple[str, str]]:
    """Yield each limit that was not decided on, and the reason."""
    for check in checks:
        if check.reason:
            what = capital(check_words(check.requirement, check.measurement))
            yield what, f"{capital(check.reason)}."


def _worst_first(check: ConformityCheck) -> int:
    return WORST_FIRST.index(check.decision) if check.decision in WORST_FIRST else len(WORST_FIRST)


def _fact(line: str) -> tuple[str, str]:
    """Split ``name: words`` and write each with a capital."""
    name, _, words = line.partition(": ")
    return capital(name), f"{capital(words)}."


def _which(decision: Conformity, checks: Sequence[ConformityCheck]) -> str:
    """State the decision, how many checks make it, of which quantities, and how the others end."""
    decisive = [check for check in checks if check.decision == decision]
    if not decisive:
        return f"{decision}."
    count = f"{decision}: {len(decisive)} of {len(checks)} checks"
    outcome = plural(len(decisive), *_OUTCOMES[decision])
    if decision == "PASS":
        return f"{count} {outcome}."
    names = dict.fromkeys(_name(check.requirement) for check in decisive)
    return f"{count} {outcome} ({listed(list(names))}).{_others(decision, checks)}"


def _others(decision: Conformity, checks: Sequence[ConformityCheck]) -> str:
    """Count the decisions on the other checks, the worst first; empty where all of them pass."""
    counts = Counter(check.decision for check in checks if check.decision != decision)
    if not counts.keys() - {"PASS"}:
        return ""
    words = [
        f"{counts[each]} {_OUTCOMES[each][0 if counts[each] == 1 else 1]}"
        for each in WORST_FIRST
        if counts[each]
    ]
    return f" Of the other {counts.total()}, {listed(words)}."


def _name(requirement: Requirement) -> str:
    """Return the name that the file of limits gives a quantity, or else the quantity."""
    return requirement.name or requirement_words(requirement, None)


def nearest_words(decision: Conformity, checks: Sequence[ConformityCheck]) -> str:
    """State the value nearest to its limit, or of a failed cylinder the one farthest beyond.

    Near is counted in U. Empty where no U is known, and where a limit was not tested.
    """
    known = [(margin, check) for check in checks if (margin := check.margin_in_u) is not None]
    if not known or decision == "NOT TESTED":
        return ""
    margin, check = min(known, key=lambda each: each[0])
    measured = check.measurement
    if measured is None or (margin < 0) != (decision == "FAIL"):
        return ""
    what = f"{'Farthest beyond' if margin < 0 else 'Nearest to'} its limit in multiples of U"
    which = check_words(check.requirement, replace(measured, p_lr_ref_pa=None))
    name, named, of = which.partition(": ")
    which = f"{name} ({of})" if named else which
    unit = check.requirement.unit
    size = significant(abs(from_si(check.requirement.margin(measured.value), unit)), 2)
    sure = check.probability is None or check.probability > _SURE
    conforms = "" if sure else f", probability of conformity {probability_words(check.probability)}"
    by = "margin" if margin >= 0 else "beyond it by"
    return (
        f"{what} is {which}: {measured_words(check)}, limit {limit_words(check.requirement)}, "
        f"{by} {size} {unit}{conforms}."
    )
