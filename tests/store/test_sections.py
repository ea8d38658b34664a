"""Runs of imported files: positions that strokes share, the top speed of unsteady motions."""

import re
from datetime import UTC, datetime

import numpy as np
import pytest
import yaml

from hbench import workflow
from hbench.errors import DataError
from hbench.store.importing.sections import _top_speed
from tests.support.strokes import there_and_back


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_triangle_has_the_sign_of_its_first_motion_whatever_the_noise(direction):
    t_s = np.arange(0, 12, 0.002)
    cycle = np.abs((t_s / 2 + 1) % 2 - 1)  # up in 2 s, down in 2 s
    for seed in range(20):
        noise = np.random.default_rng(seed).normal(0, 2e-5, len(t_s))
        x_m = 0.15 + direction * 0.04 * cycle + noise
        found = _top_speed({"t_s": t_s, "x_m": x_m}, "triangle", None)
        assert found == pytest.approx(direction * 0.02, rel=0.05)
        assert _top_speed({"t_s": t_s, "x_m": x_m}, "triangle", 0.02) == direction * 0.02


def test_a_log_without_motion_has_no_speed():
    t_s = np.arange(0, 1, 0.01)
    assert _top_speed({"t_s": t_s, "x_m": np.zeros(100)}, "triangle", None) == 0.0


