"""The revised model as the sections of a plant file."""

import re
from collections.abc import Mapping
from copy import deepcopy
from typing import Any

from hbench.config.friction import LuGre
from hbench.reconcile.linearised import Hypothesis
from hbench.records import FitParameter

_NUMBER = re.compile(r"\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)(.*)$", re.DOTALL)
# The nuisances that a file may leave out, as it would have them.
_DEFAULTS = {"bristle_stiffness": f"{LuGre.model_fields['bristle_stiffness'].default:g} N/m"}


def revised(
    sections: Mapping[str, Any], factors: Mapping[str, FitParameter], hypothesis: Hypothesis
) -> dict[str, Any]:
    """Return a plant's sections with values multiplied by their factors, and with effects."""
    found = deepcopy(dict(sections))
    for path, factor in factors.items():
        *above, last = path.split(".")
        section = found
        for name in above:
            section = section[name]
        given = section[last] if last in section else _DEFAULTS[last]
        section[last] = _times(given, factor.value)
    if hypothesis.effects:
        found["effects"] = {**found.get("effects", {}), **hypothesis.section()}
    return found


def _times(quantity: str | float, factor: float) -> str | float:
    """Multiply what a file has: a number, or one with its unit."""
    if not isinstance(quantity, str):
        return float(f"{quantity * factor:.6g}")
    number, unit = _NUMBER.match(quantity).groups()
    return f"{float(number) * factor:.6g}{unit}"
