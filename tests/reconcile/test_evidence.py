"""Fits and scores of differences drawn here: their columns, sizes and truth are known."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.optimize import minimize

from hbench.analysis.statistics.permutations import random_signs
from hbench.analysis.statistics.student import student_factor
from hbench.reconcile.evidence.cross_validation import (
    Comparison,
    cross_validate,
    touched,
)
from hbench.reconcile.evidence.likelihood import (
    Fit,
    Priors,
    cost,
    maximum_likelihood,
    most_likely,
    spread,
)
from hbench.reconcile.evidence.products import Products
from hbench.reconcile.evidence.reweighted import _fit_all
from tests.support.reconcile.products import all_products, column_products

NOISE = 1e-3  # variance of d, in squares of the scatter
NEAR = 0.1  # nats: a search decides by 3 and by 5


@dataclass(frozen=True)
class Drawn:
    """Windows of a campaign: d and columns of each (point, group)."""

    d: np.ndarray  # (p, g, w)
    columns: np.ndarray  # (p, g, w, q)

    def products(self, noise=NOISE) -> Products:
        p, g, w, q = self.columns.shape
        return Products(
            names=tuple(f"c{j}" for j in range(q)),
            columns=column_products(np.einsum("pgwj,pgwk->pgjk", self.columns, self.columns)),
            mixed=np.einsum("pgw,pgwj->pgj", self.d, self.columns),
            squares=np.sum(self.d**2, axis=2),
            noise=np.full((p, g), noise * w),
            windows=np.full((p, g), w),
            groups=tuple((f"balance {i}", "steady") for i in range(g)),
        )

    def cost(self, beta, free, chosen, points, noise=NOISE):
        """- ln L by the module's equation, window by window."""
        left = self.d[points] - self.columns[points][..., chosen] @ beta
        variance = np.maximum(np.mean(left**2, axis=(0, 2)), noise)
        off = (beta - free.centre[chosen]) / free.sigma[chosen]
        return 0.5 * len(points) * np.sum(np.log(variance)) + 0.5 * np.sum(off**2)


def drawn(rng, truth, points=30, spread=(0.3, 1.0, 4.0), windows=8, within=0.6):
    """d = columns @ truth + what is left, part of which holds within a point."""
    spread = np.asarray(spread)
    shape = points, len(spread), windows
    own = rng.standard_normal(shape) * np.sqrt(1 - within**2)
    shared = rng.standard_normal(shape[:2])[..., None] * within
    columns = rng.standard_normal((*shape, len(truth)))
    return Drawn(columns @ np.asarray(truth) + spread[:, None] * (own + shared), columns)


def freedom(count, centre=0.0, prior=10.0, low=-50.0, high=50.0):
    return Priors(
        *(np.broadcast_to(one, count).astype(float) for one in (centre, prior, low, high))
    )


def everywhere(data):
    return np.arange(len(data.mixed))


# ---- fit


@pytest.mark.parametrize("seed", range(6))
def test_the_fit_is_at_the_maximum_of_ln_l(seed):
    """Another optimiser, on the windows themselves, finds the same place."""
    rng = np.random.default_rng(seed)
    raw = drawn(rng, [1.5, -0.7, 0.0, 0.2])
    free, chosen, points = freedom(4, prior=[10, 0.1, 1, 3]), [0, 1, 3], np.arange(0, 30, 2)
    beta = maximum_likelihood(raw.products(), free, chosen, points)
    best = minimize(raw.cost, np.zeros(3), (free, chosen, points), tol=1e-10)
    assert raw.cost(beta, free, chosen, points) == pytest.approx(best.fun, abs=NEAR)
    assert beta == pytest.approx(best.x, abs=0.05)


