"""Import by a map: other columns, units, separators, several strokes a file."""

import math
import re
from datetime import date

import numpy as np
import pytest
import yaml

from hbench.config.import_map import parse_import_map
from hbench.config.schedule import Screening
from hbench.errors import ConfigError, DataError
from hbench.store.campaign.folder import load_campaign
from hbench.store.campaign.run_csv import SEVERAL_RUNS
from hbench.store.importing.importer import import_folder

BORE_M = 0.025


def lines_of(speeds_mm_s, stroke_mm=40.0, separator="\t", turns=5):
    """Return a log: ms, position [mm, positive inwards], bar, N; extending first."""
    corners, times = [0.0], [0.0]
    for turn in range(turns):
        out = turn % 2 == 0
        corners.append(-stroke_mm if out else 0.0)
        times.append(times[-1] + stroke_mm / speeds_mm_s[0 if out else 1])
    t = np.arange(0, times[-1], 0.01)
    x = np.interp(t, times, corners)
    force = 3e5 * math.pi / 4 * BORE_M**2 - np.where(np.gradient(x) < 0, 5.0, -7.0)
    rows = zip(1e3 * t, x, np.full(len(t), 3.0), force, strict=True)
    return "".join(separator.join(f"{v:.3f}" for v in row) + "\n" for row in rows)


@pytest.fixture
def rules():
    return {
        "name": "others",
        "format": {"separator": "whitespace", "header": False},
        "columns": {
            "t_s": {"column": 1, "unit": "ms"},
            "x_m": {"column": 2, "unit": "mm", "scale": -1},
            "p_tp_pa": {"column": 3, "unit": "bar"},
            "f_applied_n": {"column": 4, "unit": "N"},
        },
        "constants": {"p_tr_pa": "0 bar"},
        "series": [
            {
                "label": "NBR",
                "files": "{trial}/{pressure}bar.txt",
                "cylinder": {"piston_diameter": "25 mm"},
            }
        ],
        "cut": "reversals",
        "min_stroke": "20 mm",
    }


@pytest.fixture
def source(tmp_path):
    folder = tmp_path / "logs"
    for trial, speeds in ((1, (12.2, 8.04)), (2, (12.4, 8.14))):
        (folder / str(trial)).mkdir(parents=True)
        (folder / str(trial) / "3bar.txt").write_text(lines_of(speeds))
    (folder / "notes.txt").write_text("not a log")
    return folder


@pytest.fixture
def bring_in(source, rules, tmp_path, at):
    def bring_in():
        path = tmp_path / "map.yaml"
        path.write_text(yaml.safe_dump(rules))
        return (
            import_folder(source, tmp_path / "out", path, {}, at(0)),
            load_campaign(tmp_path / "out"),
        )

    return bring_in


def test_strokes_become_runs_with_direction_trial_label_and_load(bring_in):
    summary, campaign = bring_in()
    # five strokes a file; the first and the last are left out
    assert (summary.runs, summary.files) == (6, 2)
    assert [plan.direction for plan in campaign.plans] == ["retract", "extend", "retract"] * 2
    assert [plan.trial for plan in campaign.plans] == [1, 1, 1, 2, 2, 2]
    area = math.pi / 4 * BORE_M**2
    for plan in campaign.plans:
        assert plan.label == "NBR"
        assert plan.specimen.area_piston_m2 == pytest.approx(area)
        assert plan.f_load_n == pytest.approx(3e5 * area)
    assert [int(re.findall(r"\d+", note)[-1]) for note in summary.notes[:1]] == [2]  # each file
    assert any("notes.txt" in note for note in summary.notes)


def test_nominal_speed_is_the_median_over_the_trials_to_three_digits(bring_in):
    _, campaign = bring_in()
    assert {plan.v_ref_m_s for plan in campaign.plans} == {0.0123, -0.00809}


def test_nominal_speed_of_the_map_is_taken(bring_in, rules):
    rules["series"][0]["speed"] = "10 mm/s"
    assert {plan.v_ref_m_s for plan in bring_in()[1].plans} == {0.01, -0.01}


