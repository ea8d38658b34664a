"""Steps of a hypothesis in one parameter, for columns by finite differences."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.hypothesis import Hypothesis, typical_size
from hbench.reconcile.measured.drift import channel_of, is_drift


def stepped(
    hypothesis: Hypothesis, name: str, widths: Mapping[str, float], size: float
) -> tuple[Hypothesis, float]:
    """Return a hypothesis with one parameter changed, and the change in its units.

    ``name`` is that of a column; ``widths`` are the priors' standard deviations of the factors.
    ``size`` is the step: of a factor's logarithm, or a share of a coefficient's typical size or a
    drift's standard deviation. It is reversed at a coefficient's upper limit.
    """
    if name.startswith("/"):
        path = name[1:]
        factor = hypothesis.factors.get(path, 1.0) * float(np.exp(size))
        return replace(hypothesis, factors={**hypothesis.factors, path: factor}), size / widths[
            path
        ]
    if is_drift(name):
        channel = channel_of(name)
        drift = hypothesis.drifts.get(channel, 0.0) + size
        return replace(hypothesis, drifts={**hypothesis.drifts, channel: drift}), size
    effect, _, key = name.partition(".")
    which = effect, key
    row, current = EFFECTS[effect].coefficients[key], hypothesis.coefficient(which)
    step = max(size * typical_size(which), row.to_si(row.low) - current)
    if current + step > row.to_si(row.high):
        step = -step
    return hypothesis.with_coefficients({which: current + step}), step / typical_size(which)
