"""Text files as other people's programs write them, and the units in them."""

import gzip
import lzma
import re

import numpy as np
import pytest
import yaml

from hbench.config.import_layout import Format
from hbench.config.import_map import parse_import_map
from hbench.errors import ConfigError, DataError
from hbench.store.campaign.folder import load_campaign
from hbench.store.formats.opening import open_foreign
from hbench.store.formats.text import parse_table
from hbench.store.importing.imported_run import describe_source
from hbench.store.importing.importer import import_folder
from hbench.store.suggesting.dialect import text_dialect

SEMICOLON = {"separator": "semicolon"}
GERMAN = {**SEMICOLON, "decimal": ","}


def column(data, name="x", **layout):
    data = data.encode() if isinstance(data, str) else data
    return parse_table(data, "a.csv", Format(**layout)).numbers(name).tolist()


@pytest.mark.parametrize(
    "charset", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "latin-1"]
)
def test_character_sets_are_told_from_the_bytes(charset):
    text = "Zeit;Öldruck µ\r\n0;1,5\r\n1;-2,25\r\n"
    assert column(text.encode(charset), "Öldruck µ", **GERMAN) == [1.5, -2.25]


@pytest.mark.parametrize(
    ("charset", "name"),
    [
        ("gb18030", "无杆腔压力(MPa)"),  # of a spreadsheet in China
        ("cp932", "ヘッド側圧力[MPa]"),  # of a data logger in Japan
        ("cp1252", "Meßgröße"),  # öß alone could be a Chinese character
        ("cp1252", "Überdruckmeßgröße"),
    ],
)
def test_asian_and_western_names_are_read_as_they_were_written(charset, name):
    text = f"t,{name}\n0,1.5\n1,-2.25\n"
    assert column(text.encode(charset), name) == [1.5, -2.25]


@pytest.mark.parametrize(
    ("text", "layout"),
    [
        ("t,x\n0,1234.5\n1,2\n", {}),
        ("t;x\n0;1234.5\n1;2\n", SEMICOLON),
        ("t\tx\n0\t1234.5\n1\t2\n", {"separator": "tab"}),
        ("t x\n  0   1234.5\n1 2\n", {"separator": "whitespace"}),
        ("t;x\n0;1234,5\n1;2\n", GERMAN),
        ("t;x\n0;1.234,5\n1;2\n", {**GERMAN, "thousands": "."}),
        ("t;x\n0;1'234.5\n1;2\n", {**SEMICOLON, "thousands": "'"}),
        ("t;x\n0;1 234,5\n1;2\n", {**GERMAN, "thousands": " "}),
        ('t,x\n0,"1,234.5"\n"1","2"\n', {"thousands": ","}),
        ("t;x\n0;1\u202f234,5\n1;2\n", {**GERMAN, "thousands": " "}),
        ("t;x\n0;1\u00a0234,5\n1;2\n", {**GERMAN, "thousands": " "}),
        ("t;x\n0;1\u2019234.5\n1;2\n", {**SEMICOLON, "thousands": "'"}),
        ("t,x\n0,1.2345e3\n\n1,2\n\n", {}),
        ("# by a logger\n#\nt,x\n0,1234.5\n# pause\n1,2\n", {"comment": "#"}),
        ("Logger 5\n3.5.24, 12:00\n\nt,x\n0,1234.5\n1,2\n", {"preamble": 2}),
        ("t,x\ns,mm\n0,1234.5\n1,2\n", {"units_row": True}),
        ("t;x\n0;1234.5;\n1;2;\n", SEMICOLON),
        ('t,x\n"0,0","1234,5"\n1,"2,0"\n', {"decimal": ","}),
        ("t,x\n,\n0,1234.5\n , \n1,2\n,\n,\n,\n,\n,\n,\n", {}),
        ('t,x\n0,1234.5\n"",""\n1,2\n', {}),
    ],
)
def test_dialects_give_the_same_numbers(text, layout):
    assert column(text, **layout) == [1234.5, 2.0]


def test_a_typographic_minus_is_one():
    assert column("t,x\n0,−1.5\n1,−.5\n") == [-1.5, -0.5]


