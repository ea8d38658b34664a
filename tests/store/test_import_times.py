"""Uneven times, repeated times, means over intervals, and zeros from rest."""

import re

import numpy as np
import pytest
import yaml
from scipy.integrate import quad

from hbench.config.import_map import parse_import_map
from hbench.errors import ConfigError, DataError
from hbench.motion.rest import zero_offset
from hbench.store.campaign.folder import load_campaign
from hbench.store.importing.importer import import_folder
from hbench.store.importing.resampling import held_position, interval_means, whole_intervals


@pytest.fixture
def rules():
    columns = {"t_s": "t", "x_m": "x", "p_tp_pa": "p", "f_applied_n": "f"}
    units = {"t_s": "s", "x_m": "mm", "p_tp_pa": "bar", "f_applied_n": "N"}
    return {
        "name": "others",
        "columns": {c: {"column": name, "unit": units[c]} for c, name in columns.items()},
        "constants": {"p_tr_pa": "0 bar"},
        "series": [{"label": "A", "files": "a.csv", "cylinder": {"piston_diameter": "25 mm"}}],
    }


@pytest.fixture
def bring_in(rules, tmp_path, at):
    def bring_in(t, x, p, f):
        (tmp_path / "logs").mkdir(exist_ok=True)
        rows = zip(t, x, p, f, strict=True)
        text = "t,x,p,f\n" + "".join(",".join(f"{float(v)!r}" for v in row) + "\n" for row in rows)
        (tmp_path / "logs" / "a.csv").write_text(text.replace("nan", ""))
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
        source, map_file = tmp_path / "logs", tmp_path / "map.yaml"
        summary = import_folder(source, tmp_path / "out", map_file, {}, at(0))
        campaign = load_campaign(tmp_path / "out")
        return next(campaign.runs()), summary.notes, campaign

    return bring_in


def uneven(seconds, rate_hz, seed=3):
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.uniform(0.2, 1.8, round(seconds * rate_hz))) / rate_hz


def test_uneven_times_and_gaps_stay_as_they_are(bring_in):
    t = uneven(4, 50)
    t[100:] += 0.7
    run, notes, _ = bring_in(t, 10 * t, 1 + 0 * t, 0 * t)
    np.testing.assert_array_equal(run.t_s, t)
    assert notes == ()


def test_times_that_stand_still_are_refused_or_dropped_with_a_note(bring_in, rules):
    t = np.repeat(np.arange(0, 1, 0.01), [1, 3] + [1] * 98)
    x = np.arange(len(t)) * 0.4
    with pytest.raises(DataError, match=r"line 4: .*\b0.01 s.*\b0.01 s") as caught:
        bring_in(t, x, 0 * t, 0 * t)
    assert "repeated_times: drop" in caught.value.hint
    rules["repeated_times"] = "drop"
    run, notes, campaign = bring_in(t, x, 0 * t, 0 * t)
    np.testing.assert_array_equal(run.t_s, np.arange(0, 1, 0.01))
    assert run.x_m[:3].tolist() == pytest.approx([0, 0.0004, 0.0016])
    assert [note.split(" samples")[0] for note in notes] == ["a.csv: 2 of 102"]
    assert campaign.warnings == notes
    assert campaign.entries[0].origin["lines"] == [2, 103]


def test_time_that_goes_back_is_refused_all_the_same(bring_in, rules):
    rules["repeated_times"] = "drop"
    t = np.array([0, 0.1, 0.1, 0.2, 0.15])
    with pytest.raises(DataError, match=r"line 6: .*\b0.2 s.*\b0.15 s"):
        bring_in(t, 100 * t, t, t)


@pytest.mark.parametrize(
    ("t", "hint"), [([0.3, 0.2, 0.2, 0.1], "sort them by time"), ([0.3, 0.2, 0.4], "several runs")]
)
def test_rows_with_the_newest_first_are_to_be_sorted(bring_in, t, hint):
    with pytest.raises(DataError, match="expected increasing time") as caught:
        bring_in(t, t, t, t)
    assert hint in caught.value.hint


def test_interval_means_are_those_of_straight_lines_between_the_samples():
    t = uneven(2, 60)
    y = np.sin(7 * t) + 0.3 * np.random.default_rng(1).standard_normal(len(t))
    starts = whole_intervals(t, 20.0, 1.0)
    expected = [
        quad(
            lambda s: np.interp(s, t, y), a, a + 0.05, limit=200, points=t[(t > a) & (t < a + 0.05)]
        )
        for a in starts
    ]
    means = interval_means(t, y, starts, 20.0)
    np.testing.assert_allclose(means, [20 * value for value, _ in expected], atol=1e-9)


