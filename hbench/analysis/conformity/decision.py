"""Decisions on conformity under uncertainty (JCGM 106:2012, ILAC-G8:09/2019).

Of the quantity Y, given a measured value y with the standard uncertainty u,

    (Y - y) / u ~ Student's t with the degrees of freedom of u; normal where they are infinite
    p_c = P(T_L <= Y <= T_U)                                                       (JCGM 106, 7.5)

    simple        PASS where T_L <= y <= T_U, else FAIL                             (JCGM 106, 8.2)
    shared_risk   the same where U95 is small enough to be shared by both sides
    guard_band    PASS where T_L + U95 <= y <= T_U - U95, MARGINAL in the guard bands up to the
                  limits, FAIL beyond them                                       (JCGM 106, 8.3.2)

A value that is impossible beyond its uncertainty decides nothing: it shows an error of a sign, a
zero or an area. A negative leakage shows that the pressures changed for another reason than leaks.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import stdtr

from hbench.analysis.statistics.student import student_factor
from hbench.records.conformity.acceptance import (
    Conformity,
    LimitQuantity,
    Measurement,
    Requirement,
    Rule,
    UntestedCause,
)

_DRIVES = "friction has the direction of the motion"
_IMPOSSIBLE: dict[LimitQuantity, str] = {
    "friction": _DRIVES,
    "breakaway": _DRIVES,
    "efficiency": "the efficiency is above 100 %",
    "leakage": "the leakage is negative by more than U, although no oil leaks against its pressure",
}


class Decision(NamedTuple):
    """Decision with the probability of conformity and, where nothing was decided, the reason."""

    decision: Conformity
    probability: float | None
    reason: str = ""
    causes: tuple[UntestedCause, ...] = ()


def decide(
    requirement: Requirement,
    measured: Measurement,
    rule: Rule,
    largest_uncertainty: float | None = None,
) -> Decision:
    """Return the decision on a measured value; ``largest_uncertainty`` is a share of the limit."""
    if requirement.is_impossible(measured):
        return Decision("NOT TESTED", None, _IMPOSSIBLE[requirement.quantity], ("impossible",))
    probability = probability_of_conformity(requirement, measured)
    inside = requirement.margin(measured.value)
    if rule == "simple":
        return Decision("PASS" if inside >= 0 else "FAIL", probability)
    if measured.u95 is None:
        return Decision("NOT TESTED", None, "the uncertainty is not known", ("u_unknown",))
    if rule == "shared_risk":
        share = measured.u95 / requirement.tolerance
        if largest_uncertainty is None or share > largest_uncertainty:
            most = 100 * (largest_uncertainty or 0)
            reason = f"U is {100 * share:.0f} % of the limit, more than {most:g} %"
            if -inside > measured.u95:
                reason += "; the value is beyond its limit by more than U"
            return Decision("NOT TESTED", probability, reason, ("u_large",))
        return Decision("PASS" if inside >= 0 else "FAIL", probability)
    if inside < 0:
        return Decision("FAIL", probability)
    return Decision("PASS" if inside >= measured.u95 else "MARGINAL", probability)


def probability_of_conformity(requirement: Requirement, measured: Measurement) -> float | None:
    """Return P(T_L <= Y <= T_U); None where the uncertainty is not known."""
    if measured.u95 is None:
        return None
    low = -np.inf if requirement.low is None else requirement.low
    high = np.inf if requirement.high is None else requirement.high
    if measured.u95 == 0:
        return float(low <= measured.value <= high)
    dof = 1e9 if measured.dof is None else measured.dof
    u = measured.u or measured.u95 / student_factor(dof)
    below, above = (stdtr(dof, (limit - measured.value) / u) for limit in (low, high))
    return float(above - below)