@pytest.mark.parametrize(
    ("cell", "layout"),
    [
        ("1.234", GERMAN),  # a thousand and some, or one and some?
        ("1.23,5", {**GERMAN, "thousands": "."}),
        ("1.2345,5", {**GERMAN, "thousands": "."}),
        (".234,5", {**GERMAN, "thousands": "."}),
        ("1_0", SEMICOLON),
        ("0x1f", SEMICOLON),
        ("inf", SEMICOLON),
        ("12 mm", SEMICOLON),
    ],
)
def test_a_number_that_could_mean_another_is_refused(cell, layout):
    with pytest.raises(DataError, match=r"a.csv: line 2: column x: "):
        column(f"t;x\n0;{cell}\n", **layout)


def test_lines_are_counted_as_an_editor_does():
    text = '# one\n\nt,x\n0,1\n# five\n"1",2\n2,?\n'
    with pytest.raises(DataError, match=r"line 7: column x: .*'\?'"):
        column(text, comment="#")
    with pytest.raises(DataError, match=r"line 5: .*\b1 columns.*'# five'.*\b2\b"):
        column(text.removeprefix("# one\n\n").replace("t,x", "\n\nt,x"))


def test_a_name_that_stands_twice_is_refused_and_its_number_taken():
    with pytest.raises(DataError, match=r"column 'p' .*\b2\b.*: t, p, p"):
        column("t,p,p\n0,1,2\n", "p")
    assert column("t,p,p\n0,1,2\n", 3) == [2.0]


@pytest.mark.parametrize(
    ("first", "second", "step"),
    [
        ("2024-05-01T23:59:59.750", "2024-05-02T00:00:00.250", 0.5),
        ("2024-05-01 12:00:00,5", "2024-05-01 12:00:00,625", 0.125),
        ("2024-05-01T12:00:00Z", "2024-05-01T14:00:01+02:00", 1.0),
        ("31.5.2024 23:59:59,998", "01.06.2024 00:00:00,002", 0.004),
        ("2024/05/31 23:59:59.998", "2024/6/1 0:00:00.002", 0.004),
        ("31-May-2024 23:59:59.998", "01-Jun-2024 00:00:00.002", 0.004),
        ("0 days 00:00:00", "0 days 00:00:00.004000", 0.004),
    ],
)
def test_date_times_become_seconds(first, second, step):
    table = parse_table(f"t;x\n{first};1\n{second};2\n".encode(), "a.csv", Format(**SEMICOLON))
    times = table.date_times("t")
    assert (times - times[0]) / np.timedelta64(1, "s") == pytest.approx([0, step], abs=1e-6)


def test_a_cell_that_is_no_date_time_is_named_with_its_line():
    table = parse_table(b"t,x\n2024-05-01T12:00:00,1\n12:00,2\n", "a.csv", Format())
    with pytest.raises(DataError, match="line 3: column t: .*'12:00'"):
        table.date_times("t")


@pytest.fixture
def rules():
    columns = {"t_s": "t", "x_m": "x", "p_tp_pa": "p", "f_applied_n": "f"}
    return {
        "name": "others",
        "format": {"units_row": True},
        "columns": {channel: {"column": name} for channel, name in columns.items()},
        "constants": {"p_tr_pa": "0 bar"},
        "series": [
            {"label": "A", "files": "{trial}.csv", "cylinder": {"piston_diameter": "25 mm"}}
        ],
    }


@pytest.fixture
def bring_in(rules, tmp_path, at):
    def bring_in(text="t,x,p,f\nms,mm,psi,kN\n0,0,1,2\n500,20,1,2\n1000,40,1,2\n", name="1.csv"):
        (tmp_path / "logs").mkdir(exist_ok=True)
        (tmp_path / "logs" / name).write_text(text)
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
        import_folder(tmp_path / "logs", tmp_path / "out", tmp_path / "map.yaml", {}, at(0))
        campaign = load_campaign(tmp_path / "out")
        return next(campaign.runs()), campaign

    return bring_in


