"""Unnamed laws in words."""

from collections.abc import Sequence

from hbench.records import UnnamedLaw
from hbench.report.diagnosis.names import balance, gap_number
from hbench.report.render.numbers import number, p_equation, significant
from hbench.sentences import capital, listed, plural

_TERMS = {
    "flow": "inflow",
    "force": "force against extension",
    "friction": "dry friction",
    "supply": "supply pressure",
    "position": "excess of the true travel over the measured one",
}
_VALVES = {"tp": "u_T", "tr": "u_T", "lp": "u_L2", "lr": "u_L1"}  # of each chamber


def law_title(law: UnnamedLaw) -> str:
    """Return balances and quantities of a law in words."""
    return f"{balances_words(law)}: {term(law)} over {words(law)}"


def law_line(law: UnnamedLaw) -> str:
    """Return what a law adds, and what it does to runs outside the fit."""
    before, after = (gap_number(gap) for gap in (law.gap_before, law.gap_after))
    return (
        f"{capital(law_title(law))}, fitted as a table. The gap of runs outside the fit there "
        f"is {before} without and {after} with all unnamed laws ({p_equation(law.p_value)}, score "
        f"{number(law.score, 1)} nats)."
    )


def law_summary(laws: Sequence[UnnamedLaw]) -> str:
    """Return the sentences for the engineer: what is added, how large, and that it has no name.

    Empty without laws.
    """
    if not laws:
        return ""
    parts = []
    for law in laws:
        low, high = (significant(end(law.values), 2) for end in (min, max))
        before, after = (gap_number(gap) for gap in (law.gap_before, law.gap_after))
        parts.append(
            f"{term(law)} of {low} to {high} {law.unit} over {words(law)} "
            f"({balances_words(law)}; gap of runs outside the fit {before} before, {after} after)"
        )
    kind = plural(len(laws), "an unnamed law", "unnamed laws")
    return (
        f"The revised model contains {kind}, fitted as a table: {'; '.join(parts)}. A table "
        "reproduces a deviation but does not show its cause."
    )


def balances_words(law: UnnamedLaw) -> str:
    """Return the balances of a law in words."""
    return listed([balance(name).title for name in law.balances])


def term(law: UnnamedLaw) -> str:
    """Return the term that a law adds to."""
    return _TERMS[law.adds_to.partition("_")[0]]


def words(law: UnnamedLaw) -> str:
    """Return the quantities of a law in words, with their symbols."""
    return " and ".join(" ".join(filter(None, quantity)) for quantity in law_quantities(law))


def law_quantities(law: UnnamedLaw) -> list[tuple[str, str]]:
    """Return each quantity of a law in words, and its symbol; empty where it has none."""
    part = law.adds_to.partition("_")[2]
    cylinder = part[:1].upper()
    symbols = {
        "piston_pressure": f"P_{cylinder}p",
        "rod_pressure": f"P_{cylinder}r",
        "opening": _VALVES.get(part, ""),
    }
    return [(name.replace("_", " "), symbols.get(name, "")) for name in law.quantities]
