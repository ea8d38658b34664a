"""What a fit says of itself in words: bounds, methods that disagree, friction beyond the speeds."""

from collections.abc import Mapping

import numpy as np

from hbench.analysis.fitting.information import Information, covariance_of_all
from hbench.records import FitParameter

BEYOND = 1.2  # of the highest speed: how far a line is drawn beyond it
_UNCERTAIN = 0.05  # of friction there: if it is known no better, a warning
_NOTHING = 1e-6  # of what typical parameters make there: an exact fit knows friction that well


def bound_messages(parameters: Mapping[str, FitParameter]) -> list[str]:
    """Return a sentence on each parameter at a bound, and why its interval has one side."""
    messages = []
    for name, p in parameters.items():
        if p.at_bound:
            far = p.ci95 and p.ci95[1 if p.at_bound == "lower" else 0]
            known = "" if far is None else f", with 95 % certainty not beyond {far:.3g}"
            messages.append(
                f"{name} is at its {p.at_bound} bound {p.value:g} {p.unit}: the data would have it "
                f"{'lower' if p.at_bound == 'lower' else 'higher'}, so its interval has one side"
                f"{known}; its value is the bound's, and the other parameters depend on it"
            )
    return messages


def disagreements(parameters: Mapping[str, FitParameter]) -> list[str]:
    """Return a sentence on the parameters whose intervals differ by method."""
    names = [name for name, p in parameters.items() if p.disagree]
    if not names:
        return []
    return [
        f"the intervals of {' and '.join(names)} disagree by method: the law bends within them, "
        "or a bound is near"
    ]


def beyond_messages(seen: Information, factor: float) -> list[str]:
    """Warn where friction at 1.2 times the highest speed is not known to 5 %."""
    high = float(seen.inputs[0].max())
    inputs = np.repeat(seen.inputs.mean(axis=1)[:, None], 2, axis=1)
    inputs[0] = high, BEYOND * high
    g = seen.law.jacobian(inputs, seen.x)
    at, beyond = factor * np.sqrt(np.sum(g @ covariance_of_all(seen) * g, axis=1))
    nothing = _NOTHING * float(np.linalg.norm(g[1] * seen.scale))
    if not beyond > _UNCERTAIN * abs(seen.law.model(inputs, seen.x)[1]) + nothing:
        return []
    return [
        f"do not extrapolate: friction at {BEYOND * high:.3g} m/s is known to {beyond:.2g} N, "
        f"at the highest measured speed to {at:.2g} N"
    ]