def test_units_come_from_the_row_under_the_header(bring_in):
    run, _ = bring_in("t,x,p,f\n[ms],(mm),psi, kN\n0,0,1,2\n500,20,1,2\n1000,40,1,2\n")
    assert run.t_s.tolist() == [0, 0.5, 1.0]
    np.testing.assert_allclose(run.x_m, [0, 0.02, 0.04])
    np.testing.assert_allclose(run.p_tp_pa, 6894.757, rtol=1e-6)
    np.testing.assert_allclose(run.f_applied_n, 2000)


def test_units_in_other_spellings_are_those_of_hbench(bring_in):
    run, _ = bring_in("t,x,p,f\nSekunden,mm,bar(g),Newton\n0,0,1,2\n0.5,20,1,2\n1,40,1,2\n")
    np.testing.assert_allclose([run.t_s[-1], run.p_tp_pa[0], run.f_applied_n[0]], [1, 1e5, 2])


@pytest.mark.parametrize(
    ("row", "given", "message"),
    [
        ("ms,mm,psi,digits", {}, "1.csv: column f: .*'digits'"),
        ("ms,mm,N,kN", {}, "1.csv: column p: .*'N'.*p_tp_pa .*Pa"),
        ("ms,mm,bar,N", {"p_tp_pa": "psi"}, "1.csv: column p: .*'bar'.*'psi'"),
        ("ms,mm,Bar,N", {"p_tp_pa": "MPa"}, "1.csv: column p: .*'Bar'.*'MPa'"),
        ("ms,mm,bar,Newton", {"f_applied_n": "kN"}, "1.csv: column f: .*'Newton'.*'kN'"),
        ("ms,Volt,bar,N", {"x_m": "mm"}, "1.csv: column x: .*'Volt'.*'mm'"),
    ],
)
def test_units_that_cannot_be_or_contradict_are_refused(bring_in, rules, row, given, message):
    for channel, unit in given.items():
        rules["columns"][channel]["unit"] = unit
    with pytest.raises(DataError, match=message):
        bring_in(f"t,x,p,f\n{row}\n0,0,1,2\n1,40,1,2\n")


def test_a_scale_converts_a_signal_of_another_quantity(bring_in, rules):
    """A transducer's volts, and a valve's command in percent of 10 V."""
    rules["columns"]["p_tp_pa"] |= {"unit": "bar", "scale": 25}
    rules["columns"]["u_t_v"] = {"column": "y", "unit": "V", "scale": 0.1}
    run, _ = bring_in("t,x,p,f,y\nms,mm,V,kN,%\n0,0,2,2,-35\n500,20,2,2,-35\n1000,40,2,2,-35\n")
    np.testing.assert_allclose(run.p_tp_pa, 50e5)
    np.testing.assert_allclose(run.u_t_v, -3.5)


@pytest.mark.parametrize(
    "given", [{}, {"unit": "V"}, {"unit": "V", "scale": -1}, {"scale": 0.1}, {"unit": "%"}]
)
def test_a_signal_without_unit_or_scale_is_refused_with_what_to_write(bring_in, rules, given):
    rules["columns"]["u_t_v"] = {"column": "y", **given}
    with pytest.raises((ConfigError, DataError)) as caught:
        bring_in("t,x,p,f,y\nms,mm,bar,kN,%\n0,0,2,2,-35\n500,20,2,2,-35\n1000,40,2,2,-35\n")
    said = f"{caught.value.message} {caught.value.hint}"
    assert "'%'" in said and "V" in said and "scale" in said


def test_a_column_without_unit_is_refused_unless_it_is_named_in_si(rules):
    rules["format"] = {}
    with pytest.raises(ConfigError, match="columns.t_s: .*unit"):
        parse_import_map(rules, "map.yaml")
    rules["columns"] = {name: {"column": name} for name in rules["columns"]}
    parse_import_map(rules, "map.yaml")


def test_sign_scale_and_offset_of_a_raw_voltage(bring_in, rules):
    # 0.5 to 4.5 V over 0 to 250 bar: 62.5 bar/V, -31.25 bar at 0 V
    rules["format"] = {}
    for name, unit in {"t_s": "ms", "x_m": "mm", "f_applied_n": "N"}.items():
        rules["columns"][name]["unit"] = unit
    rules["columns"]["x_m"]["scale"] = -1
    rules["columns"]["p_tp_pa"] |= {"unit": "bar", "scale": 62.5, "offset": "-31.25 bar"}
    run, campaign = bring_in("t,x,p,f\n0,0,0.5,0\n500,20,2.5,0\n1000,40,4.5,0\n")
    np.testing.assert_allclose(run.p_tp_pa, [0, 125e5, 250e5], atol=1e-6)
    assert run.x_m[-1] == -0.04 and run.plan.direction == "retract"


