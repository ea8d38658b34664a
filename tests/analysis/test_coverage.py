"""How often the 95 % intervals hold the truth: by method, weights, noise and number of trials.

Campaigns of the source's 15 speeds (``polynomial``) with a Tustin curve and errors of trials that
are drawn here. ``pytest -m slow -s tests/analysis/test_coverage.py`` prints the table.
"""

from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.fitting.fit import fit_law
from hbench.analysis.fitting.tustin import PARAMETER_NAMES, TUSTIN_LAW, tustin_friction
from hbench.config.fitting import Fitting
from tests.support.analysis.chance import binomial_limits

_STEPS = np.arange(1, 16)
_A, _B = np.linalg.solve([[1, 1], [15, 225]], [0.005, 0.2])
SPEEDS = _A * _STEPS + _B * _STEPS**2
TRUTH = np.array([250.0, 500.0, 0.07, 1500.0])
AT_ZERO = np.array([20.0, 500.0, 0.09, 1500.0])  # Coulomb force next to its bound
NOISE = {  # standard deviation of a trial [N] over speed
    "constant": lambda v, f: np.full(len(v), 5.0),
    "of friction": lambda v, f: 0.01 * f,
    "with speed": lambda v, f: 5.0 * (v / v.mean()) ** 0.7,
}


@pytest.fixture
def campaign(make_curve):
    """Return a function that makes a curve of drawn trials."""

    def make(truth, noise, trials, seed):
        friction = tustin_friction(SPEEDS, truth)
        sigma = NOISE[noise](SPEEDS, friction) * np.sqrt(trials / 3)
        rest = np.random.default_rng(seed).standard_normal((15, trials))
        drawn = friction[:, None] + sigma[:, None] * rest
        curve = make_curve(SPEEDS, drawn.mean(axis=1))
        points = [
            replace(point, trials_n=tuple(own), n=trials)
            for point, own in zip(curve.points, drawn.tolist(), strict=True)
        ]
        return replace(curve, points=tuple(points))

    return make


def coverage(campaign, count, noise="constant", trials=3, truth=TRUTH, **how):
    """Return the part of intervals (methods -> (4,)) that hold the truth; no interval does not."""
    inside: dict[str, np.ndarray] = {}
    for seed in range(count):
        fit = fit_law(TUSTIN_LAW, [campaign(truth, noise, trials, seed)], Fitting(**how))
        for i, name in enumerate(PARAMETER_NAMES):
            for method, ends in fit.parameters[name].intervals.items():
                hit = ends is not None and ends[0] <= truth[i] <= ends[1]
                inside.setdefault(method, np.zeros(4))[i] += hit / count
    return inside


def test_profile_intervals_of_three_trials_hold_the_truth(campaign):
    """100 campaigns, four parameters that go together: two standard deviations are 3.5 %."""
    found = coverage(campaign, 100, "with speed")["profile"]
    assert 0.915 <= found.mean() <= 0.985


@pytest.mark.parametrize("count", [60, pytest.param(100, marks=pytest.mark.slow)])
def test_next_to_a_bound_the_profile_holds_the_truth_the_linearised_interval_does_not(
    campaign, count
):
    found = coverage(campaign, count, truth=AT_ZERO)
    least, most = binomial_limits(count, 0.95)
    assert np.all(found["profile"] >= least / count)
    assert found["profile"].mean() < 0.99
    assert found["linearised"].min() < least / count


TABLE = [  # noise, trials, weights, within 93 to 97 %
    ("constant", 3, "equal", True),
    ("constant", 3, "trials", True),
    ("of friction", 3, "trials", True),
    ("with speed", 3, "trials", True),
    ("with speed", 3, "equal", False),  # equal weights are wrong there, and their intervals too
    ("constant", 1, "equal", True),
]


@pytest.mark.slow
@pytest.mark.parametrize(("noise", "trials", "weights", "good"), TABLE)
def test_each_method_holds_the_truth_in_93_to_97_percent(campaign, noise, trials, weights, good):
    """500 campaigns, four parameters that go together: two standard deviations are 1.6 %."""
    found = coverage(campaign, 500, noise, trials, weights=weights, bootstrap=300)
    for method, parts in found.items():
        each = " ".join(f"{100 * part:.1f}" for part in parts)
        print(
            f"noise {noise:11} trials {trials} weights {weights:6} {method:10} "
            f"{100 * parts.mean():.1f} %  ({each})"
        )
    if good:
        assert all(0.914 <= parts.mean() <= 0.986 for parts in found.values())
        assert 0.93 - 0.016 <= found["profile"].mean() <= 0.97 + 0.016
    else:
        assert found["profile"].min() < 0.92 and found["profile"].max() > 0.98


@pytest.mark.slow
def test_next_to_a_bound_each_method_in_500_campaigns(campaign):
    for method, parts in coverage(campaign, 500, truth=AT_ZERO, bootstrap=300).items():
        each = " ".join(f"{100 * part:.1f}" for part in parts)
        print(f"Coulomb force next to its bound: {method:10} {each}")
        assert method != "profile" or np.all(parts > 0.93)
