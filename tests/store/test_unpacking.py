"""Compressed files from strangers: a few bytes that stand for a great many."""

import io
import struct
import zlib

import numpy as np
import pytest

from hbench.errors import DataError
from hbench.store.files import bounded_read
from hbench.store.formats.matlab import mat_sizes
from hbench.store.formats.matlab.mat import read_mat
from hbench.store.formats.parquet import read_parquet

HEADER = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H2s", 0x0100, b"IM")
DOUBLE, CHAR, CELL, STRUCT = 6, 4, 1, 2  # classes of arrays


def element(kind, content):
    return struct.pack("<II", kind, len(content)) + content + bytes(-len(content) % 8)


def array(array_class, dimensions, *parts, name=b"x"):
    """An array as MAT-File Format, level 5, describes it."""
    head = element(6, struct.pack("<II", array_class, 0))
    head += element(5, struct.pack(f"<{len(dimensions)}i", *dimensions)) + element(1, name)
    return element(14, head + b"".join(parts))


def packed(content):
    data = zlib.compress(content, 1)
    return struct.pack("<II", 15, len(data)) + data


def zeros(count):
    return array(DOUBLE, (count, 1), element(9, bytes(8 * count)))


def test_the_files_made_here_by_hand_are_read():
    x = np.arange(5.0)
    content = array(DOUBLE, (5, 1), element(9, x.tobytes()))
    for data in (HEADER + content, HEADER + packed(content)):
        assert np.array_equal(read_mat(data, "x.mat")["x"], x)
    inner = array(DOUBLE, (1, 1), element(9, x[1:2].tobytes()), name=b"")
    cell = array(CELL, (1, 2), inner, inner)
    assert read_mat(HEADER + packed(cell), "x.mat")["x"].tolist() == [1.0, 1.0]


def test_a_mat_file_that_unpacks_to_too_much_is_refused_before_it_is(limited):
    bomb = HEADER + packed(zeros(26_000_000))
    assert len(bomb) < 1_000_000
    with limited(), pytest.raises(DataError, match="200 MB"):
        read_mat(bomb, "x.mat")


def test_many_small_bombs_in_one_mat_file_count_together(monkeypatch):
    monkeypatch.setattr(mat_sizes, "LARGEST_UNPACKED", 20_000_000)
    one = packed(zeros(1_000_000))  # 8 MB each
    assert len(read_mat(HEADER + 2 * one, "x.mat")) == 1
    with pytest.raises(DataError, match="20 MB"):
        read_mat(HEADER + 3 * one, "x.mat")


@pytest.mark.parametrize("pack", [packed, lambda content: content], ids=["packed", "plain"])
@pytest.mark.parametrize("array_class", [CHAR, CELL, STRUCT, DOUBLE])
@pytest.mark.parametrize("dimensions", [(2_000_000_000, 1), (100_000, 100_000), (2**31 - 1,) * 8])
def test_an_array_that_says_it_is_larger_than_its_bytes_is_refused(
    pack, array_class, dimensions, limited
):
    fields = [element(5, struct.pack("<i", 8)), element(1, b"")] if array_class == STRUCT else []
    bomb = HEADER + pack(array(array_class, dimensions, *fields, element(4, b"")))
    with limited(), pytest.raises(DataError, match=r"array of \d+ elements.* \d+ bytes"):
        read_mat(bomb, "x.mat")


def test_a_large_array_within_a_struct_is_found_too(limited):
    inner = array(CHAR, (2_000_000_000, 1), element(4, b""), name=b"")
    fields = element(5, struct.pack("<i", 8)), element(1, b"a".ljust(8, b"\0"))
    with limited(), pytest.raises(DataError, match="2000000000 elements"):
        read_mat(HEADER + packed(array(STRUCT, (1, 1), *fields, inner)), "x.mat")


def test_cells_in_cells_are_refused_before_the_stack_ends():
    content = b""
    for _ in range(1000):
        content = array(CELL, (1, 1), content, name=b"")
    with pytest.raises(DataError, match=r"\b50\b"):
        read_mat(HEADER + packed(content), "x.mat")


def test_a_parquet_file_that_unpacks_to_too_much_is_refused_before_it_is():
    pyarrow = pytest.importorskip("pyarrow")
    import pyarrow.parquet as pq

    file = io.BytesIO()
    table = pyarrow.table({"t_s": pyarrow.array(np.zeros(30_000_000))})
    pq.write_table(table, file, compression="zstd")
    assert len(file.getvalue()) < 1_000_000
    with pytest.raises(DataError, match="200 MB"):
        read_parquet(file.getvalue(), "x.parquet")


def test_what_fits_is_read(monkeypatch):
    """The same checks on sound files: those of an export (test_export.py) and a full one."""
    monkeypatch.setattr(bounded_read, "LARGEST_UNPACKED", 95)
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    file = io.BytesIO()
    pandas.DataFrame({"t_s": np.arange(12.0)}).to_parquet(file)
    with pytest.raises(DataError, match="9.5e-05 MB"):
        read_parquet(file.getvalue(), "x.parquet")
    monkeypatch.undo()
    assert len(read_parquet(file.getvalue(), "x.parquet")) == 12
    content = zeros(1_000_000)
    assert len(read_mat(HEADER + packed(content), "x.mat")["x"]) == 1_000_000