def test_a_bridge_voltage_becomes_a_force_by_equation_c6(bring_in, rules):
    cell = {"area": "200 mm^2", "youngs_modulus": "210 GPa", "poisson": 0.3, "gauge_factor": 2.1}
    rules["load_cell"] = {**cell, "bridge_supply": "5 V", "amplifier": 1.0, "level": "0.1 mV"}
    run, _ = bring_in("t,x,p,f\nms,mm,bar,mV\n0,0,1,0.1\n500,20,1,0.2\n1000,40,1,0\n")
    newton_per_volt = 4 * 200e-6 * 210e9 / (2 * 5 * 2.1 * 1.3)  # 6.15 MN/V
    np.testing.assert_allclose(run.f_applied_n, np.array([0, 1, -1]) * 1e-4 * newton_per_volt)


def test_load_and_speed_of_a_run_come_from_the_file_name(bring_in, rules):
    rules["series"][0] |= {"files": "{load}kN_{speed}mm_s_{trial}.csv", "load_unit": "kN"}
    rules["constants"]["p_tr_pa"] = "{load} bar"
    run, _ = bring_in(name="-1.5kN_40mm_s_2.csv")
    plan = run.plan
    assert (plan.f_load_n, plan.v_ref_m_s, plan.trial) == (-1500, 0.04, 2)
    np.testing.assert_allclose(run.p_tr_pa, -1.5e5)


def test_a_dead_load_of_the_name_stands_in_for_a_load_cell(bring_in, rules):
    del rules["columns"]["f_applied_n"]
    rules["constants"]["f_applied_n"] = "{load} N"
    rules["series"][0]["files"] = "{load}_{trial}.csv"
    run, _ = bring_in(name="98.1_1.csv")
    assert run.f_applied_n.tolist() == [98.1] * 3


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"constants": {"p_tr_pa": "{load} bar"}}, "constants.p_tr_pa: {load} "),
        ({"constants": {"p_tr_pa": "{load"}}, "constants.p_tr_pa"),
        ({"format": {"decimal": ",", "thousands": ",", "separator": "tab"}}, "are both ','"),
        ({"format": {"header": False, "units_row": True}}, "format: units_row .*header"),
        ({"resample": "5 s"}, "resample"),
    ],
)
def test_map_that_cannot_work_is_refused(rules, change, message):
    with pytest.raises(ConfigError, match=message):
        parse_import_map({**rules, **change}, "map.yaml")


@pytest.mark.parametrize(
    ("text", "layout", "line"),
    [
        ("Bench 2\n\nt,x,p,f\n0,1,2,3\n1,2,3,4\n", {}, 3),
        ("Bench 2\nt;x;p;f\ns;mm;bar;N\n0,5;1;2;3\n1;2;3;4\n",
         {"separator": "semicolon", "decimal": ",", "units_row": True}, 2),
        ('"Bench 2"\nt,x,p,f\n0,1,2,3\n', {}, 2),
    ],
)  # fmt: skip
def test_a_title_above_the_header_gives_the_headers_line(text, layout, line):
    with pytest.raises(DataError, match="found . columns") as caught:
        parse_table(text.encode(), "a.csv", Format(**layout))
    assert caught.value.hint.startswith(f"Line {line} looks like the header: write 'preamble: ")


@pytest.mark.parametrize("text", ["a\n1,2\n3,4\n", "a,b\n1,2\n3,4,5\n", "a\nb,c\nd,e\n"])
def test_without_a_row_that_looks_like_a_header_the_keys_of_the_layout_are_listed(text):
    with pytest.raises(DataError, match="found . columns") as caught:
        parse_table(text.encode(), "a.csv", Format())
    assert caught.value.hint.startswith("Set 'format' in the map")


