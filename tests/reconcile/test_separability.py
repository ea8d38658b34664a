"""Smallest detectable sizes and angles, against closed forms and plain minimisation."""

from math import cos, degrees, exp, radians, sin, sqrt
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import subspace_angles
from scipy.optimize import minimize

from hbench.reconcile.acceptance import CRITERIA
from hbench.reconcile.evidence.likelihood import Priors
from hbench.reconcile.evidence.products import Products
from hbench.reconcile.linearised import LinearisedModel
from hbench.reconcile.separation.separability import (
    Separation,
    principal_angle_deg,
    with_remaining_noise,
)
from tests.support.reconcile.products import column_products

POINTS, WINDOWS = 12, 5  # windows of each point
NUISANCE, DROOP, GAIN = "/oil.bulk_modulus", "supply_droop.slope", "load_cell_gain.error"
LEAKS = ("internal_leakage.test", "internal_leakage.load")


def separation(columns, noise=0.5, sigma=1.0, tolerance=()):
    """Return the separation of columns (w, g, q) that are the same at each point, by name."""
    names, values = tuple(columns), np.stack(list(columns.values()), axis=-1)
    products = np.einsum("wgj,wgk->gjk", values, values)
    groups = values.shape[1]
    data = Products(
        names=names,
        columns=column_products(np.tile(products, (POINTS, 1, 1, 1))),
        mixed=np.zeros((POINTS, groups, len(names))),
        squares=np.zeros((POINTS, groups)),
        noise=np.full((POINTS, groups), noise * WINDOWS),
        windows=np.full((POINTS, groups), WINDOWS),
        groups=tuple((f"balance {i}", "steady") for i in range(groups)),
    )
    tight, wide = [], []
    for name in names:
        free = name.startswith("/")
        wide.append((0.0, sigma, -3.0, 3.0) if free else (0.0, 10.0, -50.0, 50.0))
        limit = dict(tolerance).get(name, 0.0)
        kept = (0.0, limit / sqrt(3), -limit, limit) if limit else (0.0, np.nan, 0.0, 0.0)
        tight.append(wide[-1] if free else kept)
    priors = (Priors(*np.array(rows).T) for rows in (tight, wide))
    model = LinearisedModel(None, None, {}, data, *priors)
    return Separation(model, np.arange(POINTS))


def in_windows(*values, groups=1):
    """Return a column whose windows of the first groups have these values, each in turn."""
    column = np.zeros((WINDOWS, groups))
    column[: len(values), 0] = values
    return column


# ---- angles


@pytest.mark.parametrize("angle", [0.0, 12.0, 90.0])
def test_the_angle_of_two_columns_is_that_of_the_plane(angle):
    columns = {
        DROOP: in_windows(2.0, 0.0),
        GAIN: in_windows(5 * cos(radians(angle)), 5 * sin(radians(angle))),
    }
    found = separation(columns).angle_deg("supply_droop", "load_cell_gain")
    assert found == pytest.approx(angle, abs=1e-5)


@pytest.mark.parametrize("sigma", [1e-6, 0.3, 1.0, 1e3])
def test_a_nuisance_takes_its_direction_out_of_both_as_far_as_its_prior_lets_it(sigma):
    """A = (1, 0, 1), B = (0, 1, 1), nuisance (0, 0, 1): with k = 1 / (1 + v / (n sigma^2)),

    the products are A'A = B'B = 2 - k and A'B = 1 - k: 60 degrees for a known nuisance, 90 for a
    free one.
    """
    columns = {
        NUISANCE: in_windows(0.0, 0.0, 1.0),
        DROOP: in_windows(1.0, 0.0, 1.0),
        GAIN: in_windows(0.0, 1.0, 1.0),
    }
    noise = 0.5
    weight = POINTS / (WINDOWS * noise)  # of one point's products, over all points
    k = 1 / (1 + 1 / (weight * sigma**2))
    found = separation(columns, noise, sigma).angle_deg("supply_droop", "load_cell_gain")
    assert found == pytest.approx(degrees(np.arccos((1 - k) / (2 - k))), rel=1e-6)


def test_the_angle_of_spaces_is_the_smallest_principal_angle():
    """As scipy computes it, for an effect with two coefficients; lengths do not matter."""
    rng = np.random.default_rng(3)
    one, other = rng.standard_normal((WINDOWS, 2)), rng.standard_normal((WINDOWS, 1))
    columns = {LEAKS[0]: one[:, :1] * 30, LEAKS[1]: one[:, 1:], DROOP: other / 7}
    found = separation(columns).angle_deg("internal_leakage", "supply_droop")
    assert found == pytest.approx(degrees(subspace_angles(one, other).min()))


def test_groups_count_by_their_noise():
    """Equal in a group with large noise, at right angles in one with little: nearly 90 degrees."""
    one, other = np.zeros((2, WINDOWS, 2))
    one[0], other[0, 0], other[1, 1] = 1.0, 1.0, 1.0
    made = separation({DROOP: one, GAIN: other})
    assert made.angle_deg("supply_droop", "load_cell_gain") == pytest.approx(60.0)
    data = made.model.data
    data.noise[:, 0] *= 1e4
    made = Separation(made.model, made.points)
    assert made.angle_deg("supply_droop", "load_cell_gain") > 89


