"""Effect of a test's plant that hbench does not know: seals that run in, wear and leak."""

from math import exp, sqrt

from hbench.model.effects.catalogue import Coefficient, Effect
from hbench.model.effects.couplings import ChamberFlows, FrictionTerms
from hbench.model.states import P_TP, P_TR, V


def rubbing(f, c, state, at, rates, par):
    """Dry friction of the test cylinder: + run_in exp(-s / length) - loss s, s the distance."""
    run_in, length, loss, leak = c
    rates[at] = abs(state[V])
    more = run_in * exp(-state[at] / length) - loss * state[at]
    return FrictionTerms(f.dry_t, f.dry_l, f.more_t + more, f.more_l, f.force_t, f.force_l)


def gap(q, c, state, at, rates, par):
    """Orifice across the piston whose area grows with the distance; leak is that at 100 bar."""
    run_in, length, loss, leak = c
    rates[at] = abs(state[V])
    drop = state[P_TP] - state[P_TR]
    across = leak * state[at] * sqrt(abs(drop) / 1e7) * (1.0 if drop > 0.0 else -1.0)
    return ChamberFlows(
        q.tp - across, q.tr + across, q.lp, q.lr, q.drawn, q.returned, q.fluidity
    )  # fmt: skip


EFFECTS = {
    "wear": Effect(
        "seals run in, wear and leak",
        {
            "run_in": Coefficient("N", 100.0, 0, 1000),
            "length": Coefficient("m", 0, 0.1, 1000, 5),
            "loss": Coefficient("N/m", 1.0, -100, 100),
            "leak": Coefficient("ml/min/m", 0.1, 0, 100),
        },
        ("force_test", "flow_tp", "flow_tr"), {"friction": rubbing, "flows": gap}, states=1,
    ),
}  # fmt: skip
