"""Messages of a fit: bounds, disagreement of methods, friction beyond the measured speeds."""

from collections.abc import Mapping

import numpy as np

from hbench.analysis.fitting.information import Information, covariance_of_all
from hbench.analysis.statistics.trial_levels import TrialLevels
from hbench.records import FitParameter

BEYOND = 1.2  # of the highest speed: end of the extrapolated line
_UNCERTAIN = 0.05  # of the friction there: a larger uncertainty gives a warning
_SIGNIFICANT = 0.05
_NOTHING = 1e-6  # of what typical parameters make there: an exact fit knows friction that well


def bound_messages(parameters: Mapping[str, FitParameter]) -> list[str]:
    """Return a sentence on each parameter at a bound, with its one-sided limit."""
    messages = []
    for name, p in parameters.items():
        if p.at_bound:
            far = p.ci95 and p.ci95[1 if p.at_bound == "lower" else 0]
            limit = "" if far is None else f" (95 % limit {_with_unit(far, p.unit)})"
            value = _with_unit(p.value, p.unit)
            messages.append(f"{name} is at its {p.at_bound} bound {value}{limit}")
    return messages


def _with_unit(value: float, unit: str) -> str:
    """Write a parameter's value; a speed in mm/s, as on the pages."""
    value, unit = (1e3 * value, "mm/s") if unit == "m/s" else (value, unit)
    return f"{float(f'{value:.3g}'):g} {unit}"


def level_messages(levels: TrialLevels | None) -> list[str]:
    """Return a sentence on significantly different levels of the trials."""
    if levels is None or not levels.p < _SIGNIFICANT:
        return []
    return [f"the trials differ in level (p = {levels.p:.2g}): the intervals contain this"]


def disagreements(parameters: Mapping[str, FitParameter]) -> list[str]:
    """Return a sentence on the parameters whose intervals differ between methods."""
    names = [name for name, p in parameters.items() if p.disagree]
    if not names:
        return []
    return [f"linearised and profile-likelihood intervals of {', '.join(names)} differ"]


def beyond_messages(info: Information, factor: float) -> list[str]:
    """Return a warning if friction at 1.2 times the highest speed is more uncertain than 5 %."""
    high = float(info.inputs[0].max())
    inputs = np.repeat(info.inputs.mean(axis=1)[:, None], 2, axis=1)
    inputs[0] = high, BEYOND * high
    g = info.law.jacobian(inputs, info.x)
    at, beyond = factor * np.sqrt(np.sum(g @ covariance_of_all(info) * g, axis=1))
    nothing = _NOTHING * float(np.linalg.norm(g[1] * info.scale))
    if not beyond > _UNCERTAIN * abs(info.law.model(inputs, info.x)[1]) + nothing:
        return []
    return [
        f"do not extrapolate: friction is uncertain by {_two_digits(beyond)} N at "
        f"{1e3 * BEYOND * high:.3g} mm/s, by {_two_digits(at)} N at the highest measured speed"
    ]


def _two_digits(force_n: float) -> str:
    return f"{float(f'{force_n:.2g}'):g}"
