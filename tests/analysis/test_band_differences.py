"""Friction bands of two campaigns compared: against scipy, by hand, and which of them match."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from hbench.analysis.comparison.band_differences import band_differences, trend_differences
from hbench.analysis.comparison.difference_tests import InstrumentPair
from hbench.analysis.comparison.differences import campaign_differences
from hbench.analysis.comparison.matching import SetPoint, nearest_set_point, speed_tolerance
from hbench.analysis.statistics.holm import holm
from hbench.analysis.statistics.student import degrees_of_freedom
from hbench.config.sensors import Instruments
from tests.support.analysis.drawn_seal import LARGE, drawn_seal

STROKES = 0.20  # tolerance of their speeds
UNKNOWN = InstrumentPair(None, None, False)


def compared(a, b, known=(None, None), same=False, tolerance=STROKES):
    return band_differences(a, b, InstrumentPair(*known, same), tolerance)


def test_half_bands_middles_and_energies_are_compared_as_scipys_welch_test_does():
    a, b = drawn_seal(1), drawn_seal(2, "B", level=4.3)
    found = compared(a, b)
    assert [round(each.a.p_tp_pa / 1e5) for each in found] == [1, 3, 5, 7]
    for name in ("half_n", "middle_n", "energy_j"):
        p_values = []
        for each, ours, theirs in zip(found, a.bands, b.bands, strict=True):
            trials = [getattr(band, f"trials_{name}") for band in (theirs, ours)]
            peer = stats.ttest_ind(*trials, equal_var=False)
            interval, d = peer.confidence_interval(), getattr(each, name)
            assert (d.value - d.ci95, d.value + d.ci95) == pytest.approx(tuple(interval))
            assert d.p_value == pytest.approx(peer.pvalue)
            p_values.append(peer.pvalue)
        assert [getattr(each, name).p_holm for each in found] == pytest.approx(holm(p_values))


def test_slopes_are_compared_with_welchs_degrees_of_freedom():
    a, b = drawn_seal(1), drawn_seal(2, "B", slope=1.4)
    (found,) = trend_differences(a, b, compared(a, b), UNKNOWN)
    lines = [trend.half for trend in (*a.band_trends, *b.band_trends)]
    squares = [line.slope_se_n_pa**2 for line in lines]
    se = np.sqrt(sum(squares))
    dof = se**4 / sum(s**2 / line.slope_dof for s, line in zip(squares, lines, strict=True))
    d = found.half_slope_n_pa
    assert d.value == pytest.approx(lines[1].slope_n_pa - lines[0].slope_n_pa)
    assert d.ci95 == pytest.approx(stats.t.ppf(0.975, dof) * se)
    assert d.real and d.value * 1e5 == pytest.approx(0.8, abs=0.2)
    assert not found.middle_slope_n_pa.real


@pytest.mark.parametrize("count", [80, pytest.param(300, marks=pytest.mark.slow)])
def test_the_slopes_interval_contains_the_truth_in_95_percent_and_rarely_cries_wolf(count):
    held = []
    for seed in range(count):
        a, b = drawn_seal(2 * seed), drawn_seal(2 * seed + 1, "B")
        (found,) = trend_differences(a, b, compared(a, b), UNKNOWN)
        held.append(abs(found.half_slope_n_pa.value) <= found.half_slope_n_pa.ci95)
    assert np.mean(held) > 0.93


def test_a_slope_needs_three_pressures_of_both():
    a, b = drawn_seal(1), drawn_seal(2, "B", bars=(3.0, 5.0, 6.0))
    bands = compared(a, b)
    assert [round(each.a.p_tp_pa / 1e5) for each in bands] == [3, 5]
    assert trend_differences(a, b, bands, UNKNOWN) == ()


def test_another_bore_is_compared_at_the_same_pressure():
    a, b = drawn_seal(1), drawn_seal(2, "B", specimen=LARGE, pressure=1.03)
    assert len(compared(a, b)) == 4
    curves, notes = campaign_differences(a, b, UNKNOWN, STROKES)
    assert len(curves) == 8 and notes == ()
    assert compared(a, drawn_seal(2, "B", specimen=LARGE, pressure=1.06)) == ()


def test_speeds_that_nobody_set_count_as_the_same_within_a_fifth():
    a = drawn_seal(1)
    near, far = (
        drawn_seal(2, "B", speeds=(8.5e-3, 6.9e-3)),
        drawn_seal(2, "B", speeds=(8.3e-3, 7.3e-3)),
    )
    assert speed_tolerance(a, near) == 0.20
    curves, notes = campaign_differences(a, near, UNKNOWN, speed_tolerance(a, near))
    assert len(curves) == 8 and notes == ()
    assert len(compared(a, near)) == 4
    assert compared(a, far) == ()
    curves, notes = campaign_differences(a, far, UNKNOWN, STROKES)
    assert len(curves) == len(notes) == 4 and all("retract" in note for note in notes)


def test_set_speeds_must_agree_within_two_percent():
    set_ = {"speed_is_measured": False}
    a, b = drawn_seal(1, **set_), drawn_seal(2, "B", speeds=(8.5e-3, 6e-3), **set_)
    assert speed_tolerance(a, b) == 0.02
    curves, notes = campaign_differences(a, b, UNKNOWN, speed_tolerance(a, b))
    assert {curve.direction for curve in curves} == {"retract"} and len(notes) == 4


def test_single_labels_may_differ_and_several_must_agree():
    a, b = drawn_seal(1, "A"), drawn_seal(2, "B")
    several = replace(a, curves=(*a.curves, *b.curves), bands=(*a.bands, *b.bands), band_trends=())
    assert len(compared(a, b)) == 4
    found = compared(several, b)
    assert [each.a.label for each in found] == ["B"] * 4
    assert all(each.half_n.value == 0.0 for each in found)


def test_equal_loads_come_before_nearer_pressures():
    others = {"load": SetPoint(50.0, 1.04e5), "near": SetPoint(51.0, 1.01e5)}
    assert nearest_set_point(SetPoint(50.0, 1e5), others) == "load"
    assert nearest_set_point(SetPoint(49.0, 1e5), others) == "near"
    assert nearest_set_point(SetPoint(49.0, 2e5), others) is None
    drive = {"drive": SetPoint(50.0, None), "other": SetPoint(60.0, None)}  # without hydraulics
    assert nearest_set_point(SetPoint(50.0, None), drive) == "drive"
    assert nearest_set_point(SetPoint(70.0, None), drive) is None


def instruments(of):
    tolerance = {"tolerance": "1 %", "of": of}
    return Instruments.model_validate(
        {
            "force": {**tolerance, "full_scale": "500 N"},
            "pressure": {**tolerance, "full_scale": "10 bar"},
        }
    )


def expanded(difference, limit):
    """Expanded uncertainty (JCGM 100, G.2b) of the trials' difference and a rectangular error."""
    sigma = limit / np.sqrt(3)
    combined = np.hypot(difference.se, sigma)
    dof = combined**4 / difference.se**4 * degrees_of_freedom(difference.ci95 / difference.se)
    return stats.t.ppf(0.975, dof) * combined


