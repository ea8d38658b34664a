"""Gaps of numbers drawn here, whose scatter and difference are known."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kstest

from hbench.errors import DataError
from hbench.reconcile.gaps.gap_map import (
    RunLevel,
    _paired_trials,
    _permutation_p_values,
    gaps,
    pooled_variance,
    run_gaps,
)
from hbench.reconcile.measured.balances import WindowedRun
from hbench.records import RunPlan, Specimen

NAMES = ("first", "second", "third")
ARRAYS = ("values", "t_s", "x_m", "v_m_s", "load_n")
SIGMA = np.array([2.0, 1e-7, 30.0])
WINDOWS, POINTS = 20, 12


def drawn(rng, trials, shift=0.0, points=POINTS, shared=0.7):
    """Trials whose windows share part of their scatter, as the strokes of a bench do."""
    runs = []
    for point in range(points):
        for trial in range(trials):
            plan = RunPlan(f"{len(runs):04d}", "steady", trial, 0.01 * point, Specimen(1e-3, 8e-4))
            own = rng.standard_normal((WINDOWS, 3)) * np.sqrt(1 - shared**2)
            values = SIGMA * (own + shared * rng.standard_normal(3)) + shift
            at = np.arange(WINDOWS, dtype=float)
            runs.append(WindowedRun(plan, NAMES, values, at, at, at - 9.5, 0 * at, np.zeros(3)))
    return runs


def test_a_right_model_is_as_far_as_the_trials_are():
    found = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        ranked, _ = gaps(drawn(rng, 3), drawn(rng, 3))
        found += [one.gap**2 for one in ranked]
    assert np.mean(found) == pytest.approx(1.0, abs=0.08)


def test_a_shift_of_two_scatters_is_a_gap_of_the_root_of_five():
    """g^2 = 1 + (2 sigma)^2 / sigma^2, for that balance alone, and it stands first."""
    rng = np.random.default_rng(1)
    ranked, found = gaps(
        drawn(rng, 3, points=60, shift=SIGMA * [0, 2, 0]), drawn(rng, 3, points=60)
    )
    assert ranked[0].name == "second"
    assert ranked[0].gap == pytest.approx(np.sqrt(5), rel=0.1)
    assert ranked[0].structured == pytest.approx(2, rel=0.12)
    assert ranked[0].scatter == pytest.approx(SIGMA[1], rel=0.15)
    assert ranked[0].p_value == pytest.approx(0.003)  # 3 names, 1 of 1000 exchanges
    assert all(one.gap < 1.3 and one.p_value > 0.05 for one in ranked[1:])
    assert found.difference.shape == (60 * WINDOWS, 3)


def test_p_values_of_a_right_model_are_even_though_windows_of_a_run_depend_on_one_another():
    found = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        found += _permutation_p_values(_paired_trials(drawn(rng, 3), drawn(rng, 3)), rng).tolist()
    assert kstest(found, "uniform").pvalue > 0.01
    assert 0.01 < np.mean(np.array(found) < 0.05) < 0.10


def test_the_map_tells_where_the_difference_is():
    rng = np.random.default_rng(2)
    slow, fast = drawn(rng, 3, points=60), drawn(rng, 3, points=60)
    for run in slow:
        run.values[run.v_m_s > 0, 0] += 3 * SIGMA[0]
    _, found = gaps(slow, fast)
    retract, extend = (found.gaps(windows) for windows in (found.v_m_s <= 0, found.v_m_s > 0))
    assert extend[0] == pytest.approx(np.sqrt(10), rel=0.1)
    assert retract[0] == pytest.approx(1, abs=0.15)
    assert extend[1:] == pytest.approx(1, abs=0.2)


def test_variances_are_drawn_towards_their_own_distribution():
    """sigma^2 = nu_0 s_0^2 / chi^2(nu_0): what comes out is the posterior's, nearer the truth."""
    rng = np.random.default_rng(3)
    prior, scale, dof = 6.0, 4.0, 2.0
    true = scale * prior / rng.chisquare(prior, 5000)
    seen = true * rng.chisquare(dof, 5000) / dof
    found = pooled_variance(seen, np.full(5000, dof))
    weight = prior / (prior + dof)  # the posterior's, by Bayes' theorem
    assert found == pytest.approx(weight * scale + (1 - weight) * seen, rel=0.1)
    assert np.mean(np.log(found / true) ** 2) < 0.3 * np.mean(np.log(seen / true) ** 2)


