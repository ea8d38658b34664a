"""Maps of windows that are made up: white noise and differences between runs of known sizes."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.reconcile.gaps.log_map import (
    Windows,
    between_runs,
    expected_square,
    like_runs,
    log_map,
    ranked_gaps,
    unexplained_at,
)

RUNS, TRIALS, LENGTH = 120, 3, 30
NAMES = ("first", "second")
SIGMA = np.array([2.0, 1e-7])


def windows_of(lengths, trials=TRIALS):
    run = np.repeat(np.arange(len(lengths)), lengths)
    at = np.arange(len(run), dtype=float)
    points = tuple(f"point {i // trials}" for i in range(len(lengths)))
    return Windows(run, points, at, 2 * at, 3 * at, 4 * at)


def made(rng, noise=1.0, between=0.0, gap=0.0, lengths=(LENGTH,) * RUNS, resolution=0.0):
    """Sizes in SIGMA; ``gap`` is a mean of all windows of a point, drawn for each."""
    windows = windows_of(lengths)
    point = np.array([int(key.split()[1]) for key in windows.points])
    levels = between * rng.standard_normal((len(lengths), 2))
    gaps = gap * rng.standard_normal((int(point.max()) + 1, 2))[point]
    white = noise * rng.standard_normal((len(windows.run), 2))
    values = SIGMA * (white + (levels + gaps)[windows.run])
    return log_map(windows, NAMES, values, resolution * SIGMA), values


@pytest.mark.parametrize(("noise", "between"), [(1.0, 0.0), (1.0, 0.5), (0.3, 1.0)])
def test_scatter_is_that_of_single_windows_and_of_runs(noise, between):
    """s^2 = noise^2 + between^2 + noise^2 / n, the last from the mean of n windows."""
    of_runs = between**2 + noise**2 / LENGTH
    drawn = [made(np.random.default_rng(seed), noise, between)[0] for seed in range(12)]
    squares = np.mean([(found.scatter[0] / SIGMA) ** 2 for found in drawn], axis=0)
    own = np.mean([found.white * (found.scatter[0] / SIGMA) ** 2 for found in drawn], axis=0)
    assert squares == pytest.approx(noise**2 + of_runs, rel=0.1)
    assert own == pytest.approx(noise**2, rel=0.1)
    for found in drawn:
        assert np.array_equal(found.scatter, np.tile(found.scatter[0], (RUNS * LENGTH, 1)))
        assert found.noise == pytest.approx(found.scatter**2)


def test_the_noise_is_that_of_a_window_for_runs_of_any_length():
    """A median run's is a few per cent lower than the mean."""
    for length in (20, 60):
        white = []
        for seed in range(30):
            found, _ = made(np.random.default_rng(seed), lengths=(length,) * 60)
            white.append((found.white * found.scatter[0] ** 2 / SIGMA**2).mean())
        assert np.mean(white) == pytest.approx(1.0, abs=0.12)


@pytest.mark.parametrize("gap", [0.0, 5.0])
def test_a_correct_model_deviates_by_what_trials_differ_at_these_points(gap):
    """A tenth of the points have trials that differ five times as much, as at high flow.

    A gap that the trials of a point have in common, the model's error, does not count.
    """
    windows = windows_of((LENGTH,) * RUNS)
    fast = windows.run < RUNS // 10
    expected, actual = [], []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        _, values = made(rng, between=1.0, gap=gap)
        values += SIGMA * (5.0 * rng.standard_normal((RUNS, 2)))[windows.run] * fast[:, None]
        found = log_map(windows, NAMES, values, np.zeros(2))
        per_square = (found.scatter / SIGMA) ** 2
        expected.append(expected_square(found) * per_square)
        actual.append((found.difference / found.scatter) ** 2 * per_square)
    slow, quick = (np.mean(expected, axis=0)[chosen].mean() for chosen in (~fast, fast))
    assert slow == pytest.approx(1 + 1, rel=0.1) and quick == pytest.approx(1 + 1 + 25, rel=0.15)
    excess = np.mean(actual) - np.mean(expected)
    assert excess == pytest.approx(gap**2, rel=0.1, abs=0.3)


def test_without_trials_a_correct_model_deviates_by_the_scatter():
    windows = windows_of((LENGTH,) * RUNS, trials=1)
    values = SIGMA * np.random.default_rng(6).standard_normal((RUNS * LENGTH, 2))
    values[7, 1] = np.nan
    found = expected_square(log_map(windows, NAMES, values, np.zeros(2)))
    assert np.isnan(found[7, 1]) and np.all(found[np.isfinite(found)] == 1.0)


def test_a_gap_of_operating_points_is_no_scatter():
    rng = np.random.default_rng(1)
    plain, (found, _) = made(rng)[0], made(rng, gap=5.0)
    assert found.scatter[0] == pytest.approx(plain.scatter[0], rel=0.1)
    assert found.difference.std(axis=0) / SIGMA == pytest.approx([5.0, 5.0], rel=0.3)


