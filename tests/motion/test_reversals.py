import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hbench.motion.reversals import cut_at_reversals, settled_strokes, stroke_speed

MIN_STROKE = 0.02


def zigzag(corners, speed, rate=100.0, dwell_s=0.0):
    """Return t, x through ``corners`` at constant speed, resting at each inner corner."""
    times, places = [0.0], [corners[0]]
    for corner in corners[1:]:
        times.append(times[-1] + abs(corner - places[-1]) / speed)
        places.append(corner)
        times.append(times[-1] + max(dwell_s, 1e-9))
        places.append(corner)
    t = np.arange(0.0, times[-2], 1 / rate)
    return t, np.interp(t, times, places)


CORNERS = [0.0, 0.04, 0.001, 0.041, 0.0, 0.03, 0.01]


@given(st.integers(0, 1000), st.sampled_from([0.0, 0.05, 1.0]))
def test_strokes_are_found_in_spite_of_noise_gaps_and_dwell(seed, dwell_s):
    rng = np.random.default_rng(seed)
    t, x = zigzag(CORNERS, 0.012, dwell_s=dwell_s)
    x = x + rng.normal(0.0, 1e-5, len(x))
    kept = rng.random(len(t)) > 0.1  # irregular
    start = rng.integers(0, len(t) - 28)
    kept[start : start + 28] = False  # a gap of 280 ms
    t, x = t[kept], x[kept]
    cut = cut_at_reversals(t, x, MIN_STROKE)
    travels = [x[piece][-1] - x[piece][0] for piece in cut.pieces]
    missed = 0.28 * 0.012 + 2e-4  # what a gap at a corner may hide
    assert travels == pytest.approx([-0.039, 0.04, -0.041, 0.03], abs=2 * missed)
    assert (cut.partial, cut.short) == (2, 0)


def test_pieces_shorter_than_the_limit_are_left_out_and_counted():
    # a jog of 5 mm in the middle of the second stroke cuts it in two
    t, x = zigzag([0.0, 0.05, 0.02, 0.025, 0.0, 0.04, 0.03], 0.01)
    cut = cut_at_reversals(t, x, MIN_STROKE)
    assert [round(abs(x[p][-1] - x[p][0]), 3) for p in cut.pieces] == [0.03, 0.025, 0.04]
    assert cut.short == 1


def test_no_sample_is_in_two_strokes_and_none_between_them_is_lost():
    t, x = zigzag(CORNERS, 0.012)
    pieces = cut_at_reversals(t, x, MIN_STROKE).pieces
    assert all(a.stop == b.start for a, b in zip(pieces, pieces[1:], strict=False))


@pytest.mark.parametrize("x", [np.zeros(50), np.linspace(0, 0.1, 50), np.zeros(0)])
def test_motion_without_reversal_gives_no_whole_stroke(x):
    cut = cut_at_reversals(np.arange(len(x)) / 100, x, MIN_STROKE)
    assert (cut.pieces, cut.partial, cut.short) == ((), int(len(x) > 0), 0)


@pytest.mark.parametrize("speed", [0.012, -0.005])
def test_stroke_speed_is_the_slope_and_forgets_slow_ends(speed):
    t = np.sort(np.random.default_rng(1).uniform(0, 3, 200))
    x = np.interp(t, [0, 0.3, 2.7, 3.0], np.array([0, 0, 2.4, 2.4]) * speed)
    assert stroke_speed(t, x) == pytest.approx(speed, rel=1e-9)


@pytest.mark.parametrize("rests", [(1.0, 1.0), (1.0, 0.0), (0.0, 1.0)])
def test_a_stroke_from_or_to_a_rest_is_whole(rests):
    t, x = zigzag([0.0, 0.05, 0.0, 0.05, 0.0], 0.02)
    before, after = (np.full(round(100 * rest), 0.0) for rest in rests)
    x = np.concatenate([before, x, after]) + 1e-6 * np.random.default_rng(1).standard_normal(
        len(x) + len(before) + len(after)
    )
    cut = cut_at_reversals(np.arange(len(x)) / 100, x, MIN_STROKE)
    assert len(cut.pieces) == 2 + sum(rest > 0 for rest in rests)
    assert cut.partial == sum(rest == 0 for rest in rests)
    assert [abs(x[p.stop] - x[p.start]) for p in cut.pieces] == pytest.approx(
        [0.05] * len(cut.pieces), abs=2e-3
    )


def test_run_in_and_run_out_are_not_settled():
    corners = [0.0, 0.03, 0.0, 0.05, 0.0, 0.05, 0.0, 0.05, 0.0, 0.05, 0.01, 0.04]
    t, x = zigzag([0.02, *corners, 0.0], 0.02)
    pieces = cut_at_reversals(t, x, MIN_STROKE).pieces
    settled = settled_strokes(t, x, pieces)
    assert [round(abs(x[p.stop] - x[p.start]), 2) for p in settled] == [0.05] * 7
    assert (pieces.index(settled[0]), len(pieces) - 1 - pieces.index(settled[-1])) == (2, 2)


def test_strokes_that_all_differ_are_all_kept():
    t, x = zigzag([0.0, 0.03, 0.0, 0.05, 0.0, 0.08, 0.0, 0.12, 0.0], 0.02)
    pieces = cut_at_reversals(t, x, MIN_STROKE).pieces
    assert settled_strokes(t, x, pieces) == pieces
