"""Intervals over curves, against refits by scipy that leave a curve out."""

import re

import numpy as np
import pytest
from scipy.optimize import curve_fit

from hbench.analysis.fitting.tustin import PARAMETER_NAMES
from hbench.analysis.identification.identify import identify_laws
from hbench.analysis.statistics.student import student_factor
from tests.support.analysis.fits import stribeck

SPEEDS = np.linspace(0.005, 0.2, 15)
TRUTH = (250.0, 500.0, 0.07, 1500.0)
CONDITIONS = [(way, load) for way in ("extend", "retract") for load in (-1e3, 0.0, 1e3, 2e3)]


@pytest.fixture
def frictions():
    """Friction (8, 15) of curves whose level scatters by 2 %, and points by 0.5 N."""
    rng = np.random.default_rng(1)
    level = 1 + 0.02 * rng.standard_normal((8, 1))
    return level * stribeck(SPEEDS, *TRUTH) + 0.5 * rng.standard_normal((8, 15))


@pytest.fixture
def tustin(make_curve):
    """Return a function that identifies Tustin's law from friction (8, n) at speeds (n,)."""

    def identify(speeds, frictions):
        rows = zip(CONDITIONS, frictions, strict=True)
        curves = [make_curve(speeds, own, way, load) for (way, load), own in rows]
        return identify_laws(curves, [])[0].fit

    return identify


def test_standard_errors_of_several_curves_are_those_of_refits_without_one(tustin, frictions):
    fit = tustin(SPEEDS, frictions)
    refits = np.array(
        [
            curve_fit(
                stribeck, np.tile(SPEEDS, 7), np.delete(frictions, i, axis=0).ravel(), p0=TRUTH
            )[0]
            for i in range(8)
        ]
    )
    jackknife = np.sqrt(7 / 8 * np.sum((refits - refits.mean(axis=0)) ** 2, axis=0))
    found = [fit.parameters[name] for name in PARAMETER_NAMES]
    np.testing.assert_allclose([p.se for p in found], jackknife, rtol=0.03)
    widths = [p.ci95[1] - p.ci95[0] for p in found]
    assert np.all(widths > 1.97 * student_factor(7) * jackknife)  # G - 1, or fewer
    assert np.all(widths < 2.06 * student_factor(6) * jackknife)
    assert re.search(r"\b8 curves\b", fit.message)


def test_the_same_points_again_narrow_no_interval(tustin, frictions):
    once = tustin(SPEEDS, frictions).parameters
    twice = tustin(np.repeat(SPEEDS, 2), np.repeat(frictions, 2, axis=1)).parameters
    for name in PARAMETER_NAMES:
        assert twice[name].ci95 == pytest.approx(once[name].ci95, rel=1e-4)


def test_an_interval_over_curves_that_leaves_the_bounds_is_not_given(tustin):
    stribeck_speeds = np.array([0.006] * 6 + [0.03] * 2)
    fit = tustin(SPEEDS, np.array([stribeck(SPEEDS, 250, 500, v, 1500) for v in stribeck_speeds]))
    found = fit.parameters["v_stribeck_m_s"]
    assert found.at_bound is None and found.ci95 is None and found.se is None
    assert re.search(r"\bv_stribeck_m_s\b.*\blinearised\b", fit.message)
