"""Covariance of fitted parameters and the predicted band, against lmfit and uncertainties."""

import lmfit
import numpy as np
import pytest
import uncertainties
from scipy.stats import binom, t
from uncertainties import umath

import hbench
from hbench.errors import ConfigError

TRUTH = np.array([250.0, 500.0, 0.07, 1500.0])
NAMES = ("f_coulomb_n", "f_stiction_n", "v_stribeck_m_s", "b_viscous_n_s_m")
SPEEDS = np.linspace(0.008, 0.2, 12)
AT = np.array([0.0, 0.01, 0.03, 0.06, 0.1, 0.15, 0.2, 0.24])


def tustin(v, f_coulomb_n, f_stiction_n, v_stribeck_m_s, b_viscous_n_s_m):
    stribeck = (f_stiction_n - f_coulomb_n) * np.exp(-v / v_stribeck_m_s)
    return f_coulomb_n + stribeck + b_viscous_n_s_m * v


def drawn(seed, sigma=3.0, speeds=SPEEDS):
    return tustin(speeds, *TRUTH) + sigma * np.random.default_rng(seed).standard_normal(len(speeds))


def matrix(fit, of=None):
    return np.array([[(of or fit.covariance)[a][b] for b in NAMES] for a in NAMES], dtype=float)


def test_covariance_and_correlation_are_lmfits():
    fit = hbench.fit(SPEEDS, drawn(1))
    start = dict(zip(NAMES, TRUTH, strict=True))
    peer = lmfit.Model(tustin).fit(drawn(1), v=SPEEDS, **start)
    covariance = np.array(peer.covar)
    assert tuple(peer.var_names) == NAMES and fit.dof == peer.nfree
    assert matrix(fit) == pytest.approx(covariance, rel=2e-3)
    size = np.sqrt(np.diag(covariance))
    assert matrix(fit, fit.correlation) == pytest.approx(
        covariance / np.outer(size, size), abs=1e-5
    )
    assert fit.correlation["f_coulomb_n"]["b_viscous_n_s_m"] < -0.9
    assert [p.se for p in fit.parameters.values()] == pytest.approx(np.sqrt(np.diag(matrix(fit))))


def test_the_predicted_interval_is_that_of_uncertainties_with_correlated_parameters():
    fit = hbench.fit(SPEEDS, drawn(2))
    values = [fit.parameters[name].value for name in NAMES]
    f_c, f_s, v_s, b = uncertainties.correlated_values(values, matrix(fit).tolist())
    friction, half = fit.predict(AT)
    for v, one, width in zip(AT, friction, half, strict=True):
        peer = f_c + (f_s - f_c) * umath.exp(-v / v_s) + b * v
        assert one == pytest.approx(peer.nominal_value, rel=1e-9)
        assert width == pytest.approx(t.ppf(0.975, fit.dof) * peer.std_dev, rel=1e-6)
    assert half[-1] > half[-2]  # extrapolated


def test_the_band_of_retraction_mirrors_that_of_extension():
    out, back = hbench.fit(SPEEDS, drawn(3)), hbench.fit(-SPEEDS, -drawn(3))
    friction, half = out.predict(AT.reshape(2, 4))
    mirrored, same = back.predict(-AT.reshape(2, 4))
    assert friction.shape == half.shape == (2, 4)
    assert mirrored == pytest.approx(-friction) and same == pytest.approx(half)
    one, width = out.predict(0.1)
    assert one.shape == width.shape == () and float(one) > 0
    for wrong in (-0.1, np.nan, 50.0):
        with pytest.raises(ConfigError, match="predict"):
            out.predict(wrong)


@pytest.mark.parametrize("law", ["tustin", "marton_lantos"])
def test_the_line_of_a_fit_is_what_it_predicts(law):
    fit = hbench.fit(SPEEDS, drawn(4), law)
    v, friction = np.array(fit.line).T
    assert fit.predict(v)[0] == pytest.approx(friction)
    assert np.isfinite(fit.predict(SPEEDS)[1]).all()


def test_as_many_parameters_as_points_have_no_covariance_and_no_band():
    four = SPEEDS[::3]
    fit = hbench.fit(four, tustin(four, *TRUTH))
    assert fit.dof is None and fit.verdict == "not determined"
    assert np.isnan(matrix(fit)).all() and np.isnan(fit.predict(0.1)[1])
    with pytest.raises(ConfigError, match="do not determine"):
        hbench.fit(four[:3], drawn(1, speeds=four[:3])).predict(0.1)


def test_a_parameter_at_a_bound_has_no_covariance_and_counts_as_known():
    fit = hbench.fit(SPEEDS, drawn(5), bounds={"b_viscous_n_s_m": (0.0, 1300.0)})
    assert fit.parameters["b_viscous_n_s_m"].at_bound == "upper"
    known = np.isfinite(matrix(fit))
    assert not known[3].any() and known[:3, :3].all()
    assert np.isfinite(fit.predict(AT)[1]).all()


@pytest.mark.parametrize("count", [60, pytest.param(300, marks=pytest.mark.slow)])
def test_the_predicted_bands_of_drawn_curves_contain_the_law(count):
    """At each speed the count is binomial; wide bounds, so that none is active."""
    wide = {"f_coulomb_n": (-1e5, 1e5), "v_stribeck_m_s": (5e-3, 1.0)}
    truth, inside = tustin(AT, *TRUTH), np.zeros(len(AT))
    for seed in range(count):
        friction, half = hbench.fit(SPEEDS, drawn(seed), bounds=wide).predict(AT)
        inside += np.abs(friction - truth) <= half
    print(f"\npredicted 95 % bands contain the law at {np.round(100 * inside / count, 1)} %")
    low, high = binom.interval(0.999, count, 0.95)
    assert low <= inside.min() and inside.max() <= high
