"""Dialects, columns and file names, as a suggested map understands them."""

from datetime import datetime, time

import pytest

from hbench.store.formats.date_times import parse_date_time
from hbench.store.suggesting.dialect import is_date_time, text_dialect
from hbench.store.suggesting.file_names import joined_holds, name_patterns
from hbench.store.suggesting.quantities import meaning
from hbench.store.suggesting.units import split_unit
from hbench.units import unit_in


def table(head, separator, *cells):
    return head + "".join(separator.join(row) + "\n" for row in zip(*cells, strict=True))


DIALECTS = {
    "german": (
        table("Prüfstand 2\nZeit;Weg\nms;mm\n", ";", ["0,0", "4,0"], ["1.012,5", "13,25"]),
        {"separator": "semicolon", "preamble": 1, "units_row": True, "decimal": ",",
         "thousands": "."},
        ("Zeit", "Weg"),
    ),
    "english": (
        table("Time [s],Force (kN)\n", ",", ["0.0", "0.1"], ["1.5", "-2e-3"]),
        {},
        ("Time [s]", "Force (kN)"),
    ),
    "no header": (
        table("", "\t", ["0.000", "10.000"], ["3.5", "3.6"]),
        {"separator": "tab", "header": False},
        (),
    ),
    "names in a comment": (
        table("# bench 5\n# t x p\n", "  ", ["0.00", "1.00"], ["1", "2"], ["3", "4"]),
        {"separator": "whitespace", "header": False, "comment": "#"},
        ("t", "x", "p"),
    ),
    "names between blanks": (
        table("Time (s)   Load cell   x\n", " ", ["0", "1"], ["1", "2"], ["3", "4"]),
        {"separator": "whitespace", "header": False, "preamble": 1},
        ("Time (s)", "Load cell", "x"),
    ),
    "keys and values above": (
        table("Rate;100\nBy;Meier\n\nt;F;\ns;N;\n", ";", ["0,1", "0,2"], ["1,5", "2,5"], ["", ""]),
        {"separator": "semicolon", "preamble": 3, "units_row": True, "decimal": ","},
        ("t", "F"),
    ),
    "two header lines": (
        table("Channel 1;Channel 2\nWeg;Kraft\nmm;kN\n", ";", ["1,5", "1,6"], ["2,5", "2,6"]),
        {"separator": "semicolon", "preamble": 1, "units_row": True, "decimal": ","},
        ("Weg", "Kraft"),
    ),
    "a row between units and data that begins as a comment": (
        table("Bench\nA\nB\nC\nZeit;Weg\ns;mm\n# 200 Hz;# 200 Hz\n", ";",
              ["0,1", "0,2"], ["1,5", "1,6"]),
        {"separator": "semicolon", "preamble": 4, "units_row": True, "skip_rows": 1,
         "decimal": ","},
        ("Zeit", "Weg"),
    ),
    "row between units and data": (
        table("t,x\ns,mm\nraw,scaled\n", ",", ["0", "1"], ["2", "3"]),
        {"units_row": True, "skip_rows": 1},
        ("t", "x"),
    ),
    "date-times and a text": (
        table("When\tx\tstate\n", "\t", ["2024-05-01 12:00:00.25", "2024-05-01 12:00:00.50"],
              ["1,5", "1,6"], ["OK", "OK"]),
        {"separator": "tab", "decimal": ","},
        ("When", "x", "state"),
    ),
    "swiss": (
        table("t;F\n", ";", ["0.1", "0.2"], ["1'234.5", "12.5"]),
        {"separator": "semicolon", "thousands": "'"},
        ("t", "F"),
    ),
    "quoted": (
        table('"t","F, axial"\n', ",", ["0.1", "0.2"], ['"1,234.5"', "12.5"]),
        {"thousands": ","},
        ("t", "F, axial"),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", DIALECTS)
def test_the_dialect_of_a_text_is_found(name):
    text, layout, names = DIALECTS[name]
    found = text_dialect(text)
    assert found.layout.model_dump(exclude_defaults=True) == layout
    assert found.names == names


@pytest.mark.parametrize("text", ["", "one\n", "A text, with 3 words.\nAnd 4; more\n", "1\n2\n3\n"])
def test_a_text_without_columns_of_numbers_has_no_dialect(text):
    assert text_dialect(text) is None


MEANINGS = {
    "t_s": ("Zeit", "Time [s]", "t_ms", "data.t", "elapsed time", "Zeitstempel"),
    "x_m": (
        "Weg",
        "Position (mm)",
        "x / mm",
        "LVDT_V",
        "Main.fActPos",
        "Kolbenweg",
        "stroke_mm",
        "Cylinder position (in)",
    ),
    "v_m_s": (
        "v_mm_s",
        "ActVelo",
        "Geschwindigkeit in mm/s",
        "JibVelocity",
        "piston speed",
        "v_ist",
    ),
    "v_ref_m_s": ("v_soll", "JibXDotRef", "speed setpoint", "Sollgeschwindigkeit"),
    "p_tp_pa": (
        "p_A [bar]",
        "Druck A",
        "MainPaCyl",
        "p1",
        "Kolbenseitendruck",
        "Cap pressure",
        "p_Kolben CH 2",
        "P1_V",
        "Main.fPressA",
    ),
    "p_tr_pa": (
        "pB",
        "Druck Ringseite [bar]",
        "P_b",
        "Rod end pressure (psi)",
        "p2_bar",
        "p_Stange CH 1",
    ),
    "p_s_pa": ("Ps", "Systemdruck", "supply pressure", "p_sys"),
    "f_applied_n": (
        "F_kN",
        "Kraft [kN]",
        "Main.fForce",
        "LC_V",
        "Load cell",
        "Kraftmessdose",
        "Druckkraft",
        "Load",
    ),
    "u_t_v": ("u", "valve command", "Ventilspannung"),
    "temp_tank_k": ("Temp_Oil", "T_oil [°C]", "Öltemperatur", "Tank temperature (degC)"),
    "temp_port_k": ("T_Port_A (°C)", "Temperatur Anschluss A"),
    "temp_seal_k": ("seal temp", "Temperatur Dichtung [°C]"),
    "": (
        "T_amb [°C]",
        "Oil temp setpoint",
        "oil_pressure",
        "x_ref",
        "FlowA",
        "Index",
        "Joystick",
        "Untitled",
        "M(:,1)",
        "error x",
    ),
}


@pytest.mark.parametrize("channel", MEANINGS)
def test_names_in_english_and_german_mean_channels(channel):
    assert {name: meaning(name).channel for name in MEANINGS[channel]} == dict.fromkeys(
        MEANINGS[channel], channel
    )


def test_a_unit_of_another_quantity_contradicts_the_name():
    assert meaning("s").quantity == meaning("s", "mm").quantity == "position"
    assert meaning("p", "mm").quantity == "position"
    assert meaning("channel 4", "bar").quantity == "pressure"


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("[kN]", "kN"),
        ("sec", "s"),
        ("bar(g)", "bar"),
        ("mm/sec", "mm/s"),
        ("°C", "degC"),
        ("[℃]", "degC"),
        ("μs", "us"),
        ("㎜/s", "mm/s"),
        ("kgf/cm²", "kgf/cm^2"),
        ("-", None),
        ("pa", "Pa"),
        ("pA", None),  # the pressure at port A
        ("PA", None),
        ("ns", "ns"),
    ],
)
def test_units_are_understood_in_usual_spellings(text, unit):
    assert unit_in(text) == unit


