"""Friction bands, against hand numbers and simulated coverage."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.curves.bands import friction_bands


@pytest.fixture
def side(make_curve):
    """Return a function that makes a curve of one speed from {trial: signed friction}."""

    def make(direction, trials, p_tp_pa=1e5, works_j=(), **changes):
        (point,) = make_curve([0.02], [0.0], direction, f_applied_n=50.0).points
        point = replace(
            point,
            friction_n=float(np.mean(list(trials.values()))),
            n=len(trials),
            p_tp_pa=p_tp_pa,
            trials=tuple(trials),
            trials_n=tuple(trials.values()),
            trials_work_j=works_j,
        )
        curve = make_curve([], [], direction, f_applied_n=50.0)
        return replace(curve, points=(point,), **changes)

    return make


def test_half_and_middle_are_formed_in_each_trial(side):
    extend = side("extend", {1: 8.0, 2: 10.0, 3: 12.0}, p_tp_pa=1.2e5)
    retract = side("retract", {3: -6.0, 1: -4.0, 2: -2.0}, p_tp_pa=1.0e5)
    (band,) = friction_bands([extend, retract])
    # Halves 6, 6, 9: mean 7, S = sqrt(3), so t S / sqrt(3) = 4.303. Middles 2, 4, 3.
    assert band.half_n == pytest.approx(7)
    assert band.half_ci95_n == pytest.approx(4.303, abs=1e-3)
    # S = 1: 4.303 / sqrt(3) = 2.484.
    assert (band.middle_n, band.middle_ci95_n) == (pytest.approx(3), pytest.approx(2.484, abs=1e-3))
    assert (band.n, band.p_tp_pa, band.f_load_n) == (3, pytest.approx(1.1e5), 50.0)


def test_an_error_of_a_trial_common_to_both_directions_does_not_widen_the_interval(side):
    offsets = {1: -30.0, 2: 0.0, 3: 30.0}
    extend = side("extend", {k: 10.0 + offset for k, offset in offsets.items()})
    retract = side("retract", {k: -10.0 + offset for k, offset in offsets.items()})
    (band,) = friction_bands([extend, retract])
    assert band.half_n == pytest.approx(10)
    assert band.half_ci95_n == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("correlation", [-0.9, 0.0, 0.9])
def test_the_interval_covers_the_truth_in_95_of_100_however_the_directions_correlate(
    side, correlation
):
    rng = np.random.default_rng(1)
    inside = []
    for _ in range(1500):
        noise = rng.multivariate_normal([0, 0], [[1, correlation], [correlation, 1]], 3)
        pair = [
            side(direction, dict(enumerate(mean + column, start=1)))
            for direction, mean, column in zip(
                ("extend", "retract"), (10, -8), noise.T, strict=True
            )
        ]
        (band,) = friction_bands(pair)
        inside.append(abs(band.half_n - 9) <= band.half_ci95_n)
    assert abs(np.mean(inside) - 0.95) < 0.018


def test_only_trials_that_both_directions_have_count(side):
    extend = side("extend", {1: 8.0, 2: 10.0, 3: 90.0})
    (band,) = friction_bands([extend, side("retract", {1: -4.0, 2: -2.0, 4: -70.0})])
    assert (band.n, band.half_n) == (2, pytest.approx(6))
    (band,) = friction_bands([extend, side("retract", {2: -2.0})])
    assert (band.n, band.half_n, band.half_ci95_n) == (1, pytest.approx(6), None)
    assert friction_bands([extend, side("retract", {4: -2.0})]) == ()


def test_the_energy_of_a_cycle_is_that_of_both_strokes_of_a_trial(side):
    extend = side("extend", {1: 8.0, 2: 10.0, 3: 12.0}, works_j=(0.3, 0.4, None))
    retract = side("retract", {3: -6.0, 1: -4.0, 2: -2.0}, works_j=(0.9, 0.1, 0.2))
    (band,) = friction_bands([extend, retract])
    # Energies 0.4 and 0.6 of the trials 1 and 2: mean 0.5, 12.706 S / sqrt(2) = 1.2706.
    assert band.n == 3 and band.trials_energy_j == pytest.approx((0.4, 0.6))
    assert band.energy_j == pytest.approx(0.5)
    assert band.energy_ci95_j == pytest.approx(1.2706, abs=1e-4)
    (band,) = friction_bands([side("extend", {1: 8.0}), side("retract", {1: -4.0})])
    assert (band.energy_j, band.energy_ci95_j, band.trials_energy_j) == (None, None, ())


def test_only_directions_of_the_same_load_rod_side_and_label_pair(side):
    extend = side("extend", {1: 8.0})
    for other in ({"f_load_n": 60.0}, {"p_lr_ref_pa": 15e5}, {"label": "NAPN"}, {"kind": "ramp"}):
        assert friction_bands([extend, side("retract", {1: -8.0}, **other)]) == ()


def test_bands_are_sorted_by_pressure_within_their_label(side):
    made = [
        side(direction, {1: sign * 8.0}, bar * 1e5, label=label, f_load_n=50.0 * bar)
        for label in ("O-ring", "NAPN")
        for bar in (7, 1, 3)
        for direction, sign in (("extend", 1), ("retract", -1))
    ]
    found = [(band.label, band.p_tp_pa / 1e5) for band in friction_bands(made)]
    assert found == [(label, bar) for label in ("O-ring", "NAPN") for bar in (1, 3, 7)]


def test_curves_over_velocity_have_no_band(make_curve):
    curves = [make_curve([0.01, 0.02, 0.05], [8, 7, 9], d) for d in ("extend", "retract")]
    assert friction_bands(curves) == ()