def ramped(lengths_m, v_m_s=0.06, home_ramp_s=0.1, rate_hz=200, travel_m=0.25):
    """Strokes out, each at speed after a ramp of its own length, and home again at once."""
    speeds = [np.zeros(rate_hz // 2)]
    for length in lengths_m:
        up = np.linspace(0.0, v_m_s, max(round(2 * length / v_m_s * rate_hz), 2))
        down = np.linspace(v_m_s, 0.0, round(home_ramp_s * rate_hz))
        flat = round((travel_m - (up.sum() + down.sum()) / rate_hz) / v_m_s * rate_hz)
        out = np.concatenate([up, np.full(flat, v_m_s), down])
        back = round((out.sum() / rate_hz - v_m_s * home_ramp_s) / v_m_s * rate_hz)
        home = np.concatenate([-down[::-1], np.full(back, -v_m_s), -down])
        speeds += [out, np.zeros(rate_hz // 2), home, np.zeros(rate_hz // 2)]
    v = np.concatenate(speeds)
    return np.arange(len(v)) / rate_hz, 0.05 + np.cumsum(v) / rate_hz, v


@pytest.fixture
def half_bands(tmp_path):
    """Return a function: half bands of strokes against a load that rises by 80 kN/m."""

    def of(lengths_m):
        t_s, x_m, v = ramped(lengths_m)
        load_n = 15e3 + 80e3 * (x_m - 0.05)
        p_bar = (load_n + 240.0 * np.tanh(v / 1e-4)) / 1.2566e-3 / 1e5
        p_bar += np.random.default_rng(4).normal(0, 0.02, len(t_s))
        (tmp_path / "logs").mkdir()
        table = np.column_stack([t_s, 1e3 * x_m, p_bar])
        np.savetxt(tmp_path / "logs" / "a.csv", table, "%.4f", ",", header="t,x,p", comments="")
        columns = {"t_s": ("t", "s"), "x_m": ("x", "mm"), "p_tp_pa": ("p", "bar")}
        rules = {
            "name": "uneven",
            "kind": "steady",
            "columns": {key: {"column": c, "unit": unit} for key, (c, unit) in columns.items()},
            "constants": {"p_tr_pa": "0 bar", "f_applied_n": "0 N"},
            "cut": "reversals",
            "screening": {"friction_drift": "50 kN"},
            "series": [
                {
                    "label": "a",
                    "files": "a.csv",
                    "cylinder": {"piston_diameter": "40 mm", "rod_diameter": "0 mm"},
                }
            ],
        }
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
        at = datetime(2026, 1, 1, tzinfo=UTC)
        workflow.import_runs(
            tmp_path / "logs", tmp_path / "campaign", tmp_path / "map.yaml", lambda: at
        )
        (band,) = workflow.analyze(tmp_path / "campaign").bands
        return band.trials_half_n

    return of


def test_half_bands_are_of_positions_that_all_strokes_cover(half_bands):
    """A load of 80 kN/m over 20 mm more in one direction would add 800 N."""
    assert half_bands([0.003, 0.04, 0.01, 0.06]) == pytest.approx([240.0] * 4, abs=2.0)


def test_a_stroke_that_covers_few_positions_is_left_out(half_bands):
    """The next stroke out takes its place beside the stroke back; a sample is 0.3 mm, 24 N."""
    found = half_bands([0.003, 0.19, 0.01, 0.004])
    assert len(found) == 3 and found == pytest.approx([240.0] * 3, abs=12.0)


def slow_log(folder, rate_hz, clock, cycles=3):
    """Import strokes at 20 mm/s whose times are written with one decimal."""
    log = there_and_back(0.02, 500.0, rate_hz=rate_hz, cycles=cycles)
    log["t_s"] = np.round(log["t_s"], 1)
    (folder / "logs").mkdir()
    rows = np.stack(list(log.values()), axis=1)
    np.savetxt(folder / "logs/1.csv", rows, "%.8g", ",", header=",".join(log), comments="")
    cylinder = {"piston_diameter": "40 mm", "rod_diameter": "25 mm"}
    rules = {
        "name": "slow",
        "cut": "reversals",
        "columns": {name: {"column": name} for name in log},
        "series": [{"label": "A", "files": "{trial}.csv", "cylinder": cylinder}],
    }
    (folder / "map.yaml").write_text(yaml.safe_dump(rules))
    return workflow.import_runs(folder / "logs", folder / "out", folder / "map.yaml", clock)


def test_a_log_of_10_hz_is_cut_from_its_rest_on(tmp_path, clock):
    assert slow_log(tmp_path, 10.0, clock).runs == 6


def test_a_log_too_slow_to_show_a_rest_is_refused_with_its_rate(tmp_path, clock):
    with pytest.raises(DataError) as caught:
        slow_log(tmp_path, 5.0, clock, cycles=1)
    assert "no stroke" in caught.value.message
    assert "The log has 5 Hz, and a rest is found from 10 Hz on" in caught.value.hint


def test_strokes_of_a_session_with_a_length_for_each_speed_are_all_runs(rules, import_by, tmp_path):
    """A slow stroke is short on most benches: it takes as long as a fast one over the travel."""
    lengths_mm = {20.0: 70.0, 60.0: 180.0, 150.0: 340.0}
    t_s, x_mm = [0.0, 1.0], [80.0, 80.0]
    for speed, length in lengths_mm.items():
        for end in (80.0 + length, 80.0):
            t_s += [t_s[-1] + length / speed, t_s[-1] + length / speed + 0.7]
            x_mm += [end, end]
    times = np.arange(0.0, t_s[-1], 0.004)
    x = np.interp(times, t_s, x_mm)
    p = 40.0 + 6.0 * np.sign(np.gradient(x)) + np.random.default_rng(8).normal(0, 0.05, len(x))
    (tmp_path / "logs").mkdir()
    for trial in (1, 2):
        np.savetxt(
            tmp_path / "logs" / f"session {trial}.csv",
            np.column_stack([times, x, p]),
            "%.4f",
            ",",
            header="t,x,p",
            comments="",
        )
    columns = {"t_s": ("t", "s"), "x_m": ("x", "mm"), "p_tp_pa": ("p", "bar")}
    rules["columns"] = {key: {"column": c, "unit": unit} for key, (c, unit) in columns.items()}
    rules["constants"] = {"p_tr_pa": "0 bar", "f_applied_n": "0 N"}
    rules["cut"] = "reversals"
    rules["series"][0]["files"] = "session {trial}.csv"
    runs, notes = import_by(rules, tmp_path / "logs")
    found = [round(1e3 * run.plan.v_ref_m_s) for run in runs]
    assert found == 2 * [20, -20, 60, -60, 150, -150]
    assert not any("left out" in str(note) for note in notes)
    for run in runs:
        covered_mm = 1e3 * (run.plan.x_high_m - run.plan.x_low_m)
        assert covered_mm < lengths_mm[abs(round(1e3 * run.plan.v_ref_m_s))]


def write_one_pressure(rules, folder, name, times, x_mm):
    """Write a log of time, position and the pressure of a piston side whose rod side is open."""
    folder.mkdir()
    table = np.column_stack([times, x_mm, 30.0 + 4.0 * np.sign(np.gradient(x_mm))])
    np.savetxt(folder / name, table, "%.4f", ",", header="t,x,p", comments="")
    columns = {"t_s": ("t", "s"), "x_m": ("x", "mm"), "p_tp_pa": ("p", "bar")}
    rules["columns"] = {key: {"column": c, "unit": unit} for key, (c, unit) in columns.items()}
    rules["constants"] = {"p_tr_pa": "0 bar", "f_applied_n": "0 N"}


def test_fast_strokes_that_settle_late_are_runs_without_common_positions(
    rules, import_by, tmp_path
):
    """After 0.3 s at 400 mm/s, 120 mm of a stroke of 250 mm are gone, and 20 mm of a slow one."""
    t_s, x_mm = [0.0, 1.0], [30.0, 30.0]
    for speed in (25.0, 60.0, 90.0, 120.0, 400.0):
        for end in (280.0, 30.0):
            t_s += [t_s[-1] + 250.0 / speed, t_s[-1] + 250.0 / speed + 0.7]
            x_mm += [end, end]
    times = np.arange(0.0, t_s[-1], 0.002)
    x = np.interp(times, t_s, x_mm)
    write_one_pressure(rules, tmp_path / "logs", "1.csv", times, x)
    rules["cut"] = "reversals"
    rules["series"][0]["files"] = "{trial}.csv"
    runs, _ = import_by(rules, tmp_path / "logs")
    speeds = [1e3 * run.plan.v_ref_m_s for run in runs]
    assert speeds == pytest.approx([25, -25, 60, -60, 90, -90, 120, -120, 400, -400], rel=0.01)
    assert [run.plan.x_low_m is None for run in runs] == 8 * [False] + 2 * [True]


@pytest.mark.parametrize(("back_mm_s", "noted"), [(50.0, True), (150.0, False)])
def test_a_stroke_back_at_the_nominal_speed_that_is_not_used_is_noted(
    rules, import_by, tmp_path, back_mm_s, noted
):
    """The speed of the file's name is 50 mm/s; a faster way back is none of its strokes."""
    turn_s = 1.0 + 200.0 / 50.0
    knots = [0.0, 1.0, turn_s, turn_s + 0.7, turn_s + 0.7 + 140.0 / back_mm_s]
    times = np.arange(0.0, knots[-1] + 0.5, 0.004)
    x = np.interp(times, knots, [80.0, 80.0, 280.0, 280.0, 140.0])
    write_one_pressure(rules, tmp_path / "logs", "50_1.csv", times, x)
    rules["series"][0]["files"] = "{speed}_{trial}.csv"
    (run,), notes = import_by(rules, tmp_path / "logs")
    assert run.plan.v_ref_m_s == pytest.approx(0.05)
    assert any("only extending is used (cut: reversals)" in note for note in notes) is noted


@pytest.mark.parametrize("cut", ["none", "plateaus", "reversals"])
@pytest.mark.parametrize("gap_s", [1.0, 10.0, None])
def test_a_second_run_in_a_file_is_noted_or_cut_out(rules, import_by, tmp_path, gap_s, cut):
    """The logger pauses while the piston goes back; without a pause there is one run."""
    once = np.arange(0.0, 6.0, 0.004)
    x = np.interp(once, [0.0, 0.7, 4.7], [80.0, 80.0, 280.0])
    times = once if gap_s is None else np.concatenate([once, once + once[-1] + gap_s])
    both = np.tile(x, len(times) // len(once))
    write_one_pressure(rules, tmp_path / "logs", "50_1.csv", times, both)
    rules["series"][0]["files"] = "{speed}_{trial}.csv"
    runs, notes = import_by(rules | {"cut": cut}, tmp_path / "logs")
    assert len(runs) == (2 if cut != "none" and gap_s else 1)
    assert all(run.plan.v_ref_m_s == pytest.approx(0.05) for run in runs)
    lost = [note for note in notes if "strokes within a gap of the log, left out: 1" in note]
    assert len(lost) == (cut == "reversals" and gap_s is not None)
    noted = [note for note in notes if "2 sections at the nominal speed; only one is used" in note]
    assert len(noted) == (cut == "none" and gap_s is not None)


@pytest.mark.parametrize(("wander", "left_out"), [(0.3, 0.75), (0.0, 0.0)])
def test_travel_without_constant_speed_is_noted_where_a_run_is_made_of_each_plateau(
    wander, left_out, rules, import_by, tmp_path
):
    """20 mm/s for 5 s, then 60 mm/s for 5 s, which a weight does not hold constant."""
    t_s = np.arange(0, 12, 0.01)
    fast = 60 * (1 + wander * np.sin(2 * np.pi * t_s))
    v_mm_s = np.select([t_s < 1, t_s < 6, t_s < 11], [0, 20, fast], 0.0)
    table = np.column_stack([t_s, 10 + np.cumsum(v_mm_s) / 100, 5 + 0 * t_s, 0 * t_s])
    (tmp_path / "logs").mkdir()
    np.savetxt(tmp_path / "logs/a.csv", table, "%.4f", ",", header="t,x,p,f", comments="")
    units = {"t_s": ("t", "s"), "x_m": ("x", "mm"), "p_tp_pa": ("p", "bar")}
    units["f_applied_n"] = ("f", "N")
    rules["columns"] = {c: {"column": n, "unit": u} for c, (n, u) in units.items()}
    runs, notes = import_by(rules | {"cut": "plateaus"}, tmp_path / "logs")
    assert len(runs) == (1 if left_out else 2)
    shares = re.findall(r"(\d+) % of the travel", " ".join(notes))
    assert [float(share) for share in shares] == pytest.approx(
        [100 * left_out] * bool(left_out), abs=3
    )


def test_minutes_taken_as_seconds_are_refused_with_the_travel_and_its_time(
    rules, import_by, tmp_path
):
    t_min = np.arange(0, 6, 0.01) / 60
    x_mm = 10 + 60 * np.clip(60 * t_min - 1, 0, 4)
    (tmp_path / "logs").mkdir()
    table = np.column_stack([t_min, x_mm, 5 + 0 * x_mm])
    np.savetxt(tmp_path / "logs/a.csv", table, "%.9f", ",", header="t,x,p", comments="")
    units = {"t_s": ("t", "s"), "x_m": ("x", "mm"), "p_tp_pa": ("p", "bar")}
    rules["columns"] = {c: {"column": n, "unit": u} for c, (n, u) in units.items()}
    with pytest.raises(DataError, match=r"travels 240 mm in 0\.0998 s") as caught:
        import_by(rules | {"cut": "plateaus"}, tmp_path / "logs")
    assert "units of t_s and x_m" in caught.value.hint