def test_a_missing_column_is_told_with_those_that_are_there(bring_in, rules):
    rules["columns"]["f_applied_n"]["column"] = "force"
    with pytest.raises(DataError, match="1.csv: .*'force'.*: t, x, p, f") as told:
        bring_in()
    assert "preamble" in told.value.hint


def test_a_decimal_comma_that_the_map_does_not_tell_is_explained():
    with pytest.raises(DataError, match="line 2: column x: .*'0,5'") as caught:
        column(b"t;x\n1;0,5\n", **SEMICOLON)
    assert "format.decimal" in caught.value.hint


def test_other_peoples_files_without_a_map_are_refused_with_what_to_do(tmp_path, at):
    (tmp_path / "log.csv").write_text("t,x\n0,1\n")
    with pytest.raises(DataError, match=r"runs\.csv, runs\.parquet, campaign\.mat") as caught:
        import_folder(tmp_path, tmp_path / "out", None, {}, at(0))
    assert "--map" in caught.value.hint


ROWS = "t,x,p,f\nms,mm,psi,kN\n0,0,1,2\n500,20,1,2\n1000,40,1,2\n"


@pytest.mark.parametrize("end", ["1500,60", "1500", "--- end ---\n", "End of log\nby bench 3\n"])
def test_short_lines_at_the_end_are_left_out_with_a_note(bring_in, tmp_path, at, end):
    run, _ = bring_in(ROWS + end)
    assert run.t_s.tolist() == [0, 0.5, 1.0]
    again = import_folder(tmp_path / "logs", tmp_path / "again", tmp_path / "map.yaml", {}, at(0))
    text = "rows left out: short or without a position (the first is line 6)"
    assert any(text in note for note in again.notes)


@pytest.mark.parametrize("end", ["5,6\n" * 6, "5,6\n1500,60,1,2\n", "1500,60,1,2,3\n"])
def test_other_lines_of_another_width_are_refused(bring_in, end):
    with pytest.raises(DataError, match=r"1.csv: line 6: found [25] columns .*; expected 4"):
        bring_in(ROWS + end)


