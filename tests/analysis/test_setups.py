"""Set-ups of trials, and the sets of points that they link."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from hbench.analysis.summary.setups import sizes_and_sets


@pytest.mark.parametrize("points", [1, 5, 40])
def test_sets_of_linked_points_are_the_connected_components_of_their_graph(points):
    rng = np.random.default_rng(points)
    for trials in (1, points, 3 * points):
        setup, point = rng.integers(points, size=trials), rng.integers(points, size=trials)
        used = np.unique(np.concatenate([setup, points + point]))
        graph = coo_array((np.ones(trials), (setup, points + point)), (2 * points, 2 * points))
        expected, _ = connected_components(graph.tocsr()[used][:, used], directed=False)
        sizes, sets = sizes_and_sets(setup, point)
        assert sets == expected
        assert sizes.tolist() == np.bincount(setup)[np.bincount(setup) > 0].tolist()


def test_points_are_one_set_if_each_shares_a_setup_with_the_next():
    trial = np.arange(60)
    point = np.random.default_rng(0).permutation(30)[trial // 2]
    assert sizes_and_sets(trial // 2, point)[1] == 30  # each set-up has one point
    assert sizes_and_sets((trial + 1) // 2, point)[1] == 1
