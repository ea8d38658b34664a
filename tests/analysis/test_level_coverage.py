"""How often intervals of fits contain the truth where the scatter has other forms than assumed.

Curves with an own generator: constant scatter, in proportion to friction, rising towards rest, and
with a level of each trial. ``pytest -m slow -s tests/analysis/test_level_coverage.py``.
"""

import numpy as np
import pytest

from hbench.analysis.fitting.fit import fit_law
from hbench.analysis.fitting.prediction import predict_friction
from hbench.analysis.fitting.tustin import TUSTIN_LAW
from hbench.config.fitting import Fitting
from tests.support.analysis.chance import binomial_limits

TRUTH = np.array([310.0, 540.0, 0.031, 1400.0])
AT = np.array([0.0, 0.004, 0.01, 0.03, 0.1, 0.2])


def tustin(v):
    f_c, f_s, v_s, b = TRUTH
    return f_c + (f_s - f_c) * np.exp(-v / v_s) + b * v


def _rising(v, f):
    return 0.004 * f.mean() + 0.03 * f.mean() * np.exp(-v / 0.03)


FORMS = {  # standard deviations over speed of one trial and of the trials' levels
    "constant": (lambda v, f: 0.01 * f.mean() + 0 * v, lambda v, f: 0 * v),
    "proportional": (lambda v, f: 0.015 * f, lambda v, f: 0 * v),
    "towards rest": (_rising, lambda v, f: 0 * v),
    "level": (lambda v, f: 0.006 * f.mean() + 0 * v, lambda v, f: 0.012 * f.mean() + 0 * v),
    "share": (lambda v, f: 0.006 * f, lambda v, f: 0.015 * f),
}


def coverage(trials_curve, v, form, count, seed=77):
    """Return the parts of the intervals of parameters (4,) and of bands (6,) with the truth."""
    rng, f = np.random.default_rng([seed, len(v)]), tustin(v)
    scatter, level = (of(v, f)[:, None] for of in FORMS[form])
    inputs, inside, band = np.tile(AT, (3, 1)), np.zeros(4), np.zeros(len(AT))
    for _ in range(count):
        e = scatter * rng.standard_normal((len(v), 3)) + level * rng.standard_normal(3)
        fit = fit_law(TUSTIN_LAW, [trials_curve(v, f[:, None] + e)], Fitting())
        ends = [p.ci95 for p in fit.parameters.values()]
        inside += [end is None or end[0] <= x <= end[1] for end, x in zip(ends, TRUTH, strict=True)]
        friction, half = predict_friction(TUSTIN_LAW, fit, inputs)
        band += ~(np.abs(friction - tustin(AT)) > half)
    return inside / count, band / count


@pytest.mark.parametrize("count", [100, pytest.param(300, marks=pytest.mark.slow)])
def test_with_proportional_scatter_at_even_speeds_static_friction_is_inside(trials_curve, count):
    """87 % with weights that count as known. The least of four counts is taken, hence 99 %."""
    inside, _ = coverage(trials_curve, np.linspace(0.005, 0.2, 12), "proportional", count)
    assert inside.min() >= binomial_limits(count, 0.95, 0.99)[0] / count


@pytest.mark.parametrize("count", [40, pytest.param(150, marks=pytest.mark.slow)])
@pytest.mark.parametrize("form", ["level", "share"])
def test_with_a_level_of_each_trial_the_bands_contain_the_law(trials_curve, form, count):
    """25 to 70 % without the levels. The least of ten counts is taken, hence three sigma."""
    v = np.geomspace(0.004, 0.2, 12)
    inside, band = coverage(trials_curve, v, form, count)
    least = binomial_limits(count, 0.95, 0.997)[0] / count
    assert inside.min() >= least and band.min() >= least


CASES = [(form, spacing) for form in FORMS for spacing in (np.geomspace, np.linspace)]
TOO_NARROW = pytest.mark.xfail(
    strict=True, reason="89 % of the bands at the highest of twelve speeds contain the law"
)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("form", "spacing"),
    [
        pytest.param(*case, marks=[TOO_NARROW] if case == ("share", np.linspace) else [])
        for case in CASES
    ],
)
def test_parameters_and_bands_at_6_8_and_12_speeds(trials_curve, form, spacing):
    for n in (6, 8, 12):
        inside, band = coverage(trials_curve, spacing(0.004, 0.2, n), form, 400)
        text = "  ".join(
            " ".join(f"{100 * part:.1f}" for part in parts) for parts in (inside, band)
        )
        print(f"{spacing.__name__:9} {form:12} {n:2} speeds  {text}")
        assert min(inside.min(), band.min()) > 0.905
        assert inside.max() < 0.996
