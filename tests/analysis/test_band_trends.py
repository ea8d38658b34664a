"""Lines of friction bands over pressure, against scipy, hand numbers and simulated coverage."""

import numpy as np
import pytest
from scipy import stats

from hbench.analysis.curves.band_trends import band_trends
from hbench.analysis.statistics.line_of_trials import line_of_trials
from hbench.records import Band, CurvePoint, Specimen

BAR = 1e5
PRESSURES = np.array([1.0, 3.0, 5.0, 7.0]) * BAR
SMALL, LARGE = Specimen(4.9e-4, 4.9e-4), Specimen(5.2e-4, 5.2e-4)


def made_band(p_pa, halves, middles, label="", specimen=SMALL, load=None, v_m_s=0.01):
    point = CurvePoint(v_m_s, 0.0, None, len(halves), 0.0, 0.0, p_pa, None, (), (), (), ())
    trials = tuple(range(1, len(halves) + 1))
    half, middle = float(np.mean(halves)), float(np.mean(middles))
    return Band(
        "steady", label, specimen, p_pa * 5e-4 if load is None else load, None, v_m_s, p_pa,
        half, None, middle, None, None, None, len(trials), trials, tuple(halves), tuple(middles),
        (), point, point,
    )  # fmt: skip


def alone(values):
    """One trial at each pressure."""
    return [{1: value} for value in values]


def test_a_line_without_repeated_trials_is_scipys_regression():
    halves = np.array([3.950, 5.504, 7.162, 7.940])
    line = line_of_trials(PRESSURES, halves, alone(halves))
    peer = stats.linregress(PRESSURES, halves)
    t = stats.t.ppf(0.975, 2)
    assert line.slope == pytest.approx(peer.slope)
    assert line.slope_se == pytest.approx(peer.stderr) and line.slope_dof == 2
    assert line.slope_ci95 == pytest.approx(t * peer.stderr)
    assert line.intercept == pytest.approx(peer.intercept)
    assert line.intercept_ci95 == pytest.approx(t * peer.intercept_stderr)


def test_a_pressure_without_the_slow_strokes_is_not_on_their_line():
    """2 N/bar and 3 N + 2 N/bar; speeds that nobody set rise a little with the pressure."""
    slow = [made_band(p, [2 * p / BAR] * 2, [0.0] * 2, v_m_s=0.01 + p / 1e9) for p in PRESSURES]
    fast = [made_band(p, [3 + 2 * p / BAR] * 2, [0.0] * 2, v_m_s=0.03 + p / 1e9) for p in PRESSURES]
    trends = band_trends([*slow[:1], *slow[2:], *fast])
    assert [len(trend.bands) for trend in trends] == [3, 4]
    for trend, level_n in zip(trends, (0.0, 3.0), strict=True):
        assert trend.half.slope_n_pa * BAR == pytest.approx(2.0)
        assert trend.half.intercept_n == pytest.approx(level_n, abs=1e-9)


def test_trials_that_turn_the_line_give_the_interval_of_their_slopes():
    """Slopes 1, 2, 3 N/bar: mean 2, S = 1, so 4.303 / sqrt(3) = 2.484 N/bar; no residual."""
    trials = [{k: k * p / BAR for k in (1, 2, 3)} for p in PRESSURES]
    line = line_of_trials(PRESSURES, [2 * p / BAR for p in PRESSURES], trials)
    assert line.slope * BAR == pytest.approx(2.0)
    assert line.slope_ci95 * BAR == pytest.approx(2.484, abs=1e-3)
    assert line.slope_dof == pytest.approx(2)
    assert line.intercept_ci95 == pytest.approx(0.0, abs=1e-9)


def test_both_sources_add_as_squares_and_the_degrees_of_freedom_fit_the_interval():
    noise, means = {1: -1.0, 2: 0.0, 3: 1.0}, np.array([3.950, 5.504, 7.162, 7.940])
    trials = [
        {k: y + e * p / BAR for k, e in noise.items()}
        for y, p in zip(means, PRESSURES, strict=True)
    ]
    residuals = line_of_trials(PRESSURES, means, alone(means))
    line = line_of_trials(PRESSURES, means, trials)
    of_trials = 1 / np.sqrt(3) / BAR  # S = 1 N/bar
    t = stats.t.ppf(0.975, 2)
    assert line.slope_se == pytest.approx(np.hypot(residuals.slope_se, of_trials))
    assert line.slope_ci95 == pytest.approx(t * line.slope_se)
    assert line.slope_dof == pytest.approx(2)
    more = [values | {4: values[2], 5: values[2]} for values in trials]  # S^2 = 1/2
    line, of_trials = line_of_trials(PRESSURES, means, more), np.sqrt(0.5 / 5) / BAR
    ci95 = np.hypot(residuals.slope_ci95, stats.t.ppf(0.975, 4) * of_trials)
    assert line.slope_ci95 == pytest.approx(ci95)
    assert stats.t.ppf(0.975, line.slope_dof) * line.slope_se == pytest.approx(ci95)