def test_equal_variances_become_one():
    rng = np.random.default_rng(4)
    seen = 9.0 * rng.chisquare(2, 4000) / 2
    found = pooled_variance(seen, np.full(4000, 2.0))
    assert np.median(found) == pytest.approx(9.0, rel=0.1)
    assert np.log(found).std() < 0.1 < np.log(seen).std()


def test_single_trials_have_no_scatter_to_compare_with():
    rng = np.random.default_rng(5)
    with pytest.raises(DataError):
        gaps(drawn(rng, 1), drawn(rng, 3))


def test_what_one_trial_lacks_is_left_out_and_trials_may_differ_in_number_and_length():
    rng = np.random.default_rng(6)
    seen, simulated = drawn(rng, 4, points=30), drawn(rng, 2, points=30)
    for run in seen[::4]:
        run.values[:5, 1] = np.nan  # one of four trials, five of twenty windows
        run.values[:, 2] = np.nan
    longer = [
        replace(run, **{name: np.concatenate([getattr(run, name)] * 2) for name in ARRAYS})
        for run in simulated
    ]
    ranked, found = gaps(seen, longer)
    by_name = {one.name: one for one in ranked}
    assert {name: one.windows for name, one in by_name.items()} == {"first": 600, "second": 450}
    assert len(found.t_s) == 600
    assert all(one.gap == pytest.approx(1, abs=0.25) for one in ranked)


def test_one_simulated_run_is_taken_as_exact():
    """d = 0 against four trials' mean: the noise of the mean, s^2/n, is subtracted."""
    rng = np.random.default_rng(7)
    seen = drawn(rng, 4, points=60)
    means = [
        replace(seen[i], values=np.mean([run.values for run in seen[i : i + 4]], axis=0))
        for i in range(0, len(seen), 4)
    ]
    ranked, _ = gaps(seen, means)
    assert all(one.gap == pytest.approx(np.sqrt(1 - 1 / 4), rel=0.02) for one in ranked)


def test_a_single_run_is_as_far_off_as_it_is_from_the_simulated_mean():
    """Trials at -1, 0 and 1, simulated ones at -2 +- a: 1, 2 and 3, each less a^2 in the square.

    The variance of three trials is 1 in each window, in which the mean logarithm of a chi-square of
    two degrees of freedom is low by Euler's constant.
    """
    a, unit = 0.6, np.exp(np.euler_gamma)
    rng = np.random.default_rng(8)
    seen, simulated = drawn(rng, 3), drawn(rng, 2)
    for run in seen:
        run.values[:] = SIGMA * (run.plan.trial - 1)
    for run in simulated:
        run.values[:] = SIGMA * (-2 + a * (-1) ** run.plan.trial)
    found = run_gaps(seen, simulated)
    assert list(found) == [run.plan.run for run in seen]
    for run in seen:
        square = (1 + run.plan.trial) ** 2 - a**2
        assert found[run.plan.run] == pytest.approx(np.full(3, np.sqrt(square / unit)))


def test_runs_of_a_right_model_have_a_gap_of_one_and_one_that_went_astray_has_its_own():
    rng = np.random.default_rng(9)
    seen, simulated = drawn(rng, 3, points=60), drawn(rng, 3, points=60)
    astray = seen[70]
    astray.values[:, 1] += 8 * SIGMA[1]
    found = run_gaps(seen, simulated)
    others = [found[run.plan.run] ** 2 for run in seen if run.plan.v_ref_m_s != 0.23]
    assert np.mean(others, axis=0) == pytest.approx(1, abs=0.15)
    assert max(found, key=lambda run: found[run][1]) == astray.plan.run
    assert found[astray.plan.run][1] > 3
    assert found[astray.plan.run][[0, 2]] == pytest.approx(1, abs=0.7)


