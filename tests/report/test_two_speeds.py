"""Strokes of two speeds at each pressure: tables state which line over pressure is whose."""

from types import SimpleNamespace

import pytest

from hbench.analysis.comparison.band_differences import band_differences, trend_differences
from hbench.analysis.comparison.difference_tests import InstrumentPair
from hbench.report.campaign.page_tables import trend_table
from hbench.report.comparison.bands import slope_table
from tests.support.analysis.drawn_seal import drawn_seal, of_two_speeds
from tests.support.report.spaces import ordinary_spaces


def campaign(seed):
    slow = drawn_seal(seed, speeds=(8e-3, 8e-3))
    return of_two_speeds(slow, drawn_seal(seed + 1, level=9.0, slope=1.5, speeds=(24e-3, 24e-3)))


def test_the_lines_of_a_campaign_have_their_speeds():
    results = campaign(1)
    found = trend_table(results)
    speed, slope = map(found.head.index, ("Speed (mm/s)", "Half band, slope (N/bar)"))
    slopes = {float(row[speed].text): row[slope].text for row in found.rows}
    assert slopes.keys() == {8.0, 24.0}
    assert float(slopes[8.0].split()[0]) == pytest.approx(0.6, abs=0.1)
    assert float(slopes[24.0].split()[0]) == pytest.approx(1.5, abs=0.1)


def test_differences_of_slopes_have_the_speeds_of_their_lines():
    both, known = (campaign(1), campaign(3)), InstrumentPair(None, None, False)
    bands = band_differences(*both, known, 0.02)
    trends = trend_differences(*both, bands, known)
    found = slope_table(SimpleNamespace(band_trends=trends))
    over = [ordinary_spaces(row[found.head.index("Over")]) for row in found.rows]
    assert sorted(set(over)) == ["A, 1–7 bar, 24 mm/s", "A, 1–7 bar, 8 mm/s"]