@pytest.mark.parametrize("charset", ["utf-8", "utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("end", ["\n", "\r\n", ""])
def test_a_missing_last_newline_is_reported_in_any_character_set(tmp_path, charset, end):
    (tmp_path / "a.csv").write_bytes(f"t;Öl\r\n0;1{end}".encode(charset))
    assert describe_source(tmp_path, "a.csv").is_truncated == (end == "")


@pytest.mark.parametrize(
    ("unit", "newton"), [("daN", 10.0), ("tf", 9806.65), ("kgf", 9.80665), ("N", None)]
)
def test_a_unit_in_brackets_may_not_contradict_the_map(bring_in, rules, unit, newton):
    rules["format"] = {}
    for channel, stated in {"t_s": "s", "x_m": "mm", "p_tp_pa": "bar", "f_applied_n": unit}.items():
        rules["columns"][channel]["unit"] = stated
    column = f"f [{unit if newton else 'daN'}]"
    rules["columns"]["f_applied_n"]["column"] = column
    text = f"t,x,p,{column}\n0,0,1,2\n0.5,20,1,2\n1,40,1,2\n"
    if newton:
        assert bring_in(text)[0].f_applied_n.tolist() == pytest.approx([2 * newton] * 3)
    else:
        with pytest.raises(DataError, match=r"column f \[daN\]: unit in the file .*'daN'.*'N'"):
            bring_in(text)


LABVIEW = """LabVIEW Measurement\t
Separator\tTab
Date\t2024/05/03
***End_of_Header***\t

Channels\t2\t\t
Samples\t4\t4\t
Date\t2024/05/03\t2024/05/03\t
Time\t09:12:31\t09:12:31\t
Y_Unit_Label\tmm\tN\t
X_Dimension\tTime\tTime\t
X0\t0\t0\t
Delta_X\t0.010000\t0.010000\t
***End_of_Header***\t\t\t
X_Value\tx\tF\tComment
0.000000\t10.5\t2001
0.010000\t11.0\t2002
0.020000\t11.5\t2003
0.030000\t12.0\t2004
"""


def test_a_labview_file_is_understood_though_its_rows_leave_the_comment_out():
    dialect = text_dialect(LABVIEW)
    assert dialect.names == ("X_Value", "x", "F")
    table = parse_table(LABVIEW.encode(), "a.lvm", dialect.layout)
    assert table.names == dialect.names
    assert table.numbers("F").tolist() == [2001, 2002, 2003, 2004]
    assert table.lines.tolist() == [16, 17, 18, 19]


def test_units_come_from_a_labview_files_header():
    table = parse_table(LABVIEW.encode(), "a.lvm", text_dialect(LABVIEW).layout)
    assert [table.unit(name) for name in table.names] == ["s", "mm", "N"]
    unlabelled = LABVIEW.replace("Y_Unit_Label\tmm\tN", "Y_Unit_Label\t\t")
    table = parse_table(unlabelled.encode(), "a.lvm", text_dialect(LABVIEW).layout)
    assert table.unit("F") is None


def test_times_come_from_a_labview_files_header_where_no_column_has_them():
    text = LABVIEW.replace("Separator\tTab", "Separator\tTab\nX_Columns\tNo")
    text = text.replace("X0\t0\t0", "X0\t5.0E-1\t5.0E-1")
    text = re.sub(r"^0\.0\d+", "", text, flags=re.MULTILINE)
    table = parse_table(text.encode(), "a.lvm", text_dialect(text).layout)
    for name in ("x", "F"):
        np.testing.assert_allclose(table.own_times(name), [0.5, 0.51, 0.52, 0.53])
    assert table.numbers("F").tolist() == [2001, 2002, 2003, 2004]
    table = parse_table(LABVIEW.encode(), "a.lvm", text_dialect(LABVIEW).layout)
    assert table.own_times("x") is None


def test_a_comment_in_a_row_is_not_lost_unnoticed():
    text = LABVIEW.replace("11.0\t2002", "11.0\t2002\tstart")
    with pytest.raises(DataError, match="line 16: found 3 columns .*; expected 4"):
        parse_table(text.encode(), "a.lvm", text_dialect(LABVIEW).layout)


@pytest.mark.parametrize(("pack", "name"), [(gzip.compress, "gzip"), (lzma.compress, "xz")])
def test_a_compressed_text_is_refused_with_what_to_do(tmp_path, pack, name):
    (tmp_path / "a.csv.gz").write_bytes(pack(b"t,x\n0,1\n1,2\n"))
    with pytest.raises(DataError, match=rf"a.csv.gz: is compressed \({name}\)") as caught:
        with open_foreign(tmp_path / "a.csv.gz"):
            pass
    assert "Unpack it" in caught.value.hint


def test_a_decimal_comma_between_commas_needs_quotes():
    with pytest.raises(DataError, match=r"a\.csv: decimal ',' and separator comma are ambiguous"):
        column("t,x\n0,5,1,5\n", 1, decimal=",", header=False)


def test_a_header_of_blank_names_is_no_blank_row():
    assert column(",\n0,1\n1,2\n", 2) == [1.0, 2.0]


def test_quoted_decimal_commas_are_suggested():
    dialect = text_dialect('"t","x"\n"0,000","1,250"\n"0,125","2,500"\n')
    assert (dialect.layout.separator, dialect.layout.decimal) == ("comma", ",")
    assert dialect.layout.thousands is None


def test_blank_cells_below_the_header_are_no_header():
    dialect = text_dialect("t,x,F\n,,\n0,1,2\n1,2,3\n")
    assert dialect.names == ("t", "x", "F") and dialect.layout == Format()


@pytest.mark.parametrize("first", [0, 1])
def test_the_numbers_of_the_columns_are_a_header(first):
    header = ",".join(str(first + k) for k in range(4))
    dialect = text_dialect(f"{header}\n0,12.5,3,4\n0.01,12.6,3,4\n")
    assert dialect.layout.header and dialect.names == tuple(header.split(","))
    dialect = text_dialect("0,12.5,3,4\n0.01,12.6,3,4\n0.02,12.7,3,4\n")
    assert not dialect.layout.header


@pytest.mark.parametrize(
    ("cell", "hint"),
    [
        ("#N/A", "Leave the cell empty"),
        ("-", "Leave the cell empty"),
        ("+OVL", "Leave the cell empty"),
        ("Overflow", "Leave the cell empty"),
        ("*****", "Leave the cell empty"),
        ("2024-05-01T12:00:00", "unit: date-time"),
        ("0.01 sec", "Remove 'sec' behind each number"),
        ("12.5bar", "Remove 'bar' behind each number"),
        ("12 apples", None),
        ("twelve", None),
    ],
)
def test_the_hint_fits_the_cell_that_is_no_number(cell, hint):
    with pytest.raises(DataError, match=r"a.csv: line 3: column x: ") as error:
        column(f"t,x\n0,1\n1,{cell}\n")
    assert hint in error.value.hint if hint else not error.value.hint


@pytest.mark.parametrize("cell", ["", "nan"])
def test_a_cell_that_each_row_needs_is_not_to_be_left_empty(cell):
    with pytest.raises(DataError, match=r"a.csv: line 3: column t: ") as error:
        column(f"x,t\n0,1\n1,{cell}\n", name="t")
    assert error.value.hint == "Remove the rows without it: each row needs a value in this column."


@pytest.mark.parametrize(
    ("cell", "decimal", "hint"),
    [
        ("1.000,488", ",", 'format.thousands: "."'),
        ("1'000.488", ".", """format.thousands: "'"."""),
        ("-1 234 567", ".", 'format.thousands: " "'),
        ("1.000,488", ".", "decimal comma"),
        ("0,5", ".", "decimal comma"),
        ("1,000", ".", "whether the comma is the decimal mark, format.decimal, or the mark of"),
        ("1,000.488", ",", ""),
        ("1,5,5", ",", ""),
    ],
)
def test_the_hint_names_the_mark_of_the_map_that_a_number_needs(cell, decimal, hint):
    with pytest.raises(DataError, match=r"line 3: column x: ") as error:
        column(f"t;x\n0;1\n1;{cell}\n", separator="semicolon", decimal=decimal)
    assert hint in error.value.hint if hint else not error.value.hint


def test_a_quote_that_is_not_closed_is_refused_with_its_line():
    """The rows after it would be one cell, and left out as a short row at the end."""
    text = "t,x\n0,1\n1,2\n" + '2,"3\n' + "3,4\n" * 9
    with pytest.raises(DataError, match=r"a\.csv: line 4: a quote in '2,\"3' is not closed"):
        column(text)
    assert column('t,x,note\n0,1,"two\nlines"\n1,2,"5"" pipe"\n') == [1.0, 2.0]


@pytest.mark.parametrize(
    ("rows", "left"),
    [
        (["0,1.25", "1,1.75", "2,1.50", "3,1."], 3),  # of 1.xx
        (["0,1.25", "1,1.75", "2,1.50", "3,1.25"], 4),
        (["0,1.25", "1,2", "2,1.50", "3,3"], 4),  # others are as short
    ],
)
def test_a_last_cell_without_newline_that_is_shorter_than_all_is_left_out(rows, left):
    text = "t,x\n" + "\n".join(rows)
    assert len(column(text)) == left
    assert len(column(text + "\n")) == 4


@pytest.mark.parametrize(
    "data",
    [
        b"TDSm\x0e\0\0\0" + bytes(range(24)) * 9,
        b"MATLAB 5.0 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\1IM" + b"\x0e\0\0\0\x38" * 40,
        b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\2\0\0\0\1\0\x08\2" + bytes(range(40)),
    ],
)
def test_a_binary_file_is_named_as_one(data):
    with pytest.raises(DataError, match=r"a\.csv: is not a text file"):
        column(data)
    assert column(b"t,x\n" + b"0,1\n" * 60 + bytes(4096)) == [1.0] * 60  # a lost cluster


def test_a_workbook_named_as_a_text_is_named_as_one(tmp_path):
    import openpyxl

    openpyxl.Workbook().save(tmp_path / "a.xlsx")
    (tmp_path / "a.xlsx").rename(tmp_path / "a.csv")
    with pytest.raises(DataError, match="Office document"), open_foreign(tmp_path / "a.csv"):
        pass
