"""Binary files from strangers: forged to crash their reader, or to take all memory or time.

The import ends with exit code 4 and the file's name; see also store/test_unpacking.py for what
compressed files unpack to, and test_mutated_imports.py for files that went bad by chance.
"""

import io
import shutil
import struct
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest
import yaml
from scipy.io import savemat
from scipy.sparse import csc_matrix

from hbench import workflow
from hbench.errors import ConfigError, DataError
from hbench.store.campaign.folder import load_campaign
from hbench.store.formats import opening, reading

AT = datetime(2026, 1, 1, tzinfo=UTC)
T = np.arange(100) / 100
CHANNELS = {"t": T, "x": 1000 * T, "p": 60 + T}


@pytest.fixture
def bring_in(tmp_path):
    """Return a function that imports a file; ``columns`` replaces those of t, x and p."""

    def bring_in(name, data, **columns):
        logs = tmp_path / "logs"
        logs.mkdir(exist_ok=True)
        (logs / name).write_bytes(data)
        named = {"t": "t", "x": "x", "p": "p"} | columns
        rules = {
            "name": "strange",
            "columns": {
                "t_s": {"column": named["t"], "unit": "s"},
                "x_m": {"column": named["x"], "unit": "mm"},
                "p_tp_pa": {"column": named["p"], "unit": "bar"},
            },
            "series": [{"label": "", "files": name, "cylinder": {"piston_diameter": "40 mm"}}],
        }
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
        out = tmp_path / "out"
        shutil.rmtree(out, ignore_errors=True)
        workflow.import_runs(logs, out, tmp_path / "map.yaml", lambda: AT)
        (run,) = load_campaign(out).runs()
        return run

    return bring_in


def mat(**variables):
    file = io.BytesIO()
    savemat(file, CHANNELS | variables, oned_as="column")
    return file.getvalue()


def parquet(**columns):
    pyarrow = pytest.importorskip("pyarrow")
    from pyarrow.parquet import write_table

    file = io.BytesIO()
    write_table(pyarrow.table(columns), file)
    return file.getvalue()


def test_a_sound_file_is_read_by_the_process_of_readers(bring_in):
    run = bring_in("a.mat", mat())
    np.testing.assert_array_equal(run.t_s, T)
    assert reading._process.is_running


@pytest.mark.parametrize("kind", [8, 65535])
def test_a_type_of_data_that_does_not_exist_is_refused(bring_in, kind):
    """scipy looks it up in a table without a check, and reads memory that is not its own."""
    data = mat()
    numbers = struct.pack("<II", 9, 8 * len(T))  # the type of doubles and their size
    at = data.index(numbers)
    forged = data[:at] + struct.pack("<I", kind) + data[at + 4 :]
    with pytest.raises(DataError, match=r"a\.mat: can't be read"):
        bring_in("a.mat", forged)
    assert len(bring_in("b.mat", mat()).t_s) == len(T)  # the next file has a new process


@pytest.mark.parametrize(
    "matrix", [csc_matrix((2**31 - 1, 1)), csc_matrix(np.eye(100)), csc_matrix((100, 1))]
)
@pytest.mark.parametrize("column", ["m", "m(:,1)", "m(1)"])
def test_a_sparse_matrix_is_no_column(bring_in, matrix, column, limited):
    with limited(), pytest.raises(DataError, match=r"a\.mat: .*m"):
        bring_in("a.mat", mat(m=matrix), p=column)


def test_a_struct_of_very_many_fields_is_refused(bring_in, limited):
    with limited(20), pytest.raises(DataError, match=r"a\.mat: .*\b12000 fields; limit 10000"):
        bring_in("a.mat", mat(s={f"f{n}": 0.0 for n in range(12_000)}))


@pytest.mark.parametrize(
    "number", ["1" * 5000, "9" * 300, "9999999999", "101", "0", "00", "-1", "٣"]
)
@pytest.mark.parametrize("path", ["m(:,{})", "m({})", "s.m({})"])
def test_an_index_that_is_not_there_is_refused(bring_in, path, number):
    content = mat(m=np.eye(100), s={"m": np.eye(100)})
    with pytest.raises((DataError, ConfigError), match=r"no column"):
        bring_in("a.mat", content, p=path.format(number))


def test_a_text_repeated_by_a_parquet_file_s_dictionary_is_not_unpacked(
    tmp_path, bring_in, limited
):
    pyarrow = pytest.importorskip("pyarrow")
    text, rows = "x" * 1_000_000, 10_000  # 10 GB
    same = pyarrow.DictionaryArray.from_arrays(pyarrow.array(np.zeros(rows, np.int32)), [text])
    x = np.arange(rows) / 100
    with limited(30):
        run = bring_in("a.parquet", parquet(t=x, x=x, p=x, label=same))
        assert len(run.t_s) == rows
        with pytest.raises(DataError, match=r"a\.parquet: column label"):
            bring_in("a.parquet", parquet(t=x, x=x, p=x, label=same), p="label")
        (tmp_path / "index").mkdir()
        index = parquet(run=["1"] * rows, file=same, v_ref_m_s=x)
        (tmp_path / "index" / "runs.parquet").write_bytes(index)
        with pytest.raises(DataError, match=r"runs\.parquet: .*200 MB"):
            workflow.import_runs(tmp_path / "index", tmp_path / "out2", None, lambda: AT)


def test_a_file_without_samples_is_refused(bring_in):
    pyarrow = pytest.importorskip("pyarrow")
    empty = pyarrow.array([], pyarrow.timestamp("us"))
    with pytest.raises(DataError, match=r"a\.parquet: .*no samples|a\.parquet: .*date"):
        bring_in(
            "a.parquet", parquet(t=empty, x=pyarrow.array([], "f8"), p=pyarrow.array([], "f8"))
        )


def test_a_dataset_that_is_larger_than_its_file_is_refused(bring_in, limited):
    """HDF5 stores no samples where all are equal."""
    h5py = pytest.importorskip("h5py")
    file = io.BytesIO()
    with h5py.File(file, "w", userblock_size=512) as content:
        for name in CHANNELS:
            chunks = (1, 10**6)
            data = content.create_dataset(name, (1, 10**12), dtype="f8", chunks=chunks)
            data.attrs["MATLAB_class"] = np.bytes_("double")
    with limited(20), pytest.raises(DataError, match=r"a\.mat: .*200 MB"):
        bring_in("a.mat", b"MATLAB 7.3 MAT-file".ljust(512) + file.getvalue()[512:])


@pytest.mark.parametrize("error", [ZeroDivisionError("by 0"), RecursionError(), MemoryError()])
@pytest.mark.parametrize("name", ["a.txt", "a.mat"])
def test_any_exception_of_a_reader_names_the_file_and_itself(bring_in, monkeypatch, name, error):
    def fail(*_):
        raise error

    class Here:
        is_running = True

        def call(self, function, *arguments):
            return function(*arguments)

    monkeypatch.setattr(reading, "_process", Here())
    monkeypatch.setattr(opening, "FORMATS", [replace(row, open=fail) for row in opening.FORMATS])
    with pytest.raises(DataError, match=rf"{name}: can't be read as .*: {type(error).__name__}"):
        bring_in(name, b"t,x,p\n")


def test_an_exception_in_the_conversion_of_a_file_names_the_file(bring_in, monkeypatch):
    def fail(*_):
        raise FloatingPointError("no number")

    monkeypatch.setattr("hbench.store.importing.channels.aligned", fail)
    with pytest.raises(DataError, match=r"a\.mat: can't be read: FloatingPointError: no number"):
        bring_in("a.mat", mat())