def test_friction_has_the_sign_of_the_motion(bring_in):
    for run in bring_in()[1].runs():
        middle = slice(len(run.t_s) // 4, 3 * len(run.t_s) // 4)
        friction = (
            run.p_tp_pa * run.plan.specimen.area_piston_m2
            - run.p_tr_pa * run.plan.specimen.area_rod_m2
            - run.f_applied_n
        )[middle]
        assert friction == pytest.approx(5.0 if run.plan.direction == "extend" else -7.0, abs=1e-3)
        assert np.sign(run.x_m[-1] - run.x_m[0]) == np.sign(run.plan.v_ref_m_s)


def test_lines_point_into_the_source_file(bring_in, source):
    _, campaign = bring_in()
    lines = (source / "1" / "3bar.txt").read_text().splitlines()
    run, entry = next(iter(campaign.runs())), campaign.entries[0]
    first, last = entry.origin["lines"]
    assert float(lines[first - 1].split()[0]) / 1e3 == pytest.approx(run.t_s[0])
    assert float(lines[last - 1].split()[0]) / 1e3 == pytest.approx(run.t_s[-1])
    assert last - first + 1 == len(run.t_s)


def test_rows_at_the_start_are_skipped_unread(bring_in, rules, source):
    for trial in "12":
        path = source / trial / "3bar.txt"
        path.write_text("start up\n9 9\n" + path.read_text())
    rules["format"]["skip_rows"] = 2
    assert bring_in()[0].runs == 6


def test_semicolons_decimal_commas_and_named_columns(bring_in, rules, source):
    rules["format"] = {"separator": "semicolon", "decimal": ",", "header": True}
    for column, name in zip(rules["columns"].values(), ["Zeit", "Weg", "p", "F"], strict=True):
        column["column"] = name
    for trial in "12":
        text = lines_of((12.2, 8.04), separator=";").replace(".", ",")
        (source / trial / "3bar.txt").write_text("Zeit;Weg;p;F\n" + text)
    summary, campaign = bring_in()
    assert summary.runs == 6
    assert any("2/3bar.txt" in note and "1/3bar.txt" in note for note in summary.notes)
    assert campaign.plans[0].v_ref_m_s == pytest.approx(-0.00804)


def test_uncut_files_are_one_run_each(bring_in, rules, source):
    rules["cut"] = "none"
    for trial in "12":
        (source / trial / "3bar.txt").write_text(lines_of((12.1 + 0.1 * int(trial), 8.0), turns=1))
    summary, campaign = bring_in()
    assert [(p.v_ref_m_s, p.trial) for p in campaign.plans] == [(0.0123, 1), (0.0123, 2)]
    assert len(summary.notes) == 1 and "notes.txt" in summary.notes[0]


def test_screening_of_the_map_is_kept(bring_in, rules):
    rules["screening"] = {"max_gap": "0.35 s"}
    assert bring_in()[1].screening() == Screening(max_gap="0.35 s", high_speed_error=None)


def test_back_and_forth_without_cut_is_refused_with_a_hint(bring_in, rules, source):
    rules["cut"] = "none"
    for trial in "12":
        (source / trial / "3bar.txt").write_text(lines_of((12.0, 8.0), turns=2))
    with pytest.raises(DataError, match=r"3bar.txt: .*\b20 mm") as caught:
        bring_in()
    assert "cut: reversals" in caught.value.hint
    assert "as a whole" in caught.value.hint and "kind: triangle" in caught.value.hint


def test_a_stroke_that_a_wrong_unit_makes_too_short_is_not_taken_for_back_and_forth(
    bring_in, rules
):
    rules["cut"], rules["min_stroke"] = "none", "1500 mm"
    with pytest.raises(DataError, match="expected one stroke of at least min_stroke") as caught:
        bring_in()
    assert "units of x_m" in caught.value.hint and "reversals" not in caught.value.hint


def test_strokes_that_the_ends_of_a_file_cut_off_are_called_so(bring_in, source):
    for trial in "12":  # 40 mm there and back
        (source / trial / "3bar.txt").write_text(lines_of((12.0, 8.0), turns=2))
    with pytest.raises(DataError, match="no stroke between two reversals") as caught:
        bring_in()
    assert caught.value.hint.startswith("The start or the end of the file cuts its strokes off")


def test_a_file_of_one_sample_is_left_out_without_a_warning_of_numpy(bring_in, source):
    (source / "3").mkdir()
    (source / "3" / "3bar.txt").write_text(lines_of((12, 8)).splitlines()[0])
    summary, _ = bring_in()
    assert any(note.startswith("3/3bar.txt: left out: no stroke") for note in summary.notes)


BAD_CELL = "line 42: column 4: found '---'; expected a number"
BACK = "line 42: time goes from 0.4 s to 0.39 s; expected increasing time"


def spoil(path, fault):
    lines = path.read_text().splitlines()
    lines[41] = "410.0 -5.0 3.0 ---" if fault == BAD_CELL else lines[39]
    path.write_text("\n".join(lines))


NO_VALUE = ". Leave the cell empty, or write nan, if there is no value."


@pytest.mark.parametrize(("fault", "hint"), [(BAD_CELL, NO_VALUE), (BACK, f". {SEVERAL_RUNS}")])
def test_a_damaged_file_is_left_out_with_file_line_and_content(bring_in, source, fault, hint):
    spoil(source / "2" / "3bar.txt", fault)
    summary, campaign = bring_in()
    assert f"2/3bar.txt: left out: {fault}{hint}" in summary.notes
    assert f"2/3bar.txt: left out: {fault}{hint}" in campaign.warnings
    assert {plan.trial for plan in campaign.plans} == {1}


@pytest.mark.parametrize("fault", [BAD_CELL, BACK])
def test_if_most_files_are_damaged_the_import_is_refused(bring_in, source, fault):
    for trial in "12":
        spoil(source / trial / "3bar.txt", fault)
    with pytest.raises(DataError, match=rf"1/3bar.txt: {fault}"):
        bring_in()


def test_a_file_without_a_whole_stroke_is_left_out(bring_in, source):
    (source / "3").mkdir()
    (source / "3" / "3bar.txt").write_text(lines_of((12, 8), stroke_mm=5.0))
    summary, _ = bring_in()
    assert any(
        note.startswith("3/3bar.txt: left out: no stroke between two reversals")
        for note in summary.notes
    )
    assert summary.files == 2


def test_series_without_files_is_named(bring_in, rules):
    rules["series"][0]["files"] = "none_{pressure}.csv"
    with pytest.raises(DataError, match=r"series 'NBR'.*none_\{pressure\}\.csv") as caught:
        bring_in()
    assert re.search(r"\d+/\d+bar.txt, ", caught.value.hint)
    assert "{trial} a whole one; write a star" in caught.value.hint  # such as trials a, b and c


def test_file_of_two_series_is_refused(bring_in, rules):
    rules["series"].append({**rules["series"][0], "files": "1/{pressure}bar.txt"})
    with pytest.raises(ConfigError, match=r"1/3bar.txt: .*\{trial\}/\{p.* 1/\{p"):
        bring_in()


def test_strokes_shorter_than_the_limit_leave_nothing(bring_in, rules):
    rules["min_stroke"] = "60 mm"
    with pytest.raises(DataError, match="min_stroke.* 60 mm"):
        bring_in()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"constants": {"p_tr_pa": "0"}}, "constants.p_tr_pa = '0': has no unit"),
        ({"constants": {"p_tp_pa": "0 bar"}}, "p_tp_pa is both a column and a constant"),
        ({"constants": {"p_xx_pa": "0 bar"}}, "unknown channel 'p_xx_pa'"),
        ({"constants": {"p_tp_bar": "0 bar"}}, "'p_tp_bar'; did you mean 'p_tp_pa'[?]"),
        ({"constants": {"p_tp": "0 bar"}}, "'p_tp'; did you mean 'p_tp_pa'[?]"),
        ({"constants": {"p_t": "0 bar"}}, "'p_t'; did you mean 'p_tp_pa' or 'p_tr_pa'[?]"),
        (
            {
                "columns": {
                    "x_m": {"column": 2, "unit": "mm"},
                    "v_m_s": {"column": 2, "unit": "m/s"},
                }
            },
            "columns.x_m and columns.v_m_s are both 2",
        ),
        (
            {"columns": {"t_s": {"column": 0, "unit": "ms"}, "x_m": {"column": 1, "unit": "mm"}}},
            "columns.t_s.column.*must be at least 1",
        ),
        (
            {"columns": {"t_s": {"column": 1, "unit": "ms"}, "x_m": {"column": "x", "unit": "mm"}}},
            "columns.x_m: 'x'.*format.header",
        ),
        (
            {"columns": {"t_s": {"column": 1, "unit": "bar"}, "x_m": {"column": 2, "unit": "mm"}}},
            "columns.t_s: .*'bar'.* s",
        ),
        ({"constants": {"p_tr_pa": 0}}, "constants.p_tr_pa = '0': has no unit; write .* '0 bar'"),
        (
            {"columns": {"t_s": {"column": 1, "unit": "ms"},
                         "x_m": {"column": 2, "unit": "mm", "offset": -1.5}}},
            "columns.x_m.offset = '-1.5': has no unit; write for example '-1.5 mm'",
        ),
        ({"details": {"serial": 17}}, 'details.serial = 17: must be text; put it in quotes: "17"'),
        ({"details": {"day": date(2024, 5, 1)}}, 'text; put it in quotes: "2024-05-01"'),
        ({"details": {"used": True}}, "details.used = True: must be text; put it in quotes$"),
        ({"name": None}, "name = None: must be text$"),
    ],
)  # fmt: skip
def test_a_map_that_cannot_work_is_refused_with_key_value_and_what_to_write(rules, change, message):
    with pytest.raises(ConfigError, match=message):
        parse_import_map({**rules, **change}, "map.yaml")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"files": "{presure}.csv"}, "series.0: files: .*{pressure}, .* {trial}"),
        ({"files": "{trial}/{trial}.csv"}, "series.0: files: "),
        ({"pressure_unit": "N"}, "pressure_unit"),
        ({"files": "{load}kg_{trial}.csv"}, "followed by kg, a mass; write load_unit: kgf"),
        (
            {"cylinder": {"piston_diameter": "25 mm", "rod_diameter": "25 mm"}},
            "rod_diameter .*plunger.* p_tr_pa: 0 bar under constants",
        ),
    ],
)
def test_series_that_cannot_work_is_refused(rules, change, message):
    rules["series"][0] |= change
    with pytest.raises(ConfigError, match=message):
        parse_import_map(rules, "map.yaml")