@pytest.mark.parametrize("seed", range(6))
def test_bounds_hold_and_the_others_are_the_best_within_them(seed):
    rng = np.random.default_rng(100 + seed)
    raw = drawn(rng, [3.0, -2.0, 0.5])
    mixing = np.array([[1, 0.5, 0.3], [0, 1, 0.5], [0, 0, 1]])  # so that one's bound moves others
    raw = Drawn(raw.d, raw.columns @ mixing)
    free, points = freedom(3, low=-1.0, high=[1.0, 1.0, 9.0]), np.arange(30)
    beta = maximum_likelihood(raw.products(), free, [0, 1, 2], points)
    best = minimize(
        raw.cost,
        np.zeros(3),
        (free, [0, 1, 2], points),
        method="L-BFGS-B",
        bounds=list(zip(free.low, free.high, strict=True)),
    )
    assert np.all((beta >= free.low) & (beta <= free.high)) and beta[0] == pytest.approx(1.0)
    assert raw.cost(beta, free, [0, 1, 2], points) == pytest.approx(best.fun, abs=NEAR)


def test_one_group_is_generalised_least_squares_with_a_prior():
    """With variances known to be the noise, the closed form: (C'C/v + 1/p^2)^-1 C'd/v."""
    rng = np.random.default_rng(1)
    raw = drawn(rng, [0.4, -0.3], spread=(0.1,), windows=6, within=0.0)
    noise, p = 1.0, 0.05
    beta = maximum_likelihood(raw.products(noise), freedom(2, prior=p), [0, 1], np.arange(30))
    columns, d = raw.columns.reshape(-1, 2), raw.d.ravel()
    weight = 30 / (30 * 6 * noise)  # an operating point counts once
    matrix = weight * columns.T @ columns + np.eye(2) / p**2
    assert beta == pytest.approx(np.linalg.solve(matrix, weight * columns.T @ d), rel=1e-9)


def test_a_damped_step_follows_the_data_and_leaves_alone_what_they_do_not_determine():
    """Damping is a second normal prior, about the present value."""
    product = freedom(1, centre=2.0, prior=0.5).damped(0.5)
    assert (product.centre[0], product.sigma[0]) == pytest.approx((1.0, 0.5 / np.sqrt(2)))
    raw = drawn(np.random.default_rng(3), [3.0, 0.0], within=0.0)
    flat = Drawn(raw.d, raw.columns * [1.0, 1e-3])
    free = freedom(2, centre=[0.0, 5.0], prior=10.0)
    whole, damped = (
        maximum_likelihood(flat.products(), priors, [0, 1], np.arange(30))
        for priors in (free.damped(np.inf), free.damped(0.3))
    )
    assert damped[0] == pytest.approx(whole[0], rel=0.1) and whole[0] > 2.5
    assert whole[1] > 4 and abs(damped[1]) < 0.01


def test_without_a_word_from_the_data_parameters_stay_at_their_priors():
    rng = np.random.default_rng(2)
    raw = drawn(rng, [1.0, 0.0])
    silent = Drawn(raw.d, raw.columns * [1.0, 0.0])
    beta = maximum_likelihood(
        silent.products(), freedom(2, centre=[0.0, -0.7]), [0, 1], np.arange(30)
    )
    assert beta[1] == pytest.approx(-0.7)


def test_groups_of_small_variance_outweigh_the_others():
    """The same column means 1 in a quiet group and 2 in a loud one."""
    rng = np.random.default_rng(3)
    raw = drawn(rng, [1.0], spread=(0.1, 10.0))
    d = raw.d + np.array([0.0, 1.0])[:, None] * raw.columns[..., 0]
    beta = maximum_likelihood(Drawn(d, raw.columns).products(), freedom(1), [0], np.arange(30))
    assert beta[0] == pytest.approx(1.0, abs=0.05)


def test_nulls_are_fitted_as_if_their_signs_were_in_the_data():
    rng = np.random.default_rng(4)
    raw, points = drawn(rng, [1.0, 0.5]), np.arange(25)
    signs = random_signs(3, 30, seed=7)
    data = raw.products()
    together = most_likely(data.sums([0, 1], data.part(points), signs), freedom(2))[0]
    for own, beta in zip(signs, together, strict=True):
        turned = Drawn(raw.d * own[:, None, None], raw.columns)
        assert beta == pytest.approx(
            maximum_likelihood(turned.products(), freedom(2), [0, 1], points)
        )


def test_nulls_need_no_further_compilation():
    """A compilation takes some 3 s."""
    data, free = drawn(np.random.default_rng(4), [1.0, 0.5]).products(), freedom(2)
    for signs in (None, random_signs(1, 30, seed=7), random_signs(3, 30, seed=7)):
        most_likely(data.sums([0, 1], data.part(np.arange(25)), signs), free)
    assert len(_fit_all.signatures) == 1