def test_an_effect_that_a_nuisance_covers_has_no_angle():
    column = in_windows(1.0, 2.0)
    columns = {NUISANCE: column, DROOP: column, GAIN: in_windows(1.0)}
    made = separation(columns, sigma=1e9)
    assert np.isnan(made.angle_deg("supply_droop", "load_cell_gain"))
    assert np.isnan(principal_angle_deg(np.zeros((2, 2)), np.zeros(2), 1))


# ---- sizes


def test_the_smallest_size_is_where_the_gain_in_likelihood_is_the_threshold():
    """Without nuisances n / 2 ln(b^2 c'c / (m v)) = 5."""
    made = separation({DROOP: in_windows(3.0, 4.0)}, noise=0.5)
    expected = sqrt(WINDOWS * 0.5 / 25) * exp(CRITERIA.score / POINTS)
    found = made.smallest_sizes([("supply_droop", "slope")])
    assert found == pytest.approx([expected], rel=0.015)


def test_the_smallest_size_grows_by_what_a_nuisance_absorbs_within_its_bounds():
    """As a plain minimisation over the nuisance shows, with its prior and its bounds of 3."""
    effect, nuisance, v, sigma = np.array([2.0, 1.0, 0.0]), np.array([1.0, 1.0, 1.0]), 0.4, 0.7
    columns = {NUISANCE: in_windows(*nuisance), DROOP: in_windows(*effect)}
    (found,) = separation(columns, v, sigma).smallest_sizes([("supply_droop", "slope")])

    def gain(size):
        def loss(beta):
            left = size * effect - beta[0] * nuisance
            return POINTS / 2 * np.log(max(left @ left / (WINDOWS * v), 1)) + (
                beta[0] ** 2 / sigma**2 / 2
            )

        starts = np.linspace(-3, 3, 7)
        return min(minimize(loss, [x], method="Nelder-Mead", bounds=[(-3, 3)]).fun for x in starts)

    assert gain(found * 0.97) < CRITERIA.score < gain(found * 1.01)


def test_what_the_runs_do_not_show_has_no_smallest_size():
    made = separation({DROOP: in_windows(1e-6), GAIN: in_windows(0.0, 1.0)})
    found = made.separability(("supply_droop", "load_cell_gain"))
    assert np.isnan(found.sizes[0].smallest) and not found.sizes[0].detectable
    assert np.isfinite(found.sizes[1].smallest)


def test_an_effect_below_the_least_size_is_not_named_however_clear_it_is():
    """2 % is the typical error of a load cell's gain."""
    (size,) = separation({GAIN: in_windows(1e3)}).separability(("load_cell_gain",)).sizes
    assert size.limit == "size" and size.unit == "%"
    assert size.smallest == pytest.approx(2.0 * 0.25) and size.detectable


def test_an_error_of_a_sensor_is_detectable_only_beyond_its_tolerance():
    """A tolerance of 4 %, two typical sizes."""
    made = separation({GAIN: in_windows(1e3)}, tolerance=[(GAIN, 2.0)])
    (size,) = made.separability(("load_cell_gain",)).sizes
    assert size.limit == "evidence" and not size.detectable
    assert 4.0 < size.smallest < 4.1


# ---- pairs


def test_pairs_are_distinguishable_where_the_rival_leaves_enough():
    """The rival leaves sin(angle) of the cause, whose variance over that of the noise is the lead.

    For a cause far above the noise a tenth of its score is the margin.
    """
    for angle, distinguishable in ((1.0, False), (30.0, True)):
        columns = {
            DROOP: in_windows(50.0),
            GAIN: in_windows(50 * cos(radians(angle)), 50 * sin(radians(angle))),
        }
        made = separation(columns)
        (pair,) = made.separability(("supply_droop", "load_cell_gain")).pairs
        left = 50 * sin(radians(angle))
        expected = POINTS / 2 * np.log(max(left**2 / (WINDOWS * 0.5), 1.0))
        assert pair.lead == pytest.approx(expected, abs=0.1)
        assert pair.distinguishable is distinguishable
        assert pair.angle_deg == pytest.approx(angle)


def test_a_rival_that_would_need_the_wrong_sign_is_no_rival():
    """Leaks are positive: what lowers the flow of a cause is no leak, though the angle is 0."""
    column = in_windows(40.0)
    made = separation({LEAKS[0]: column, DROOP: -column})
    made.model.wide.low[:] = 0.0
    (pair,) = made.separability(("internal_leakage", "supply_droop")).pairs
    assert pair.angle_deg == pytest.approx(0.0, abs=1e-5)
    assert pair.distinguishable


def test_what_another_model_does_not_explain_is_noise():
    made = separation({DROOP: in_windows(1.0)}, noise=0.5)
    data = made.model.data
    squares = np.full_like(data.squares, 2.0 * WINDOWS)
    explained = SimpleNamespace(data=SimpleNamespace(squares=squares))
    noisier = with_remaining_noise(made.model, explained, made.points)
    assert noisier.data.noise == pytest.approx(np.full_like(data.noise, 2.0 * WINDOWS))
    explained.data.squares = 0.1 * squares
    assert with_remaining_noise(made.model, explained, made.points).data.noise == pytest.approx(
        data.noise
    )