def test_a_gap_in_a_few_runs_is_no_noise():
    """It changes from window to window, in a tenth of the operating points."""
    rng = np.random.default_rng(2)
    windows, values = windows_of((LENGTH,) * RUNS), None
    values = SIGMA * rng.standard_normal((RUNS * LENGTH, 2))
    strange = windows.run < RUNS // 10
    values[strange] += SIGMA * 20 * np.sin(windows.t_s[strange])[:, None]
    found = log_map(windows, NAMES, values, np.zeros(2))
    assert found.white * found.scatter[0] ** 2 == pytest.approx(SIGMA**2, rel=0.1)


def test_windows_of_neighbouring_runs_are_not_compared():
    """Runs at levels that are far apart, each at a point of its own: no noise but their own."""
    rng = np.random.default_rng(3)
    windows = windows_of((20,) * 90, trials=1)
    values = SIGMA * (rng.standard_normal((1800, 2)) + 1e3 * windows.run[:, None])
    found = log_map(windows, NAMES, values, np.zeros(2))
    assert found.scatter[0] / SIGMA == pytest.approx(np.ones(2), rel=0.1)
    assert found.white == pytest.approx(np.ones(2))  # single trials do not differ


def test_rounding_is_part_of_the_noise():
    found, _ = made(np.random.default_rng(4), noise=0.0, resolution=0.1)
    assert found.scatter[0] / SIGMA == pytest.approx([0.1, 0.1])
    assert found.white == pytest.approx([1.0, 1.0])


def test_without_any_scatter_nothing_is_compared():
    found, _ = made(np.random.default_rng(5), noise=0.0)
    assert np.isnan(found.scatter).all() and np.isnan(found.excess).all()


def test_a_balance_that_some_runs_do_not_have_is_that_of_the_others():
    rng = np.random.default_rng(6)
    windows = windows_of((LENGTH,) * RUNS)
    values = SIGMA * rng.standard_normal((RUNS * LENGTH, 2))
    values[windows.run % 2 == 0, 1] = np.nan
    found = log_map(windows, NAMES, values, np.zeros(2))
    assert found.scatter[0] / SIGMA == pytest.approx([1.0, 1.0], rel=0.1)
    values[:, 1] = np.nan
    without = log_map(windows, NAMES, values, np.zeros(2))
    assert np.isnan(without.scatter[:, 1]).all()
    assert without.scatter[0, 0] == pytest.approx(found.scatter[0, 0])


def test_windows_keep_their_runs_points_and_conditions():
    found, values = made(np.random.default_rng(7), lengths=(5, 9, 4, 7))
    assert found.points == ("point 0", "point 1")
    assert np.array_equal(found.run, np.repeat(range(4), (5, 9, 4, 7)))
    assert np.array_equal(found.point, np.repeat((0, 1), (18, 7)))
    assert found.difference is values
    assert np.array_equal(found.v_m_s, 3 * found.t_s)
    part = found.select_points(np.array([1]))
    assert np.array_equal(part.run, np.full(7, 3)) and part.difference.shape == (7, 2)


def test_variance_between_runs_is_pooled_over_operating_points():
    """By hand: means 1, 3 and 2, 2, 5 about their own centres: (2 + 6) / (1 + 2)."""
    means = np.array([1.0, 3.0, 2.0, 2.0, 5.0, 99.0])
    run = np.repeat(np.arange(6), 4)
    values = (means[run] + np.tile([-1.0, 1.0, -2.0, 2.0], 6))[:, None]
    points = np.array([0, 0, 1, 1, 1, 2])
    assert between_runs(values, run, points) == pytest.approx([8 / 3])
    assert between_runs(values[:4], run[:4], points[:1]) == pytest.approx([0.0])


def strokes(rng, trials, errors, noise=1.0, points=16):
    """Runs to and fro, each begun at its own moment; ``errors`` of (v, x, load) are in SIGMA[0]."""
    lengths = (LENGTH,) * (points * trials)
    windows = windows_of(lengths, trials)
    phase = np.repeat(rng.uniform(0, 2 * np.pi, len(lengths)), LENGTH)
    at = 2 * np.pi * np.tile(np.arange(LENGTH), len(lengths)) / 10 + phase
    load = np.repeat(np.repeat(np.linspace(1.0, 9.0, points), trials), LENGTH)
    windows = replace(windows, v_m_s=np.cos(at), x_m=np.sin(at), load_n=load)
    values = SIGMA * noise * rng.standard_normal((len(at), 2))
    values[:, 0] += SIGMA[0] * errors(windows.v_m_s, windows.x_m, load)
    return replace(log_map(windows, NAMES, values, 0 * SIGMA), material=np.zeros(2))


def p_values(residuals):
    return {gap.name: gap.p_value for gap in ranked_gaps(residuals, np.zeros(2))}


@pytest.mark.parametrize("trials", [1, 3])
@pytest.mark.parametrize(
    "errors",
    [
        pytest.param(lambda v, x, load: np.sign(v), id="turns with the direction"),
        pytest.param(lambda v, x, load: 1.5 * v * load / 9, id="share of the speed under load"),
        pytest.param(lambda v, x, load: 1.5 * x, id="along the bore"),
    ],
)
def test_errors_that_cancel_in_a_runs_mean_are_significant(trials, errors):
    found = p_values(strokes(np.random.default_rng(trials), trials, errors))
    assert found["first"] <= 0.01