def test_random_signs_are_fair_and_repeatable():
    signs = random_signs(400, 50, seed=1)
    assert set(np.unique(signs)) == {-1.0, 1.0}
    assert abs(signs.mean()) < 4 / np.sqrt(signs.size)
    assert np.array_equal(signs, random_signs(400, 50, seed=1))
    assert not np.array_equal(signs, random_signs(400, 50, seed=2))


# ---- scores


def gain(data, free, base, more, signs=None):
    """Score of some columns more, with the same priors."""
    before, after = Fit(base, free), Fit([*base, *more], free)
    return Comparison(data, before, after, more, everywhere(data)).score(signs)


def scores(truth, more, count=40):
    found = []
    for seed in range(count):
        raw = drawn(np.random.default_rng(seed), truth)
        data = raw.products()
        found.append(gain(data, freedom(len(truth)), [0], more)[0])
    return np.array(found)


def test_columns_of_noise_do_not_gain_on_points_left_out():
    """k columns of white noise lose k / 2 over the windows of a point, fitted to 4/5 of them."""
    found = scores([1.0, *[0.0] * 5], [1, 2, 3, 4, 5])
    assert found.mean() == pytest.approx(-5 / 2 / 0.8 / 8, abs=0.2)
    assert found.max() < 5  # nats, the least threshold of a search


def test_the_true_column_gains_what_theory_says():
    """n/2 ln(v_before / v_after) in each group, with v_before = v + beta^2 <c^2>."""
    found = scores([1.0, 0.5], [1])
    spread = np.array([0.3, 1.0, 4.0])
    theory = 15 * np.sum(np.log1p(0.5**2 / spread**2))
    assert found.mean() == pytest.approx(theory, rel=0.1)
    assert found.min() > 5


def test_the_null_of_a_true_column_gains_nothing():
    raw = drawn(np.random.default_rng(5), [1.0])
    data = raw.products()
    null = gain(data, freedom(1), [], [0], random_signs(100, 30, seed=1))
    true = gain(data, freedom(1), [], [0])[0]
    assert np.median(null) < 0.5 and true > 3 * null.max()


def test_groups_that_a_candidate_does_not_touch_change_no_score():
    """Columns in some groups alone; shared and unshared nuisances."""
    rng = np.random.default_rng(6)
    raw = drawn(rng, [1.0, 0.4, -0.6, 0.3], spread=(0.5, 1.0, 2.0, 1.0))
    shown = np.array([[1, 0, 0, 0], [1, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1, 1]], bool)  # (g, q)
    data = Drawn(raw.d, raw.columns * shown[:, None]).products()
    free, points = freedom(4), everywhere(data)
    assert list(touched(data, [0, 2], [1])) == [0, 1]

    after, before = (cross_validate(data, free, chosen, points) for chosen in ([0, 2, 1], [0, 2]))
    whole = after.gains_over(before)[0].sum()
    assert gain(data, free, [0, 2], [1])[0] == pytest.approx(whole, abs=1e-6)


def test_a_group_that_shares_a_nuisance_with_atouched_one_counts():
    """Column 0 is in all groups, column 1 in the first: a better beta_0 shows in the others."""
    rng = np.random.default_rng(12)
    raw = drawn(rng, [1.0, 2.0], spread=(0.3, 0.3, 0.3))
    shown = np.array([[1, 1], [1, 0], [1, 0]], bool)
    columns = raw.columns * shown[:, None]
    columns[:, 0, :, 1] += columns[:, 0, :, 0]  # the effect looks like the nuisance there
    d = raw.d - raw.columns @ [1.0, 2.0] + columns @ [1.0, 2.0]
    data = Drawn(d, columns).products()
    assert list(touched(data, [0], [1])) == [0, 1, 2]
    first = cross_validate(data, freedom(2), [0], everywhere(data), groups=np.array([0]))
    assert first.variance.shape == (1, 1)
    before, after = (
        cross_validate(data, freedom(2), chosen, everywhere(data)) for chosen in ([0], [0, 1])
    )
    whole = after.gains_over(before)[0].sum()
    assert gain(data, freedom(2), [0], [1])[0] == pytest.approx(whole)


