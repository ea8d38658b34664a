"""Logs in binary formats and sheets, each written by another program than the reader under test."""

import subprocess
import sys
from dataclasses import replace
from datetime import datetime, time, timedelta

import numpy as np
import pytest

from hbench.errors import ConfigError, DataError
from hbench.store.formats import opening

# Position at 100 Hz, pressure at 1 kHz from 0.05 s later, force at 20 Hz.
T = np.arange(0, 3, 0.01)
TP = 0.05 + np.arange(0, 3, 0.001)
TF = np.arange(0, 3, 0.05)
X, P, F = 40 * T + 1, 60 + 5 * TP, 2 - TF  # mm, bar, kN


def write_tdms(path):
    from nptdms import ChannelObject, TdmsWriter

    start = np.datetime64("2024-05-01T12:00:00.25")

    def channel(group, name, values, step, unit, offset=0.0, later=0):
        about = {"wf_increment": step, "wf_start_offset": offset, "unit_string": unit}
        about["wf_start_time"] = start + np.timedelta64(later, "ms")
        return ChannelObject(group, name, values, properties=about)

    with TdmsWriter(path) as writer:
        writer.write_segment(
            [
                channel("slow", "x", X, 0.01, "mm"),
                channel("fast", "p", P, 0.001, "bar", offset=0.02, later=30),
                channel("slow", "f", F[:20], 0.05, "kN"),
                ChannelObject("notes", "f", np.array(["by", "hand"])),
            ]
        )
        writer.write_segment([channel("slow", "f", F[20:], 0.05, "kN")])


def write_mdf(path, version):
    from asammdf import MDF, Signal

    with MDF(version=version) as mdf:
        mdf.append([Signal(P, TP, name="p", unit="bar"), Signal(P, TP, name="f", unit="A")])
        mdf.append([Signal(X, T, name="x", unit="mm")])
        mdf.append([Signal(F, TF, name="f", unit="kN")])
        mdf.save(path, overwrite=True)


FORMATS = {
    "a.tdms": (write_tdms, "slow/f"),
    "a.mf4": (lambda path: write_mdf(path, "4.10"), "group 3/f"),
    "a.mdf": (lambda path: write_mdf(path, "3.30"), "group 3/f"),
}


@pytest.fixture
def bring_in(rules, import_by):
    def bring_in(file_name, force="f"):
        rules["series"][0]["files"] = file_name
        rules["columns"] = {
            "x_m": {"column": "x", "unit": "mm"},
            "p_tp_pa": {"column": "p", "unit": "bar"},
            "f_applied_n": {"column": force, "unit": "kN"},
        } | rules["columns"]
        (run,), notes = import_by(rules)
        return run, notes

    return bring_in


@pytest.mark.parametrize("name", FORMATS)
def test_channels_of_three_rates_come_to_the_times_of_the_position(bring_in, tmp_path, name):
    write, force = FORMATS[name]
    write(tmp_path / name)
    run, notes = bring_in(name, force)
    common = (T > 0.055) & (T < 2.951)  # the pressure begins later, the force ends earlier
    np.testing.assert_allclose(run.t_s, T[common], atol=1e-9)
    np.testing.assert_allclose(run.x_m, X[common] / 1e3, rtol=1e-12)
    np.testing.assert_allclose(run.p_tp_pa, (60 + 5 * run.t_s) * 1e5)
    np.testing.assert_allclose(run.f_applied_n, (2 - run.t_s) * 1e3, atol=1e-6)
    assert "1000 Hz" in notes[0] and "20 Hz" in notes[0]


def test_a_channel_without_a_start_beside_others_that_state_one_has_no_times(bring_in, tmp_path):
    """It would count from the first of the others, and friction would be that of other times."""
    from nptdms import ChannelObject, TdmsWriter

    start = {"wf_start_time": np.datetime64("2024-05-01T12:00:02")}
    columns = {"x": (X, start), "p": (P[::10], {}), "f": (F, start)}
    with TdmsWriter(tmp_path / "a.tdms") as writer:
        for name, (values, about) in columns.items():
            properties = about | {"wf_increment": 0.05 if name == "f" else 0.01}
            writer.write_segment([ChannelObject("log", name, values, properties=properties)])
    with pytest.raises(DataError, match="column p: the file states no times for it"):
        bring_in("a.tdms")


@pytest.mark.parametrize("name", FORMATS)
def test_a_channel_that_is_not_there_is_reported_with_those_that_are(bring_in, tmp_path, name):
    write, force = FORMATS[name]
    write(tmp_path / name)
    with pytest.raises(DataError, match=rf"no column 'f'; .*\b[xp] \(3\d+\).*{force} \(60\)"):
        bring_in(name)


@pytest.mark.parametrize("name", FORMATS)
def test_a_unit_that_contradicts_that_of_the_file_is_refused(bring_in, rules, tmp_path, name):
    write, force = FORMATS[name]
    write(tmp_path / name)
    rules["columns"] = {"p_tp_pa": {"column": "p", "unit": "psi"}}
    with pytest.raises(DataError, match=f"{name}: column p: .*'bar'.*'psi'"):
        bring_in(name, force)