def test_the_gap_of_all_runs_is_the_root_mean_square_of_theirs():
    """Their own scatter stands in them, and in g as the one that is added."""
    rng = np.random.default_rng(10)
    seen = drawn(rng, 3, points=60, shift=SIGMA * [0, 2, 5])
    simulated = drawn(rng, 3, points=60)
    single = np.sqrt(np.mean([gap**2 for gap in run_gaps(seen, simulated).values()], axis=0))
    ranked, _ = gaps(seen, simulated)
    together = {one.name: one.gap for one in ranked}
    assert single == pytest.approx([together[name] for name in NAMES], rel=0.05)


def test_a_run_has_no_gap_where_it_was_not_compared():
    rng = np.random.default_rng(11)
    seen, simulated = drawn(rng, 3), drawn(rng, 3)
    seen[4].values[:, 2] = np.nan
    found = run_gaps(seen, simulated)
    assert np.isnan(found[seen[4].plan.run][2])
    assert np.isfinite(found[seen[4].plan.run][:2]).all()
    assert np.isfinite(found[seen[7].plan.run]).all()


def test_a_map_of_means_has_one_run_for_each_operating_point():
    """Its windows count as one run: nothing changes between trials any more."""
    rng = np.random.default_rng(12)
    _, found = gaps(drawn(rng, 3), drawn(rng, 3))
    assert np.array_equal(found.run, found.point)
    assert found.white is None and found.material is None and found.levels == ()
    part = found.select_points(np.array([2, 5]))
    assert np.array_equal(np.unique(part.run), [2, 5]) and len(part.t_s) == 2 * WINDOWS
    assert part.points == found.points


def test_another_maps_units_are_its_scatter_and_what_it_knows_of_the_runs():
    rng = np.random.default_rng(13)
    _, one = gaps(drawn(rng, 3), drawn(rng, 3))
    level = RunLevel(slice(0, WINDOWS), 1, np.ones(WINDOWS), 1.0)
    other = replace(
        one, scatter=2 * one.scatter, white=np.ones(3), material=np.full(3, 0.1), levels=(level,)
    )
    found = one.in_units_of(other)
    assert found.scatter is other.scatter and found.levels == (level,)
    assert found.white is other.white and found.material is other.material
    assert found.difference is one.difference
    assert found.select_points(np.array([1])).levels == ()  # slices of all windows


@pytest.mark.parametrize("ridge", [0.2, 1.0])
def test_without_levels_residuals_are_those_that_generalised_least_squares_weighs(ridge):
    """r' (1 + c c' / ridge)^-1 r for the run, in scatters; other runs and balances stay."""
    rng = np.random.default_rng(14)
    _, found = gaps(drawn(rng, 3), drawn(rng, 3))
    change = 3.0 * rng.standard_normal(WINDOWS)
    found = replace(found, levels=(RunLevel(slice(0, WINDOWS), 1, change, ridge),))
    left = found.without_levels()
    before, after = ((one.difference / one.scatter)[:WINDOWS, 1] for one in (found, left))
    covariance = np.eye(WINDOWS) + np.outer(change, change) / ridge
    assert after @ after == pytest.approx(before @ np.linalg.solve(covariance, before))
    own = np.zeros(found.difference.shape, bool)
    own[:WINDOWS, 1] = True
    assert np.array_equal(left.difference[~own], found.difference[~own])


def test_a_level_without_a_change_and_windows_that_are_not_compared_stay():
    rng = np.random.default_rng(15)
    _, found = gaps(drawn(rng, 3), drawn(rng, 3))
    found.difference[0, 1] = np.nan
    own = slice(0, WINDOWS)
    still = replace(found, levels=(RunLevel(own, 1, np.zeros(WINDOWS), 1.0),)).without_levels()
    assert np.array_equal(still.difference, found.difference, equal_nan=True)
    left = replace(found, levels=(RunLevel(own, 1, np.ones(WINDOWS), 1.0),)).without_levels()
    assert np.isnan(left.difference[0, 1]) and np.isfinite(left.difference[1:]).all()