@pytest.mark.parametrize("frequency_hz", [2.0, 20.0, 49.0, 63.0])
def test_means_have_the_gain_of_a_rectangle_and_no_phase(frequency_hz):
    # 63 Hz would come out of every tenth sample as 37 Hz of full size
    t, rate, omega = uneven(20, 1000), 100.0, 2 * np.pi * frequency_hz
    starts = whole_intervals(t, rate, 1.0)
    middles = starts + 0.5 / rate
    means = interval_means(t, np.cos(omega * t), starts, rate)
    basis = np.column_stack([np.cos(omega * middles), np.sin(omega * middles)])
    in_phase, quadrature = np.linalg.lstsq(basis, means, rcond=None)[0]
    assert in_phase == pytest.approx(np.sinc(frequency_hz / rate), abs=0.015)
    assert quadrature == pytest.approx(0, abs=0.005)


def test_resampling_is_stated_and_leaves_gaps_as_gaps(bring_in, rules):
    rules |= {"resample": "20 Hz", "screening": {"max_gap": "0.1 s"}}
    t = np.arange(0, 4.0005, 0.01)
    t = t[(t < 1.234) | (t > 1.62)]
    f = np.where(np.arange(len(t)) == 200, np.nan, 3.0)
    run, notes, campaign = bring_in(t, 25 * t, 1 + t, f)
    # from 1.23 to 1.63 s nothing was logged: the intervals from 1.20 to 1.65 s
    expected = np.concatenate([np.arange(0.025, 1.2, 0.05), np.arange(1.675, 4, 0.05)])
    np.testing.assert_allclose(run.t_s, expected)
    np.testing.assert_allclose(run.x_m, 0.025 * expected)
    np.testing.assert_allclose(run.p_tp_pa, 1e5 * (1 + expected))
    unknown = np.isnan(run.f_applied_n)
    assert unknown.sum() in (1, 2) and abs(run.t_s[unknown] - t[200]).max() <= 0.05
    empty, resampled = notes
    assert "f_applied_n: no value in 1 of 362 samples" in empty
    assert re.findall(r"\d+", resampled) == ["362", "71", "1", "20", "9"]
    assert campaign.warnings == notes


def test_samples_are_not_completed_up(bring_in, rules):
    rules["resample"] = "200 Hz"
    t = np.arange(0, 1, 0.01)
    with pytest.raises(DataError, match="resample = 200 Hz.*100 Hz"):
        bring_in(t, 100 * t, t, t)


def at_rest_then_moving(rest_s, zero_n, seed=5, noise_mm=0.02):
    rng = np.random.default_rng(seed)
    t = np.arange(0, rest_s + 2, 0.002)
    x = 30 + 40 * np.maximum(0, t - rest_s) + noise_mm * rng.standard_normal(len(t))
    # mains hum and noise that is correlated over 20 ms
    noise = np.convolve(rng.standard_normal(len(t) + 9), np.ones(10) / np.sqrt(10), "valid")
    f = zero_n + 2 * np.sin(2 * np.pi * 50 * t) + 4 * noise + 500 * (t > rest_s)
    return t, x, 0 * t, f


def test_the_zero_at_rest_is_subtracted_and_told_with_its_standard_error(bring_in, rules):
    rules["columns"]["f_applied_n"]["zero"] = "rest"
    t, x, p, f = at_rest_then_moving(1.5, 17.0)
    run, notes, campaign = bring_in(t, x, p, f)
    np.testing.assert_allclose(f - run.f_applied_n, (f - run.f_applied_n)[0])
    zero = (f - run.f_applied_n)[0]
    assert zero == pytest.approx(17.0, abs=1.0)
    assert re.match(rf"a.csv: f_applied_n: .*\b{zero:.4g} .* 0\..* 1\.4\d s", notes[0])
    assert campaign.warnings == notes


def test_the_standard_error_of_a_zero_is_the_scatter_of_zeros():
    found = []
    for seed in range(200):
        t, _, _, f = at_rest_then_moving(2.0, 17.0, seed)
        found.append(zero_offset(t[t < 1.9], f[t < 1.9]))
    scatter = np.std([zero.mean for zero in found], ddof=1)
    # neighbouring samples are alike: white noise of this size would promise a third of it
    assert np.mean([zero.se for zero in found]) == pytest.approx(scatter, rel=0.15)
    assert np.mean([zero.mean for zero in found]) == pytest.approx(17.0, abs=4 * scatter / 200**0.5)


def test_without_rest_before_the_motion_there_is_no_zero(bring_in, rules):
    rules["columns"]["f_applied_n"]["zero"] = "rest"
    with pytest.raises(DataError, match=r"f_applied_n: .*\b0.5 s"):
        bring_in(*at_rest_then_moving(0.4, 17.0))


