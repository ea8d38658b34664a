"""Channels of different sampling rates in one file, each with times of its own."""

import re
from itertools import zip_longest

import numpy as np
import pytest

from hbench.config.import_map import parse_import_map
from hbench.errors import ConfigError, DataError


@pytest.fixture
def bring_in(rules, import_by, tmp_path):
    """Import columns of different lengths from one text."""

    def bring_in(**columns):
        rows = zip_longest(*columns.values())
        text = "".join(",".join(cell(value) for value in row) + "\n" for row in rows)
        (tmp_path / "a.csv").write_text(",".join(columns) + "\n" + text)
        (run,), notes = import_by(rules)
        return run, notes

    def cell(value):
        return "" if value is None or value != value else repr(float(value))

    rules["columns"] = {
        "t_s": {"column": "t", "unit": "ms"},
        "x_m": {"column": "x", "unit": "mm"},
        "p_tp_pa": {"column": "p", "unit": "bar", "time": "tp"},
        "f_applied_n": {"column": "f", "unit": "N", "time": "tf"},
    }
    return bring_in


T = np.arange(0, 2000, 10.0)  # ms
FAST = np.arange(0, 2000, 1.0)
SLOW = np.arange(0, 2001, 50.0)


def columns(**changes):
    return {
        **{"t": T, "x": 0.04 * T, "tp": FAST, "p": 50 + 0 * FAST, "tf": SLOW, "f": 3 * SLOW},
        **changes,
    }


def test_a_slower_channel_is_interpolated_and_a_faster_one_averaged(bring_in):
    tone_hz = 90.0  # every tenth sample would show it at 10 Hz in full size
    run, notes = bring_in(**columns(p=50 + np.cos(2 * np.pi * tone_hz * FAST / 1e3) + FAST / 100))
    # the faster channel does not cover the interval about the first time
    np.testing.assert_allclose(run.t_s, T[1:] / 1e3)
    np.testing.assert_allclose(run.x_m, 0.04e-3 * T[1:])
    np.testing.assert_allclose(run.f_applied_n, 3 * T[1:])
    ripple = run.p_tp_pa / 1e5 - 50 - run.t_s * 10
    gain = abs(ripple @ np.exp(2j * np.pi * tone_hz * run.t_s)) * 2 / len(run.t_s)
    # the samples' straight lines have the gain sinc^2 of one ms themselves
    assert gain == pytest.approx(np.sinc(tone_hz / 100) * np.sinc(tone_hz / 1e3) ** 2, rel=0.03)
    assert ["100", "20", "1000", "0.01"] == re.findall(r"[\d.]+(?= Hz| s\b)", notes[0])
    assert re.findall(r"\d+ of \d+", notes[1]) == ["1 of 200"] and len(notes) == 2


def test_times_of_one_rate_that_coincide_give_the_samples_themselves(bring_in):
    noise = np.random.default_rng(1).standard_normal(len(T))
    run, notes = bring_in(**columns(tp=T[3:], p=9 + noise[3:], tf=T[:-2], f=noise[:-2]))
    np.testing.assert_array_equal(run.f_applied_n, noise[3:-2])
    np.testing.assert_allclose(run.p_tp_pa, 1e5 * (9 + noise[3:-2]))
    assert len(notes) == 1 and "5 of 200" in notes[0]


def test_gaps_are_not_bridged(bring_in):
    slow = SLOW[(SLOW <= 500) | (SLOW >= 800)]
    fast = FAST[(FAST <= 1200) | (FAST >= 1450)]
    run, _ = bring_in(**columns(tp=fast, p=0 * fast, tf=slow, f=3 * slow))
    t_ms = 1e3 * run.t_s
    unknown = (t_ms > 500.5) & (t_ms < 799.5)
    np.testing.assert_array_equal(np.isnan(run.f_applied_n), unknown)
    np.testing.assert_allclose(run.f_applied_n[~unknown], 3 * t_ms[~unknown])
    # a mean over 10 ms that touches the gap is unknown too
    np.testing.assert_array_equal(np.isnan(run.p_tp_pa), (t_ms > 1195.5) & (t_ms < 1454.5))