def test_a_column_within_its_tolerance_gains_only_what_lies_beyond():
    """Both fits have the column; one of them bounds it: a truth inside the bound gains nothing."""
    tight, wide = freedom(1, prior=0.5, low=-1.0, high=1.0), freedom(1)
    gains = {}
    for truth in (0.5, 3.0):
        data = drawn(np.random.default_rng(9), [truth]).products()
        before, after = Fit([0], tight), Fit([0], wide)
        gains[truth] = Comparison(data, before, after, [0], everywhere(data)).score()[0]
    assert abs(gains[0.5]) < 1.0
    spread = np.array([0.3, 1.0, 4.0])
    best = 15 * np.sum(np.log1p(2.0**2 / spread**2))  # what is beyond the bound is 2
    assert gains[3.0] == pytest.approx(best, rel=0.15)


def test_the_cost_of_a_model_as_it_is_is_that_of_its_windows_and_priors():
    """No column has taken anything from d: beta = 0, and priors that are centred elsewhere."""
    raw = drawn(np.random.default_rng(10), [0.3, 0.0])
    free, points = freedom(2, centre=[1.0, -2.0], prior=[2.0, 1.0]), np.arange(3, 28)
    expected = raw.cost(np.zeros(2), free, [0, 1], points)
    assert cost(raw.products(), free, [0, 1], points) == pytest.approx(expected)
    fewer = raw.cost(np.zeros(1), free, [1], points)
    assert cost(raw.products(), free, [1], points) == pytest.approx(fewer)
    assert expected - fewer == pytest.approx(0.5 * (1.0 / 2.0) ** 2)


def test_the_fit_costs_no_more_than_the_model_as_it_is():
    """The cost of the model that has taken the fitted step."""
    rng = np.random.default_rng(11)
    raw, free, points = drawn(rng, [1.5, -0.7]), freedom(2), np.arange(30)
    beta = maximum_likelihood(raw.products(), free, [0, 1], points)
    moved = Drawn(raw.d - raw.columns @ beta, raw.columns).products()
    about = free.shifted(beta)
    assert cost(moved, about, [0, 1], points) == pytest.approx(raw.cost(beta, free, [0, 1], points))
    assert cost(moved, about, [0, 1], points) < cost(raw.products(), free, [0, 1], points) - 5


def test_groups_that_contradict_one_another_are_fitted_near_the_best_of_all_maxima():
    """Every place between is worse; a search decides by 3 nats."""
    for seed in range(4):
        raw = drawn(np.random.default_rng(seed), [0.0], spread=(0.05, 0.05, 0.05), windows=6)
        d = raw.d + np.array([0.0, 3.0, 3.0])[:, None] * raw.columns[..., 0]
        own, free, points = Drawn(d, raw.columns), freedom(1), np.arange(30)
        beta = maximum_likelihood(own.products(), free, [0], points)
        costs = [own.cost(np.array([b]), free, [0], points) for b in np.linspace(-4, 4, 801)]
        assert own.cost(beta, free, [0], points) < min(costs) + 1.0


def test_points_left_out_are_predicted_by_the_others_alone():
    """By hand, fold after fold; and a beta that is given is not fitted at all."""
    raw = drawn(np.random.default_rng(7), [1.0, -0.5])
    data, free, points = raw.products(), freedom(2), np.arange(3, 28)
    total = np.zeros(3)
    for number in range(5):
        out = points[np.arange(len(points)) % 5 == number]
        beta = maximum_likelihood(data, free, [0, 1], np.setdiff1d(points, out))
        total += np.sum((raw.d[out] - raw.columns[out] @ beta) ** 2, axis=(0, 2))
    found = cross_validate(data, free, [0, 1], points)
    assert found.variance[0] == pytest.approx(total / (25 * 8))
    half = replace(found, variance=0.5 * found.variance)
    assert half.gains_over(found)[0] == pytest.approx(0.5 * 25 * np.log(2) * np.ones(3))


def test_less_noise_between_the_trials_is_no_gain():
    found = cross_validate(
        drawn(np.random.default_rng(7), [1.0]).products(), freedom(1), [0], np.arange(30)
    )
    quiet = replace(found, variance=0 * found.variance, noise=found.noise / 9)
    loud = replace(found, variance=0 * found.variance)
    assert not quiet.gains_over(loud).any() and not loud.gains_over(quiet).any()