@pytest.mark.parametrize(
    ("back_bar", "offset", "instruments", "words"),
    [
        (5.0, None, None, ("5 bar; limit 1.3 bar, 2 % of its range", "offset: -5 bar")),
        (-5.0, "1 bar", None, ("-4 bar; limit 1.2 bar, 2 % of its range", "offset: 5 bar")),
        (
            0.3,
            None,
            0.2,
            ("0.3 bar; limit 0.2 bar, the instrument's tolerance", "offset: -0.3 bar"),
        ),
        (0.15, None, 0.2, None),
        (1.0, None, None, None),
    ],
)
def test_a_pressure_that_acts_at_rest_is_no_zero_offset(
    bring_in, rules, back_bar, offset, instruments, words
):
    t, x, _, f = at_rest_then_moving(1.5, 0.0)
    p = back_bar + 60.0 * (t > 1.5)
    rules["columns"]["p_tp_pa"] |= {"zero": "rest"} | ({"offset": offset} if offset else {})
    if instruments is not None:
        tolerance = {"tolerance": "1 %", "of": "full_scale"}
        rules["instruments"] = {
            "force": {**tolerance, "full_scale": "100 kN"},
            "pressure": {**tolerance, "full_scale": f"{100 * instruments} bar"},
        }
    if words is None:
        run, *_ = bring_in(t, x, p, f)
        assert abs(run.p_tp_pa[t < 1.4]).max() < 1e-6
        return
    with pytest.raises(DataError) as caught:
        bring_in(t, x, p, f)
    assert "a.csv: p_tp_pa: no zero offset: at rest from 0.00 to 1.4" in caught.value.message
    assert words[0] in caught.value.message
    assert "'zero: none'" in caught.value.hint and words[1] in caught.value.hint


@pytest.mark.parametrize(
    ("zero_n", "carried_n", "full_scale", "words"),
    [
        (2025.0, 2100.0, None, "is 2025 N, and the pressures of the cylinder carry 2100 N: a load"),
        (-2025.0, -2500.0, None, "is -2025 N, and the pressures of the cylinder carry -2500 N: a"),
        (400.0, 300.0, "10 kN", "is 400 N, and the pressures of the cylinder carry 300 N: a load"),
        (1200.0, 0.0, "10 kN", "is 1200 N; limit 1000 N, 10 % of its full scale"),
        (400.0, 0.0, "10 kN", None),  # an offset: the pressures carry nothing
        (400.0, -300.0, "10 kN", None),  # friction, of the other sign
        (150.0, 150.0, "10 kN", None),  # within the usual zero of a load cell
        (200.0, 0.0, None, None),
    ],
)
def test_a_load_that_acts_at_rest_is_no_zero_offset_of_the_load_cell(
    bring_in, rules, zero_n, carried_n, full_scale, words
):
    rules["columns"]["f_applied_n"]["zero"] = "rest"
    if full_scale is not None:
        tolerance = {"tolerance": "0.5 %", "of": "full_scale"}
        pressure = {**tolerance, "full_scale": "100 bar"}
        rules["instruments"] = {
            "force": {**tolerance, "full_scale": full_scale},
            "pressure": pressure,
        }
    t, x, *_ = at_rest_then_moving(1.5, 0.0)
    f = zero_n + 50.0 * (t > 1.5)
    p = (carried_n + 300.0 * (t > 1.5)) / (np.pi / 4 * 0.025**2) / 1e5
    if words is None:
        run, *_ = bring_in(t, x, p, f)
        assert abs(run.f_applied_n[t < 1.4].mean()) < 1e-6
        return
    with pytest.raises(DataError) as caught:
        bring_in(t, x, p, f)
    assert "a.csv: f_applied_n: no zero offset: at rest from 0.00 to 1.4" in caught.value.message
    assert words in caught.value.message
    assert f"'offset: {-zero_n:g} N'" in caught.value.hint


def test_the_zero_of_a_position_is_not_told_by_rest(rules):
    rules["columns"]["x_m"]["zero"] = "rest"
    with pytest.raises(ConfigError, match="columns.x_m: .*zero"):
        parse_import_map(rules, "map.yaml")


def test_a_time_in_a_wrong_unit_is_visible_where_no_stroke_is_found(bring_in, rules):
    rules["cut"] = "reversals"
    t = np.arange(0, 7, 0.02)
    x = np.interp(t, [1, 3, 4, 6], [20, 120, 120, 20])
    with pytest.raises(DataError, match="positions from 20 to 120 mm in 6980 s") as caught:
        bring_in(1e3 * t, x, 0 * t, 0 * t)  # ms taken as s
    assert "check the unit of t_s in the map" in caught.value.hint


T_FAST = np.arange(0, 6, 0.002)
MOVED = np.interp(T_FAST, [0, 1, 4, 6], [0, 0, 120, 120]) + 0.01 * np.sin(20 * T_FAST)  # mm


@pytest.mark.parametrize(
    ("x", "noted"),
    [
        (MOVED[np.arange(len(MOVED)) // 50 * 50], True),  # sampled at 10 Hz, and held
        (MOVED[np.arange(len(MOVED)) // 5 * 5], False),  # at 100 Hz, which is fast enough
        (5 * np.round(MOVED / 5), False),  # steps of an encoder
        (MOVED, False),
    ],
)
def test_a_position_that_is_held_between_slow_samples_is_noted_with_its_rate(x, noted):
    notes = [note.text.format_map(note.numbers) for note in held_position("a.csv", T_FAST, x)]
    assert len(notes) == noted
    assert all("one of 50.0 samples only, at 10.0 Hz" in note for note in notes)
    assert all("Write 'resample: 10.0 Hz'" in note for note in notes)