@pytest.mark.parametrize(
    "name, parts",
    [
        ("F/kgf", ("F", "kgf")),
        ("p_A/MPa", ("p_A", "MPa")),
        ("F / kN", ("F", "kN")),
        ("Messung/s", ("Messung/s", None)),  # the channel s of a group
        ("data/p", ("data/p", None)),
    ],
)
def test_a_unit_may_follow_its_symbol_behind_a_slash(name, parts):
    assert split_unit(name) == parts


NAMES = {
    "units": (
        [f"NBR_{v}mm_s_{f}N_{k}.csv" for v in (20, 50) for f in (-500, 500) for k in (1, 2)],
        {"NBR_{speed}mm_s_{load}N_{trial}.csv": "NBR"},
    ),
    "a leading trial": (
        [f"rerun/{k}_O-ring257_{p}bar.csv" for k in (1, 2) for p in (1, 3)],
        {"rerun/{trial}_O-ring257_{pressure}bar.csv": "O-ring257"},
    ),
    "words": (
        [f"v{v}_F{f}_{k}.txt" for v in (10, 20) for f in (0, 500) for k in (1, 2)],
        {"v{speed}_F{load}_{trial}.txt": ""},
    ),
    "specimens": (
        [f"cyl{c}_test_{k}.csv" for c in (12, 13) for k in (1, 2)],
        {"cyl12_test_{trial}.csv": "cyl12", "cyl13_test_{trial}.csv": "cyl13"},
    ),
    "dates": (
        ["F_20240501_123011_50mms.csv", "F_20240502_093512_100mms.csv"],
        {"F_*_{speed}mms.csv": "F"},
    ),
    "one file": (["run_1.mat"], {"run_{trial}.mat": ""}),
    "a single date": (["JibSineTest_230425.csv"], {"JibSineTest_230425.csv": "JibSineTest 230425"}),
    "folders": (["a/x.csv", "b/x.csv"], {"a/x.csv": "a x", "b/x.csv": "b x"}),
    "factors": (
        [
            f"MR_{i}A_{t}C_{v}mms_{k}.csv"
            for i in ("0", "0,5")
            for t in (20, 60)
            for v in (20, 50)
            for k in (1, 2)
        ],
        {"MR_{current}A_{temperature}C_{speed}mms_{trial}.csv": "MR"},
    ),
    "words of factors": (
        [f"temp{t}_seal_{k}.csv" for t in (20, 40, 60) for k in (1, 2)],
        {"temp{temperature}_seal_{trial}.csv": "seal"},
    ),
    "one temperature": (["a_20C_1.csv", "a_20C_2.csv"], {"a_20C_{trial}.csv": "a 20C"}),
    "inches and pounds": (
        [f"{f}lb_{v}ips_{k}.csv" for f in (100, 400) for v in ("0.5", "2") for k in (1, 2)],
        {"{load}lb_{speed}ips_{trial}.csv": ""},
    ),
    "a rotary actuator": (
        [f"{m}Nm_{w}deg_s_{d}.csv" for m in (0, 20) for w in (5, 40) for d in ("cw", "ccw")],
        {"{load}Nm_{speed}deg_s_*.csv": ""},
    ),
    "amplitude and frequency of a motion": (
        [f"tri_A{a}mm_f{f}Hz.txt" for a in (20, 40) for f in ("0.1", "1")],
        {"tri_A*mm_f*Hz.txt": "tri"},
    ),
    "a length": (
        [f"gap{a}mm_{k}.txt" for a in (2, 4) for k in (1, 2)],
        {"gap{length}mm_{trial}.txt": "gap"},
    ),
    "a frequency behind the letter of a force": (
        [f"f{f}Hz_{k}.txt" for f in (1, 2) for k in (1, 2)],
        {"f{frequency}Hz_{trial}.txt": ""},
    ),
    "both directions": (
        [f"{v}mms_{d}_{k}.csv" for v in (20, 50) for d in ("up", "dn") for k in (1, 2)],
        {"{speed}mms_*_{trial}.csv": ""},
    ),
    "a single direction": (["up_1.csv", "up_2.csv"], {"up_{trial}.csv": "up"}),
    "a direction's word that has two opposites": (
        [f"{d}_{k}.csv" for d in ("up", "dn", "down") for k in (1, 2)],
        {f"{d}_{{trial}}.csv": d for d in ("up", "dn", "down")},
    ),
    "braces": (["x{y}.csv"], {}),
}


