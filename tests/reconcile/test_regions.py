"""Regions of a map whose gaps are put where the test says."""

import numpy as np
import pytest

from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.gaps.regions import regions


def made_up(lacking):
    """A map of 4000 windows; ``lacking`` gives d / s of the first balance at (v, load, x, t)."""
    rng = np.random.default_rng(0)
    v = rng.uniform(-0.2, 0.2, 4000)
    load, x, t = rng.choice([500.0, 2000.0, 5000.0], 4000), *rng.uniform(0, 1, (2, 4000))
    noise = np.full((4000, 2), 0.1)
    difference = np.sqrt(noise) * rng.standard_normal((4000, 2))
    difference[:, 0] += lacking(v, load, x, t)
    at = np.zeros(4000, dtype=int)
    size = np.ones((4000, 2))
    return GapMap(("own", "other"), difference, size, noise, t, x, v, load, at, ("only",), at)


def of(axis, found):
    return [region for region in regions(found) if region.axis == axis]


def test_a_lack_while_extending_stands_in_that_region_alone():
    found = made_up(lambda v, load, x, t: 3.0 * (v > 0))
    by_label = {region.label: region.gaps for region in of("direction", found)}
    assert set(by_label) == {"retract", "rest", "extend"}
    assert by_label["extend"]["own"] == pytest.approx(np.sqrt(10), rel=0.02)
    assert by_label["retract"]["own"] == pytest.approx(1, abs=0.03)
    assert by_label["extend"]["other"] == pytest.approx(1, abs=0.03)


def test_few_values_are_regions_of_their_own():
    found = made_up(lambda v, load, x, t: load / 1000)
    loads = of("load_n", found)
    assert [(region.low, region.high) for region in loads] == [(f, f) for f in (500, 2000, 5000)]
    expected = [np.sqrt(1 + (region.low / 1000) ** 2) for region in loads]
    assert [region.gaps["own"] for region in loads] == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("axis, place", [("position_m", 2), ("time_s", 3)])
def test_quarters_of_the_windows_follow_one_another(axis, place):
    found = made_up(lambda *at: 2.0 * (at[place] > 0.75))
    parts = of(axis, found)
    assert len(parts) == 4
    assert [part.windows for part in parts] == pytest.approx([1000] * 4, abs=2)
    assert all(one.high < other.low for one, other in zip(parts[:-1], parts[1:], strict=True))
    assert [part.gaps["own"] > 1.5 for part in parts] == [False, False, False, True]


def test_nothing_compared_is_no_number_and_unknown_loads_have_no_region():
    found = made_up(lambda *at: 0.0)
    found.difference[found.v_m_s > 0, 1] = np.nan
    found.load_n[:] = np.nan
    by_label = {region.label: region.gaps for region in of("direction", found)}
    assert np.isnan(by_label["extend"]["other"])
    assert by_label["retract"]["other"] == pytest.approx(1, abs=0.03)
    assert not of("load_n", found)