@pytest.mark.parametrize("trials", [1, 3])
def test_noise_is_significant_as_often_as_its_level(trials):
    rng = np.random.default_rng(7)
    found = [p_values(strokes(rng, trials, lambda v, x, load: 0 * v)) for _ in range(150)]
    low = np.mean([min(one.values()) < 0.1 for one in found])
    assert 0.03 < low < 0.17  # of 150: 0.1 +- 0.025, after Holm at most


def test_what_differs_from_trial_to_trial_is_not_significant():
    rng = np.random.default_rng(3)
    low = []
    for _ in range(60):
        residuals, _ = made(rng, between=2.0, lengths=(LENGTH,) * 24)
        low.append(min(p_values(replace(residuals, material=np.zeros(2))).values()) < 0.1)
    assert np.mean(low) < 0.25


def test_an_error_at_one_operating_point_of_many_is_significant():
    rng = np.random.default_rng(5)
    found = p_values(strokes(rng, 2, lambda v, x, load: 4 * np.sign(v) * (load > 8.9)))
    assert found["first"] <= 0.05


def test_a_part_of_the_operating_points_has_its_own_significance():
    found = strokes(np.random.default_rng(5), 2, lambda v, x, load: 6 * np.sign(v) * (load > 5))
    high = np.flatnonzero(np.unique(found.load_n) > 5)
    assert unexplained_at(found, high)[0].name == "first"
    assert not unexplained_at(found, np.setdiff1d(np.arange(16), high))


def test_runs_of_a_point_that_move_differently_are_no_trials_of_one_another():
    """Two triangles of which one begins later, a turned one, and random steps."""
    triangle = 0.1 * np.sign(np.sin(np.arange(40) / 5))
    later, steps = np.roll(triangle, 2), np.repeat(0.1 * np.array([1, -1, 1, 1, -1, -1, -1, 1]), 5)
    rest = 1e-4 * np.ones(40)
    motions = [triangle, later, steps, rest, triangle]
    run = np.repeat(np.arange(5), 40)
    groups = like_runs(run, np.array([0, 0, 0, 0, 1]), np.concatenate(motions))
    assert groups.tolist() == [0, 0, 2, 0, 4]


def test_an_error_in_unlike_motions_is_no_scatter():
    """Each run has an error of its own; it is the scatter of runs that move alike alone."""
    rng = np.random.default_rng(5)
    windows = windows_of((LENGTH,) * 30, trials=30)
    values = SIGMA * (rng.standard_normal((30 * LENGTH, 2)) + 20 * windows.run[:, None])
    alike = log_map(replace(windows, v_m_s=0.1 + 0 * windows.v_m_s), NAMES, values, np.zeros(2))
    steps = np.sign(rng.standard_normal(30 * LENGTH))
    unlike = log_map(replace(windows, v_m_s=steps), NAMES, values, np.zeros(2))
    assert np.all(alike.scatter[0] > 100 * SIGMA)
    assert unlike.scatter[0] == pytest.approx(SIGMA, rel=0.2)


def test_an_error_that_turns_with_the_direction_is_significant_in_a_single_run_to_and_fro():
    """The run's halves have opposite directions: in each, the error has another sign."""
    rng, (p_value, noise) = np.random.default_rng(6), (np.zeros(2), np.zeros(2))
    windows = windows_of((LENGTH,) * 40, trials=1)
    way = np.where(np.arange(40 * LENGTH) % LENGTH < LENGTH // 2, 1.0, -1.0)
    windows = replace(windows, v_m_s=0.1 * way, x_m=np.cumsum(way), load_n=0 * way)
    white = SIGMA * rng.standard_normal((40 * LENGTH, 2))
    for values, found in ((white + SIGMA * way[:, None], p_value), (white, noise)):
        gaps = log_map(windows, NAMES, values, np.zeros(2))
        ranked = ranked_gaps(replace(gaps, material=np.full(2, 0.1)), np.zeros(2))
        found[:] = [gap.p_value for gap in ranked]
    assert np.all(p_value < 1e-6) and np.all(noise > 0.05)


def test_an_error_that_two_trials_at_rest_have_in_common_is_significant():
    """Trials whose positions differ by 5 um, at two operating points: an error of 30 sigma."""
    rng, windows = np.random.default_rng(9), windows_of((LENGTH,) * 4, trials=2)
    still = 1e-6 * rng.standard_normal((2, 4 * LENGTH))
    rest = replace(windows, v_m_s=still[0], x_m=0.1 + 5e-6 * windows.run + still[1])
    rest = replace(rest, load_n=5e3 + rng.standard_normal(4 * LENGTH))
    values = SIGMA * (rng.standard_normal((4 * LENGTH, 2)) + np.array([30.0, 0.0]))
    found = p_values(replace(log_map(rest, NAMES, values, 0 * SIGMA), material=np.zeros(2)))
    assert found["first"] < 0.01 and found["second"] > 0.05