@pytest.mark.parametrize("case", NAMES)
def test_numbers_in_file_names_become_fields(case):
    names, files = NAMES[case]
    assert {pattern.files: pattern.label for pattern in name_patterns(names)} == files


def test_patterns_know_the_values_in_their_names():
    (pattern,) = name_patterns(["a_2,5kN_0.5MPa.csv", "a_-3kN_1MPa.csv"])
    assert pattern.values("a_-3kN_1MPa.csv") == {"load": -3000.0, "pressure": 1e6}


def patterns_of(*names):
    return sorted(pattern.files for pattern in name_patterns(names))


def test_a_speed_with_and_without_a_minus_is_one_field():
    assert patterns_of(*(f"run_{v}mm_s_{t}.csv" for v in (-50, -5, 5, 50) for t in (1, 2))) == [
        "run_{speed}mm_s_{trial}.csv"
    ]
    assert patterns_of(*(f"v{v}_F{f}.csv" for v in (-50, -5, 5, 50) for f in (100, 200))) == [
        "v{speed}_F{load}.csv"
    ]


def test_numbers_that_count_the_files_from_zero_are_any_characters():
    assert patterns_of(*(f"LOG{n:04d}.CSV" for n in range(12))) == ["LOG*.CSV"]
    assert patterns_of(*(f"LOG{n:04d}.CSV" for n in range(1, 12))) == ["LOG{trial}.CSV"]


