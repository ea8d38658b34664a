"""Products of columns in blocks: as if all columns were stored for all groups."""

import numpy as np
import pytest

from tests.support.reconcile.products import all_products, column_products

POINTS, GROUPS, COLUMNS = 5, 6, 4
CHANGES = np.array(  # which columns change which groups; the last group has none
    [[1, 1, 0, 0], [1, 1, 0, 0], [0, 1, 1, 1], [0, 1, 1, 1], [1, 0, 0, 1], [0, 0, 0, 0]], bool
)


@pytest.fixture
def dense():
    """Products (p, g, q, q) of columns over three windows of each point and group."""
    columns = np.random.default_rng(1).standard_normal((POINTS, GROUPS, 3, COLUMNS))
    columns *= CHANGES[:, None]
    return np.einsum("pgwj,pgwk->pgjk", columns, columns)


@pytest.fixture
def beta():
    return np.random.default_rng(2).standard_normal((2, 7, COLUMNS))


def test_blocks_have_no_columns_that_are_zero_and_all_products(dense):
    found = column_products(dense)
    assert sorted(len(block.columns) for block in found.blocks) == [2, 2, 3]
    np.testing.assert_array_equal(all_products(found), dense)
    np.testing.assert_array_equal(found.nonzero, CHANGES)


@pytest.mark.parametrize(
    ("groups", "columns"),
    [(range(GROUPS), range(COLUMNS)), ([4, 0, 3], [3, 1]), ([5], [0, 2]), ([2, 3], [])],
)
def test_sums_over_points_are_those_of_all_products(dense, beta, groups, columns):
    groups, columns = np.array(groups), np.array(columns, int)
    parts = np.array([[1, 0, 1, 1, 0], [0, 1, 0, 0, 0]], bool)
    sums = column_products(dense).summed(parts).select(groups, columns)
    whole = np.array([dense[part].sum(axis=0)[np.ix_(groups, columns, columns)] for part in parts])
    own, weight = beta[..., columns], np.random.default_rng(3).random((2, 7, len(groups)))
    close = {"rtol": 1e-12, "atol": 1e-12}
    np.testing.assert_allclose(sums.diagonal(), np.einsum("fgjj->fgj", whole), **close)
    expected = np.einsum("fbg,fgij->fbij", weight, whole)
    np.testing.assert_allclose(sums.weighted(weight), expected, **close)
    expected = np.einsum("fgij,bj->fbgi", whole, own[0])
    np.testing.assert_allclose(sums.times(own[0]), expected, **close)
    curved = np.einsum("fbi,fgij,fbj->fbg", own, whole, own)
    np.testing.assert_allclose(sums.squares(own), curved, **close)


def test_some_columns_times_their_factors(dense, beta):
    chosen = np.array([3, 1])
    found = column_products(dense).select(chosen).times(beta[0, 0, chosen])
    expected = dense[..., chosen, :][..., chosen] @ beta[0, 0, chosen]
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def test_points_of_another_campaign_follow_with_columns_that_only_one_of_them_has(dense):
    factors = np.random.default_rng(4).random((POINTS, GROUPS))
    factors[:, 3] = 0.0  # a group without the other's runs
    more = np.where(np.arange(COLUMNS) != 1, dense, 0.0)  # as if a column was not computed
    more = np.where((np.arange(COLUMNS) != 1)[:, None], more, 0.0)
    joint = column_products(dense).followed_by(column_products(more).scaled(factors))
    assert joint.shape == (2 * POINTS, GROUPS, COLUMNS)
    expected = np.concatenate([dense, more * factors[..., None, None]])
    np.testing.assert_array_equal(all_products(joint), expected)
    np.testing.assert_array_equal(joint.nonzero, CHANGES)