def test_a_gap_of_the_position_stays_a_gap(bring_in):
    t = T[(T < 700) | (T > 1100)]
    run, _ = bring_in(**columns(t=t, x=0.04 * t))
    np.testing.assert_allclose(run.t_s, t[1:] / 1e3)


def test_unknown_values_stay_unknown(bring_in):
    f, p = 3 * SLOW, 0 * FAST
    f[10], p[333] = np.nan, np.nan
    run, _ = bring_in(**columns(f=f, p=p))
    t_ms = 1e3 * run.t_s
    np.testing.assert_array_equal(np.isnan(run.f_applied_n), abs(t_ms - 500) < 49.5)
    np.testing.assert_array_equal(np.isnan(run.p_tp_pa), abs(t_ms - 333) < 6)


def test_a_clipped_sample_of_a_faster_channel_marks_its_mean(bring_in):
    p = 50 + 40 * np.sin(FAST / 150) + np.random.default_rng(2).standard_normal(len(FAST))
    p = np.minimum(p, 80.0)
    run, notes = bring_in(**columns(p=p))
    held = np.array([(p[abs(t - FAST) < 5] == 80).any() for t in 1e3 * run.t_s])
    assert 10 < held.sum() < 100
    np.testing.assert_array_equal(run.sensor_saturated, held)
    assert any("p_tp_pa: clipped at 80 bar" in note for note in notes)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"tf": SLOW[::4], "f": SLOW[::4]}, r"f_applied_n: 0.2 s.*0.1 s"),
        ({"tf": SLOW + 5000}, r"no time in common.* 0 s to 1.99 s"),
        ({"tf": SLOW[::-1]}, r"line 3: time goes from 2 s to 1.95 s"),
        ({"f": 3 * np.append(SLOW, 2050)}, r"line 43: f_applied_n without a time"),
    ],
)
def test_channels_that_cannot_be_aligned_are_refused(bring_in, change, message):
    with pytest.raises(DataError, match=message):
        bring_in(**columns(**change))


def test_samples_without_a_position_are_a_gap(bring_in):
    x = 0.04 * T
    x[100:105] = np.nan
    run, notes = bring_in(**columns(x=x))
    assert np.diff(run.t_s).max() == pytest.approx(6 * np.diff(run.t_s).min())
    assert any("5 rows left out: short or without a position" in note for note in notes)


def test_date_times_of_two_columns_count_from_the_same_instant(rules, import_by, tmp_path):
    rules["columns"] = {
        "t_s": {"column": "t", "unit": "date-time"},
        "x_m": {"column": "x", "unit": "mm"},
        "f_applied_n": {"column": "f", "unit": "N", "time": "tf"},
    }
    times = [f"2024-05-01T00:00:{i / 10:06.3f}" for i in range(40)]
    forces = [f"{times[i]},{i}" for i in range(5, 40)] + [","] * 5
    rows = [f"{times[i]},{i},{forces[i]}\n" for i in range(40)]
    (tmp_path / "a.csv").write_text("t,x,tf,f\n" + "".join(rows))
    rules["screening"] = {"max_gap": "0.2 s"}
    (run,), _ = import_by(rules)
    np.testing.assert_allclose(run.t_s, np.arange(5, 40) / 10)
    np.testing.assert_allclose(run.f_applied_n, np.arange(5, 40))


def test_a_time_needs_the_unit_of_t_s(rules):
    rules["columns"] = {"x_m": {"column": "x", "unit": "mm", "time": "t"}}
    rules["columns"]["p_tp_pa"] = {"column": "p", "unit": "bar"}
    with pytest.raises(ConfigError, match="columns.x_m: time needs columns.t_s"):
        parse_import_map(rules, "map.yaml")


def test_a_file_that_states_no_times_needs_t_s(bring_in, rules):
    for column in rules["columns"].values():
        column.pop("time", None)
    del rules["columns"]["t_s"]
    with pytest.raises(DataError, match=r"a.csv: column f: .*no times") as caught:
        bring_in(**columns())
    assert "columns.t_s" in caught.value.hint