def test_an_empty_column_with_a_name_belongs_to_the_header():
    dialect = text_dialect(table("t,x,Note,Spare\n", ",", ["0", "1"], ["2", "3"], "ab", ["", ""]))
    assert dialect.names[:3] == ("t", "x", "Note")
    assert dialect.layout.header


@pytest.mark.parametrize("text", ["9:30:15,250", "09:30:15.25", "2024-05-01 09:30:15.25"])
def test_a_time_of_day_is_a_date_time(text):
    assert is_date_time(text)
    assert parse_date_time(text).time() == time(9, 30, 15, 250_000)


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("12/24/2024 6:30:00.5 PM", datetime(2024, 12, 24, 18, 30, 0, 500_000)),
        ("5/3/2024, 12:00:01 a.m.", datetime(2024, 5, 3, 0, 0, 1)),
        ("12:00:01 pm", datetime(1970, 1, 1, 12, 0, 1)),
    ],
)
def test_a_12_hour_clock_is_read_with_the_month_first(text, meant):
    assert is_date_time(text)
    assert parse_date_time(text) == meant


@pytest.mark.parametrize(
    "text", ["9:30", "25:00:00", "0:00:61", "1:2:3", "13:00:00 PM", "0:01:02 AM"]
)
def test_what_is_no_time_of_day_is_no_date_time(text):
    assert not is_date_time(text)


def test_holds_named_by_two_pressures_are_one_series():
    """Leaks are fitted to the holds of a series: one for each second pressure could not be."""
    names = [f"hold_{a}bar_{a + 40}bar_{trial}.csv" for a in (20, 40, 60) for trial in (1, 2)]
    names += [f"hold_20bar_80bar_{trial}.csv" for trial in (1, 2)]
    patterns = name_patterns(sorted(names))
    assert len(patterns) == 3  # of other kinds of runs, the second one may be the back pressure
    (one,) = joined_holds(patterns, sorted(names))
    assert one.files == "hold_{pressure}bar_*bar_{trial}.csv" and one.label == "hold"
    assert sorted(one.names) == sorted(names)
    others = name_patterns(["a_1bar.csv", "b_1bar.csv"])
    assert [p.files for p in joined_holds(others, ["a_1bar.csv", "b_1bar.csv"])] == [
        p.files for p in others
    ]


def test_numbers_that_are_speeds_of_every_file_count_trials():
    """Files with several speeds each: 1 and 2 cm/s are in both, and distinguish nothing."""
    names = ["axis_0N_1.csv", "axis_0N_2.csv"]
    several = dict.fromkeys(names, (0.005, 0.01, 0.02, 0.04))
    (pattern,) = name_patterns(names, several)
    assert pattern.files == "axis_{load}N_{trial}.csv"
    single = {"axis_0N_1.csv": (0.01,), "axis_0N_2.csv": (0.02,)}
    (pattern,) = name_patterns(names, single)
    assert (pattern.files, pattern.units["speed"]) == ("axis_{load}N_{speed}.csv", "cm/s")
