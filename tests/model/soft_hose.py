"""A user's own effect, as the docstring of ``hbench/model/effects/catalogue.py`` shows it."""

from hbench.model.effects.catalogue import Coefficient, Effect
from hbench.model.effects.couplings import OilProperties


def cavity(oil, c, state, at, rates, par):
    """A soft hose at the test cylinder's rod side: 1 / beta grows by c."""
    soft = 1.0 / (1.0 / oil.beta_tr + c[0])
    return OilProperties(oil.tank_pa, oil.beta_tp, soft, oil.beta_lp, oil.beta_lr)


EFFECTS = {
    "soft_hose": Effect(
        "1 / beta of Tr grows", {"soft": Coefficient("1/bar", 1e-4, 0, 0.1)},
        ("flow_tr",), {"oil": cavity},
    ),
}  # fmt: skip