def test_only_trials_that_all_pressures_have_form_lines():
    trials = [{k: k * p / BAR for k in (1, 2, 3)} for p in PRESSURES]
    trials[1] |= {4: 900.0}
    trials[2].pop(3)
    line = line_of_trials(PRESSURES, [1.5 * p / BAR for p in PRESSURES], trials)
    assert line.slope_ci95 * BAR == pytest.approx(12.706 * np.sqrt(0.5) / np.sqrt(2), rel=1e-4)


@pytest.mark.parametrize("pressures", [2, 3])
def test_a_series_needs_three_pressures(pressures):
    bands = [made_band(p, [1.0], [0.0]) for p in PRESSURES[:pressures]]
    assert len(band_trends(bands)) == (1 if pressures == 3 else 0)


def test_labels_cylinders_and_speeds_are_series_of_their_own_in_the_order_of_the_bands():
    def series(slope, **what):
        return [made_band(p, [slope * p], [0.0], **what) for p in PRESSURES]

    every = [
        *series(4e-5, label="B", v_m_s=0.1),
        *series(3e-5, label="B", v_m_s=0.02),
        *series(2e-5, label="A", specimen=LARGE),
        *series(1e-5, label="A"),
    ]
    found = band_trends(every)
    slopes = [(trend.label, round(trend.half.slope_n_pa * BAR, 6)) for trend in found]
    assert slopes == [("B", 4.0), ("B", 3.0), ("A", 2.0), ("A", 1.0)]
    assert all(trend.pressures_pa == tuple(PRESSURES) for trend in found)


def drawn(rng, pressures, trials, set_up, mounting, single):
    """Half bands (m, n) about a line of 1 N/bar, with three sources of scatter [N].

    ``set_up`` is common to the trials of a pressure, ``mounting`` shifts and turns the line of a
    trial, ``single`` is independent in each value.
    """
    m, n, away = len(pressures), trials, (pressures - pressures.mean()) / (4 * BAR)
    level = rng.normal(0, set_up, (m, 1)) + rng.normal(0, mounting, (1, n))
    turn = away[:, None] * rng.normal(0, mounting, (1, n))
    return 1e-5 * pressures[:, None] + level + turn + rng.normal(0, single, (m, n))


def coverage(pressures, trials, scatter, draws):
    """Share of the slope's intervals that contain 1 N/bar: of hbench, of either source alone."""
    rng = np.random.default_rng(3)
    inside = np.zeros(3)
    for _ in range(draws):
        y = drawn(rng, pressures, trials, *scatter)
        line = line_of_trials(pressures, y.mean(axis=1), [dict(enumerate(row)) for row in y])
        residuals = line_of_trials(pressures, y.mean(axis=1), alone(y.mean(axis=1)))
        slopes = np.polyfit(pressures, y, 1)[0]
        of_trials = stats.t.ppf(0.975, trials - 1) * slopes.std(ddof=1) / np.sqrt(trials)
        halves = (line.slope_ci95, residuals.slope_ci95, of_trials)
        inside += abs(line.slope - 1e-5) <= np.array(halves)
    return inside / draws


@pytest.mark.parametrize("scatter", [(0.3, 0.0, 0.03), (0.0, 0.5, 0.05)])
def test_the_slopes_interval_contains_the_truth_whether_pressures_or_trials_scatter(scatter):
    ours, residuals, of_trials = coverage(PRESSURES, 3, scatter, draws=800)
    assert abs(ours - 0.95) < 0.03
    assert min(residuals, of_trials) < 0.35  # either alone fails in one of the two


@pytest.mark.slow
@pytest.mark.parametrize("pressures", [3, 4, 12])
@pytest.mark.parametrize("trials", [3, 20])
@pytest.mark.parametrize(
    "scatter",
    [(0.3, 0.0, 0.03), (0.0, 0.5, 0.05), (0.0, 0.0, 0.3), (0.3, 0.3, 0.1), (0.3, 0.6, 0.1)],
)
def test_coverage_of_the_slope_at_all_mixtures_of_scatter(pressures, trials, scatter):
    ours, residuals, of_trials = coverage(
        np.linspace(1, 7, pressures) * BAR, trials, scatter, draws=4000
    )
    print(f"{pressures} {trials} {scatter}: {ours:.3f}; {residuals:.3f} {of_trials:.3f}")
    assert 0.94 < ours <= 0.999