# ---- intervals


def covered(points, slow, count=200, alike=None, told=True):
    """Share of intervals that hold the truth; points, or groups ``alike``, have own slopes."""
    alike = np.arange(points) if alike is None else alike
    truth, hits = np.array([1.0, -0.5]), 0
    for seed in range(count):
        rng = np.random.default_rng(seed)
        raw = drawn(rng, truth, points, windows=10)
        columns = np.repeat(raw.columns[:, :, :1], 10, axis=2) if slow else raw.columns
        own = truth + 0.5 * rng.standard_normal((points, 1, 1, 2))[alike]
        d = raw.d - raw.columns @ truth + np.sum(columns * own, axis=-1)
        data, free = Drawn(d, columns).products(), freedom(2)
        beta = maximum_likelihood(data, free, [0, 1], everywhere(data))
        groups = alike if told else None
        covariance, _, dof = spread(data, free, [0, 1], beta, everywhere(data), groups)
        half = [
            student_factor(int(n)) * np.sqrt(v)
            for n, v in zip(dof, np.diag(covariance), strict=True)
        ]
        hits += np.abs(beta - truth) < half
    return np.mean(hits) / count


@pytest.mark.parametrize("points", [12, 40])
def test_nine_of_ten_intervals_hold_the_truth_though_windows_of_a_point_depend(points):
    """Columns that hold within a point; a sandwich of few points is narrower than 95 %."""
    assert 0.86 < covered(points, slow=True) < 0.98


def test_intervals_are_rather_too_wide_where_a_points_windows_tell_more_than_one():
    """An operating point counts once in the curvature, however its column varies."""
    assert covered(30, slow=False) > 0.95


def test_intervals_know_that_points_of_a_speed_share_the_error_of_a_law():
    """Forty points at eight speeds; a quarter is wrong if each point counts for itself."""
    speed = np.arange(40) % 8
    alone, together = (covered(40, True, alike=speed, told=told) for told in (False, True))
    print(f"each point for itself {alone:.2f}, points of a speed together {together:.2f}")
    assert alone < 0.8 and 0.85 < together < 0.98


@pytest.mark.parametrize("seed", range(4))
def test_the_sum_of_two_parameters_is_as_certain_as_one_in_their_place(seed):
    """Their columns are nearly the same: data tell their sum, and the priors the difference."""
    rng = np.random.default_rng(seed)
    raw = drawn(rng, [1.0, -0.5, 0.3], points=12)
    twin = raw.columns[..., :1] + 0.02 * rng.standard_normal((*raw.d.shape, 1))
    data = Drawn(raw.d, np.concatenate([raw.columns, twin], axis=-1)).products()
    found = []
    for chosen in ([0, 1, 2], [0, 1, 2, 3]):
        beta = maximum_likelihood(data, freedom(4, prior=3.0), chosen, everywhere(data))
        found.append(spread(data, freedom(4, prior=3.0), chosen, beta, everywhere(data)).covariance)
    one, of_sum = found[0][0, 0], found[1][np.ix_([0, 3], [0, 3])].sum()
    assert of_sum == pytest.approx(one, rel=0.3) and found[1][0, 0] > 100 * one


def test_degrees_of_freedom_are_the_points_that_tell_a_parameter():
    raw = drawn(np.random.default_rng(8), [1.0, 1.0], points=20, spread=(1.0, 1.0))
    shown = np.array([[1, 0], [0, 1]])
    data = Drawn(raw.d, raw.columns * shown[:, None]).products()
    known = (np.arange(20) < 5)[:, None] | (np.arange(2) == 0)
    few = replace(
        data,
        columns=column_products(all_products(data.columns) * known[:, :, None, None]),
        mixed=data.mixed * known[:, :, None],
        **{name: getattr(data, name) * known for name in ("squares", "noise", "windows")},
    )  # the second group is measured at five points alone
    beta = maximum_likelihood(few, freedom(2), [0, 1], np.arange(20))
    _, _, dof = spread(few, freedom(2), [0, 1], beta, np.arange(20))
    assert dof == pytest.approx([19, 4])