@pytest.mark.parametrize("name", [*FORMATS, "a.xlsx"])
def test_a_broken_file_is_refused(bring_in, tmp_path, name):
    (tmp_path / name).write_bytes(b"no table at all" * 40)
    with pytest.raises(DataError, match=name):
        bring_in(name)


@pytest.mark.parametrize("row", [row for row in opening.FORMATS if row.package])
def test_a_missing_package_is_reported_with_the_extra_that_contains_it(
    bring_in, tmp_path, monkeypatch, row
):
    for module in [name for name in sys.modules if name.partition(".")[0] == row.package]:
        monkeypatch.setitem(sys.modules, module, None)
    monkeypatch.setitem(sys.modules, row.package, None)
    name = f"a{row.endings[0]}"
    (tmp_path / name).write_bytes(b"\x89HDF\r\n\x1a\n")
    with pytest.raises(ConfigError, match=f"package {row.package}") as caught:
        bring_in(name)
    assert f"hbench[{row.extra}]" in caught.value.hint


def test_the_command_line_starts_without_the_optional_packages():
    program = (
        "import sys; import hbench.cli.main, hbench.store.importing.importer\nprint(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert "numpy" in done.stdout.split(), done.stderr
    assert not {row.package for row in opening.FORMATS} & set(done.stdout.split())


def test_a_tdms_channel_without_waveform_properties_needs_t_s(bring_in, rules, tmp_path):
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(tmp_path / "a.tdms") as writer:
        values = {"t": T, "x": X, "p": 0 * T, "f": 0 * T}
        writer.write_segment([ChannelObject("g", name, y) for name, y in values.items()])
    with pytest.raises(DataError, match="no times") as caught:
        bring_in("a.tdms")
    assert "t_s" in caught.value.hint
    rules["columns"]["t_s"] = {"column": "t", "unit": "s"}
    run, _ = bring_in("a.tdms")
    np.testing.assert_array_equal(run.t_s, T)


def test_invalid_samples_of_mdf_are_unknown(bring_in, tmp_path):
    from asammdf import MDF, Signal

    invalid = (T > 1.0) & (T < 1.015)
    with MDF(version="4.10") as mdf:
        channels = {"x": X, "p": 0 * T, "f": 0 * T}
        signals = [Signal(y, T, name=name) for name, y in channels.items()]
        signals[1] = Signal(0 * T, T, name="p", invalidation_bits=invalid)
        mdf.append(signals)
        mdf.save(tmp_path / "a.mf4")
    run, _ = bring_in("a.mf4")
    np.testing.assert_array_equal(np.isnan(run.p_tp_pa), invalid)


@pytest.mark.parametrize(
    ("formula", "factor"),
    [
        ("2.5*X1+1e1", 2.5),
        ("-(X1/4)^1", -0.25),
        ("__import__('os').mkdir('made')", None),
        ("X1.__class__", None),
        ("(lambda:X1)()", None),
    ],
)
def test_the_formula_of_an_mdf_channel_is_arithmetic_or_refused(
    bring_in, tmp_path, monkeypatch, formula, factor
):
    from asammdf import MDF, Signal

    monkeypatch.chdir(tmp_path)
    with MDF(version="4.10") as mdf:
        signals = [Signal(y, T, name=name) for name, y in {"x": X, "f": 0 * T}.items()]
        mdf.append([*signals, Signal(8 + T, T, name="p", conversion={"formula": formula})])
        mdf.save(tmp_path / "a.mf4")
    if factor is None:
        with pytest.raises(DataError, match="column p: .*formula"):
            bring_in("a.mf4")
    else:
        np.testing.assert_allclose(np.diff(bring_in("a.mf4")[0].p_tp_pa), factor * 1e3)
    assert not (tmp_path / "made").exists()


def test_mapped_channels_of_more_than_the_limit_are_refused_before_reading(
    bring_in, tmp_path, monkeypatch
):
    from hbench.store.formats import arrays

    monkeypatch.setattr(arrays, "LARGEST_UNPACKED", 8 * 1000)
    write_tdms(tmp_path / "a.tdms")
    with pytest.raises(DataError, match="take more than 0.008 MB"):
        bring_in("a.tdms", "slow/f")


def test_a_run_that_could_not_be_read_again_is_refused(bring_in, rules, tmp_path, monkeypatch):
    from hbench.store.importing import importer

    monkeypatch.setattr(importer, "LARGEST_LOG", 10_000)
    write_tdms(tmp_path / "a.tdms")
    with pytest.raises(DataError, match=r"run 0001 has 290 samples.* 0.01 MB") as caught:
        bring_in("a.tdms", "slow/f")
    assert "resample" in caught.value.hint
    assert not (tmp_path / "out" / "campaign.yaml").exists()


def test_a_file_larger_than_its_format_allows_is_refused(bring_in, tmp_path, monkeypatch):
    write_tdms(tmp_path / "a.tdms")
    size = (tmp_path / "a.tdms").stat().st_size
    rows = [
        replace(row, largest=size - 1) if row.extra == "tdms" else row for row in opening.FORMATS
    ]
    monkeypatch.setattr(opening, "FORMATS", rows)
    with pytest.raises(DataError, match="a.tdms: is .* MB large; limit"):
        bring_in("a.tdms", "slow/f")


@pytest.fixture
def workbook(tmp_path):
    """Write rows to a sheet."""
    import openpyxl

    def write(rows, sheet="log", first=("nothing",)):
        book = openpyxl.Workbook()
        book.active.title = "about"
        book.active.append(first)
        page = book.create_sheet(sheet)
        for row in rows:
            page.append(row)
        book.save(tmp_path / "a.xlsx")

    return write


NUMBERS = [list(map(float, row)) for row in zip(T, X, 60 + T, 2 - T, strict=True)]


def test_a_sheet_is_read_with_preamble_and_row_of_units(bring_in, rules, workbook):
    rows = [["Measured by hand"], [], ["t", "x", "p", "f"], ["s", "mm", "bar", "kN"], *NUMBERS]
    workbook(rows)
    rules["columns"]["t_s"] = {"column": "t", "unit": "s"}
    rules["format"] = {"sheet": "log", "preamble": 2, "units_row": True}
    run, _ = bring_in("a.xlsx")
    np.testing.assert_allclose(run.t_s, T)
    np.testing.assert_allclose(run.f_applied_n, (2 - T) * 1e3)


@pytest.mark.parametrize("units", [[], [["s", "mm", "bar", "kN"]]], ids=["", "with units"])
def test_a_title_above_the_header_of_a_sheet_gives_the_headers_line(
    bring_in, rules, workbook, units
):
    title = [["Seal 12, 40 bar"], ["operator", "A. Smith"], []]
    workbook([*title, ["t", "x", "p", "f"], *units, *NUMBERS])
    rules["columns"]["t_s"] = {"column": "t", "unit": "s"}
    rules["format"] = {"sheet": "log", "units_row": bool(units)}
    with pytest.raises(DataError, match=r"a\.xlsx: line [24]: found") as caught:
        bring_in("a.xlsx")
    hint = "Line 4 looks like the header: write 'preamble: 3' in the map's 'format'."
    assert caught.value.hint == hint
    rules["format"]["preamble"] = 3
    np.testing.assert_allclose(bring_in("a.xlsx")[0].t_s, T)


def test_a_title_as_wide_as_the_header_gives_the_headers_line(bring_in, rules, workbook):
    workbook([["bench", "2", "seal", "12"], ["t", "x", "p", "f"], *NUMBERS])
    rules["columns"]["t_s"] = {"column": "t", "unit": "s"}
    rules["format"] = {"sheet": "log"}
    with pytest.raises(DataError, match="no column 't'") as caught:
        bring_in("a.xlsx")
    assert "Line 2 looks like the header: write 'preamble: 1'" in caught.value.hint


@pytest.mark.parametrize(
    "moment",
    [
        lambda t: datetime(2024, 5, 1, 23, 59, 58) + timedelta(seconds=t),
        lambda t: (datetime(2024, 5, 1, 12) + timedelta(seconds=t)).time(),
        lambda t: timedelta(seconds=t),
    ],
)
def test_dates_and_times_of_a_sheet_become_seconds(bring_in, rules, workbook, moment):
    rows = [["t", "x", "p", "f"], *([moment(t), *row] for t, *row in NUMBERS)]
    assert isinstance(rows[1][0], (datetime, time, timedelta))
    workbook(rows)
    rules["columns"]["t_s"] = {"column": "t", "unit": "date-time"}
    rules["format"] = {"sheet": "log"}
    np.testing.assert_allclose(bring_in("a.xlsx")[0].t_s, T, atol=1e-3)


@pytest.mark.parametrize(
    ("rows", "layout", "message"),
    [
        ([["t", "x", "p", "f"], [0, "1\n", 2, 3], [1, "a\nb", 2, 3]], {}, "line 3: .*found 'a b'"),
        ([["t", "x", "p", "f"], [0, 1, 2, 3, 4]], {}, "line 2: found 5 columns"),
        ([["t", "x", "p"], [0, 1, 2]], {}, "no column 'f'; .* t, x, p"),
        ([["t"]], {"sheet": "other"}, "no sheet 'other'; .* about, log"),
        ([], {}, "no rows of data"),
    ],
)
def test_a_sheet_that_cannot_be_read_is_refused(bring_in, rules, workbook, rows, layout, message):
    workbook(rows)
    rules["columns"]["t_s"] = {"column": "t", "unit": "s"}
    rules["format"] = {"sheet": "log"} | layout
    with pytest.raises(DataError, match=f"a.xlsx: .*{message}"):
        bring_in("a.xlsx")