def test_a_constant_error_of_the_sensors_is_in_the_middle_and_not_in_the_half_band():
    """1 % of 500 N and, on both sides, of 10 bar on 4.909 cm^2: 5 N and twice 4.909 N."""
    known = instruments("full_scale")
    (first, *_) = compared(drawn_seal(1), drawn_seal(2, "B"), (known, known), same=False)
    limit = np.sqrt(2 * (5.0**2 + 2 * 4.909**2))
    assert first.middle_n.u95 == pytest.approx(expanded(first.middle_n, limit), rel=1e-4)
    assert first.half_n.u95 == pytest.approx(first.half_n.ci95)
    assert first.energy_j.u95 == pytest.approx(first.energy_j.ci95)


def test_a_gain_error_of_the_load_cell_changes_half_band_and_energy_alike():
    known = instruments("reading")
    (first, *_) = compared(drawn_seal(1), drawn_seal(2, "B", level=6.0), (known, known), same=False)
    halves = np.hypot(*(0.01 * each.half_n for each in (first.a, first.b)))
    assert first.half_n.u95 == pytest.approx(expanded(first.half_n, halves), rel=1e-4)
    energies = np.hypot(*(0.01 * each.energy_j for each in (first.a, first.b)))
    assert first.energy_j.u95 == pytest.approx(expanded(first.energy_j, energies), rel=1e-4)
    a, b = drawn_seal(1), drawn_seal(2, "B", slope=1.4)
    (slope,) = trend_differences(a, b, compared(a, b), InstrumentPair(known, known, False))
    gains = np.hypot(*(0.01 * t.half.slope_n_pa for t in (*a.band_trends, *b.band_trends)))
    assert slope.half_slope_n_pa.u95 == pytest.approx(
        expanded(slope.half_slope_n_pa, gains), rel=1e-4
    )


def test_one_trial_gives_differences_without_an_interval():
    found = compared(drawn_seal(1, trials=1), drawn_seal(2, "B", trials=1))
    assert all(each.half_n.ci95 is None and each.half_n.untested for each in found)