def test_a_series_may_have_a_kind_and_a_cut_of_its_own(bring_in, rules, source):
    (source / "loops").mkdir()
    (source / "loops" / "3bar.txt").write_text(lines_of((12.0, 8.0), turns=4))
    loops = {"files": "loops/{pressure}bar.txt", "kind": "triangle", "cut": "none"}
    rules["series"].append({**rules["series"][0], **loops})
    summary, campaign = bring_in()
    kinds = [plan.kind for plan in campaign.plans]
    assert kinds == ["steady"] * 6 + ["triangle"]
    assert "6 runs cut at reversals from 2 files" in summary.notes
    assert "files that are one run each: 1" in summary.notes


def test_an_unknown_kind_of_a_series_is_refused(rules):
    rules["series"][0]["kind"] = "sine"
    with pytest.raises(ConfigError, match=r"series\.0\.kind|series\[0\]\.kind|kind.*must be one"):
        parse_import_map(rules, "map")


@pytest.mark.parametrize(("rod", "noted"), [({}, 1), ({"rod_diameter": "0 mm"}, 0)], ids=str)
def test_a_map_without_a_rod_is_noted_where_the_rod_side_has_a_pressure(
    bring_in, rules, rod, noted
):
    rules["series"][0]["cylinder"] = {"piston_diameter": "40 mm", **rod}
    rules["columns"]["p_tr_pa"] = {"column": 4, "unit": "bar"}
    del rules["columns"]["f_applied_n"]
    rules["constants"] = {"f_applied_n": "0 N"}
    notes = [note for note in bring_in()[0].notes if "rod_diameter" in note]
    assert len(notes) == noted
    for note in notes:
        assert "p_tr_pa acts on the whole piston area: enter rod_diameter" in note


def test_strokes_of_constant_speed_are_no_triangle_of_speed(bring_in, rules):
    rules["kind"], rules["cut"] = "triangle", "none"
    (note,) = [note for note in bring_in()[0].notes if "constant speed" in note]
    assert "write 'kind: steady' and 'cut: reversals'" in note
    assert 60 < float(re.search(r"([\d.]+) % of the travel", note)[1]) <= 100
