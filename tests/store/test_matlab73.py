"""MATLAB 7.3 files: written by mat-io, and two of Simulink where they are at hand."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from hbench.errors import DataError

matio = pytest.importorskip("matio", reason="mat-io writes the files")
pytestmark = pytest.mark.filterwarnings("ignore::matio.utils.matclass.MatConvertWarning")

CRANE = Path(__file__).parents[2].parent / "shared" / "data" / "crane"

T = np.arange(0, 2, 0.01)
X = 40 * T  # mm
P = 60 + T  # bar
F = 2.5 - T  # kN
COLUMNS = {"x_m": ("x", "mm"), "p_tp_pa": ("p", "bar"), "f_applied_n": ("f", "kN")}


@pytest.fixture
def bring_in(rules, import_by, tmp_path):
    """Import variables by a template of their names, such as ``data.{}``."""

    def bring_in(content, template="{}", time=None):
        matio.save_to_mat(tmp_path / "a.mat", content, version="v7.3")
        rules["series"][0]["files"] = "a.mat"
        rules["columns"] = {
            key: {"column": template.format(name), "unit": unit}
            for key, (name, unit) in COLUMNS.items()
        }
        if time:
            rules["columns"]["t_s"] = {"column": template.format(time[0]), "unit": time[1]}
        (run,), notes = import_by(rules)
        return run, notes

    return bring_in


def check(run, t_s=T, start_s=0.0):
    np.testing.assert_allclose(run.t_s, start_s + t_s, atol=1e-6)
    np.testing.assert_allclose(run.x_m, t_s * 0.04, atol=1e-7)
    np.testing.assert_allclose(run.p_tp_pa, (60 + t_s) * 1e5)
    np.testing.assert_allclose(run.f_applied_n, (2.5 - t_s) * 1e3, atol=1e-2)


def struct_array(*rows):
    kind = [(name, object) for name in rows[0]]
    return np.array([tuple(row.values()) for row in rows], dtype=kind).reshape(-1, 1)


LOG = {"t": T, "x": X, "p": P, "f": F}


@pytest.mark.parametrize(
    ("content", "template"),
    [
        (LOG, "{}"),
        ({"a": {"log": LOG, "by": "hand"}}, "a.log.{}"),
        ({"runs": struct_array({name: -y for name, y in LOG.items()}, LOG)}, "runs(2).{}"),
        ({name: y.astype("f4")[None, :] for name, y in LOG.items()}, "{}"),
    ],
    ids=["vectors", "struct", "struct array", "rows of single precision"],
)
def test_variables_are_found_by_matlabs_notation(bring_in, content, template):
    check(bring_in(content, template, ("t", "s"))[0])


def test_columns_of_a_matrix(bring_in, rules, import_by, tmp_path):
    matrix = np.column_stack([1e3 * T, X, P, F])
    matio.save_to_mat(tmp_path / "a.mat", {"M": matrix, "rate": 100.0}, version="v7.3")
    rules["series"][0]["files"] = "a.mat"
    keys = {"t_s": "ms"} | {key: unit for key, (_, unit) in COLUMNS.items()}
    for k, (key, unit) in enumerate(keys.items(), 1):
        # by path and by number, since it is the only matrix
        rules["columns"][key] = {"column": k if k % 2 else f"M(:,{k})", "unit": unit}
    check(import_by(rules)[0][0])


def timetable(t_s, start=None, **columns):
    steps = pd.to_timedelta(t_s, unit="s")
    index = steps if start is None else pd.Timestamp(start) + steps
    return pd.DataFrame(columns, index=pd.Index(index, name="Time"))


@pytest.mark.parametrize("start", [None, "2024-05-01T23:59:59.25"])
def test_a_timetable_has_times_of_its_own(bring_in, start):
    run, notes = bring_in({"log": {"tt": timetable(T, start, x=X, p=P, f=F)}}, "log.tt.{}")
    check(run)
    assert notes == ()


def test_timetables_of_different_rates_come_to_the_times_of_the_position(bring_in, rules):
    fast = np.arange(0, 2, 0.002)
    slow = np.arange(-1, 3, 0.05)
    start = "2024-05-01T12:00:00"
    tables = {
        "x": timetable(T, start, y=X),
        "p": timetable(fast, start, y=60 + fast),
        "f": timetable(slow + 1, "2024-05-01T11:59:59", y=2.5 - slow),
    }
    run, notes = bring_in(tables, "{}.y")
    check(run, T[1:], start_s=1.0)  # times count from the first of the file
    assert "500 Hz" in notes[0] and "20 Hz" in notes[0]


@pytest.mark.parametrize("rate", [True, False])
@pytest.mark.parametrize("start", [np.timedelta64(0, "s"), np.datetime64("2024-05-01T12:00:00")])
def test_row_times_may_be_given_by_rate_or_step(bring_in, rate, start):
    from matio.utils.converters.mattables import timetable_to_mat

    about = timetable_to_mat(timetable(T, x=X, p=P, f=F))
    row_times = {
        "origin": np.array([[start]]),
        "specifiedAsRate": np.bool_(rate),
        "stepSize": np.array([[np.timedelta64(10, "ms")]]),
        "sampleRate": 100.0,
    }
    about["any"][0, 0]["rowTimes"] = struct_array(row_times)
    regular = matio.utils.MatlabOpaque(properties=about, classname="timetable")
    check(bring_in({"tt": regular}, "tt.{}")[0])


def test_a_table_needs_t_s_which_may_be_a_datetime(bring_in):
    log = pd.DataFrame({"x": X, "p": P, "f": F, "t": 1e3 * T})
    with pytest.raises(DataError, match="column log.f: .*no times"):
        bring_in({"log": log}, "log.{}")
    check(bring_in({"log": log}, "log.{}", ("t", "ms"))[0])


def test_an_object_stored_otherwise_leaves_the_other_variables_readable(bring_in):
    strange = matio.utils.MatlabOpaque(properties={"any": np.zeros(3)}, classname="timetable")
    check(bring_in({**LOG, "tt": strange}, "{}", ("t", "s"))[0])


def test_datetimes_and_durations_are_times_of_vectors(bring_in):
    durations = (1e3 * T).round().astype("timedelta64[ms]")
    dates = np.datetime64("2024-05-01T12:00:00") + durations
    check(bring_in({**LOG, "d": dates}, "{}", ("d", "date-time"))[0])


def test_durations_are_in_seconds(bring_in):
    durations = (1e3 * T).round().astype("timedelta64[ms]")
    check(bring_in({**LOG, "d": durations}, "{}", ("d", "s"))[0])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            {"t": T, "x": X, "p": P, "log": {"f": F, "p": P}},
            r"no column 'f'.* log.f \(200\), log.p \(200\)",
        ),
        ({**LOG, "f": pd.DataFrame({"a": T})}, "column f: is 1 of type object"),
        ({**LOG, "f": np.column_stack([F, F])}, "column f: is 200x2 of type matrix"),
        ({**LOG, "f": "text"}, "column f: is 1 of type not numeric"),
        ({**LOG, "f": F[:-1]}, r"f_applied_n .*\b199 .*\b200\b"),
    ],
)
def test_a_variable_that_is_no_channel_is_refused(bring_in, content, message):
    with pytest.raises(DataError, match=f"a.mat: .*{message}"):
        bring_in(content, "{}", ("t", "s"))


@pytest.mark.parametrize("way", ["external storage", "external link", "virtual dataset"])
def test_data_of_another_file_is_not_read(rules, import_by, tmp_path, way):
    import h5py

    other = tmp_path / "other"
    other.mkdir()
    with h5py.File(other / "b.mat", "w") as file:
        file.update({name: y[None, :] for name, y in LOG.items()})
    (other / "x.bin").write_bytes(X.tobytes())
    with h5py.File(tmp_path / "a.mat", "w") as file:
        file.update({name: y[None, :] for name, y in LOG.items() if name != "x"})
        if way == "external storage":
            where = [(str(other / "x.bin"), 0, X.nbytes)]
            file.create_dataset("x", (1, len(X)), "f8", external=where)
        elif way == "external link":
            file["x"] = h5py.ExternalLink(str(other / "b.mat"), "x")
        else:
            layout = h5py.VirtualLayout((1, len(X)), "f8")
            layout[:] = h5py.VirtualSource(str(other / "b.mat"), "x", (1, len(X)))
            file.create_virtual_dataset("x", layout)
    rules["series"][0]["files"] = "a.mat"
    rules["columns"] = {"t_s": {"column": "t", "unit": "s"}} | {
        key: {"column": name, "unit": unit} for key, (name, unit) in COLUMNS.items()
    }
    with pytest.raises(DataError, match="a.mat: .*(another file|no column 'x')"):
        import_by(rules)


def test_signals_of_simulink_give_the_friction_known_of_a_crane(rules, import_by):
    if not CRANE.is_dir():
        pytest.skip(f"the measurements are not at {CRANE}")
    units = {
        "x_m": ("PistonPosition", "m"),
        "p_tp_pa": ("PaFiltered", "bar"),
        "p_tr_pa": ("PbFiltered", "bar"),
        "v_ref_m_s": ("XDotRef", "m/s"),
    }
    rules["kind"] = "verification"
    rules["constants"] = {}
    rules["columns"] = {
        key: {"column": f"f{name}_G_OPCf{name}", "unit": unit}
        for key, (name, unit) in units.items()
    }
    cylinder = {"piston_diameter": "65 mm", "rod_diameter": "35 mm"}
    series = {"label": "", "files": "DataForFriction_170125.mat", "cylinder": cylinder}
    (run,), _ = import_by({**rules, "series": [series]}, CRANE)
    np.testing.assert_allclose(run.t_s, np.arange(15827) / 100)
    areas = run.plan.specimen
    force = run.p_tp_pa * areas.area_piston_m2 - run.p_tr_pa * areas.area_rod_m2
    mm_s = np.zeros(len(force))
    mm_s[10:-10] = 1e3 * (run.x_m[20:] - run.x_m[:-20]) / 0.2
    for start in np.arange(0.06, 0.30, 0.04):
        here = abs(run.x_m - start - 0.02) < 0.02
        extend, retract = (np.median(force[here & way]) for way in (mm_s > 35, mm_s < -95))
        # by the data's README 0.97 to 1.06 kN over 60 to 300 mm, computed independently
        assert (extend - retract) / 2 == pytest.approx(1015, abs=75)
