"""What a reader is told of the intervals of fitted parameters."""

import re
from dataclasses import replace

import pytest

from hbench.report.campaign.terminal import summary_text
from hbench.report.fit_intervals import fit_interval_words


def with_points(results, **changes):
    curves = tuple(
        replace(curve, points=tuple(replace(point, **changes) for point in curve.points))
        for curve in results.curves
    )
    return replace(results, curves=curves)


@pytest.fixture
def known(sample_results):
    return with_points(sample_results, sigma_instruments_n=20.0, sigma_drift_n=None)


def test_the_shift_by_the_instruments_is_twice_their_largest_standard_uncertainty(known):
    words = fit_interval_words(known)
    (half,) = re.findall(r"up to ±(\d+) N \(95 %\)", words)
    assert 1.9 * 20 < float(half) <= 2 * 20
    unknown = with_points(known, sigma_instruments_n=None)
    assert "±" not in fit_interval_words(unknown)
    assert "without the errors of the instruments" in fit_interval_words(unknown)


def test_a_drift_is_named_where_it_is_in_the_intervals(known):
    assert "instruments" in fit_interval_words(known) and "or of a drift" in fit_interval_words(
        known
    )
    drifting = with_points(known, sigma_drift_n=5.0)
    assert "points and the drift, without" in fit_interval_words(drifting)
    assert "or of a drift" not in fit_interval_words(drifting)


def test_the_terminal_states_it_below_the_fits(known):
    text = " ".join(summary_text(known).split())
    words = fit_interval_words(known).replace("±", "+-")
    assert f"fits: {words}" in text
    assert text.index("Tustin fits") < text.index("fits: Intervals")
