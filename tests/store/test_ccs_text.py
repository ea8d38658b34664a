"""Every variation of Code Composer Studio data files that is known from real files."""

import re

import numpy as np
import pytest

from hbench.errors import DataError
from hbench.store.dsp_logs.ccs_text import parse_ccs


def read(text, **kwargs):
    data = text if isinstance(text, bytes) else text.encode()
    return parse_ccs(data, "log.dat", **kwargs)


@pytest.mark.parametrize(
    ("text", "dtype", "values"),
    [
        ("1651 1 0 0 0\n00ff\n8000\n", np.uint16, [255, 32768]),  # length 0: to the end
        ("1651 1 80001000 0 2\n0x00ff\n0x8000\n", np.uint16, [255, 32768]),
        ("1651 1 0 0 2\r\n0x0000000A\r\n0xFFFF0001\r\n", np.uint32, [10, 0xFFFF0001]),
        ("1651 1 0 0 4\n0x0000000A\n0xFFFF0001\n", np.uint32, [10, 0xFFFF0001]),  # in words
        ("1651 1 0 0 2\n00FF\n00fe\n\n  \n", np.uint16, [255, 254]),  # blank lines at the end
        ("1651 2 0 0 3\n-5\n17\n32767\n", np.int64, [-5, 17, 32767]),
        ("1651 3 0 0 4\n-70000\n+17\n", np.int64, [-70000, 17]),  # a long is two words
        ("1651 4 80001000 0 4\r\n1.5\r\n-2\r\n.25\r\n1e-3\r\n", np.float64, [1.5, -2, 0.25, 1e-3]),
        ("1651 1 0 0 a\n" + "0001\n" * 10, np.uint16, [1] * 10),  # the length is hex
        ("\ufeff1651 1 0 0 1\n0001\n", np.uint16, [1]),
        ("1651 1 0 0 0\n", np.uint16, []),
        ("1651 1 0 0 2\n0001\n0002", np.uint16, [1, 2]),  # no newline at the end
    ],
)
def test_variation_reads_without_warning(text, dtype, values):
    data = read(text)
    assert data.values.dtype == dtype
    assert data.values.tolist() == values
    assert data.warnings == ()


@pytest.mark.parametrize(
    ("text", "values", "warning"),
    [
        ("1651 1 0 0 3\n-5\n17\n99\n", [-5, 17, 99], "format: 1 .*'-5'.* decimal"),
        ("1651 1 0 0 2\n0.5\n17\n", [0.5, 17.0], "format: 1 .*'0.5'.* decimal"),
        ("1651 9 88675cac 0 2 c\n00\n0f\n", [0, 15], "format: 9 .* hex"),  # as CCS 5.4
        ("1651 9 88675cac 0 2 c\n00\n10\n", [0, 16], "format: 9 .* hex"),
        ("1651 9 0 0 2 c\n1.5\n2.5\n", [1.5, 2.5], "format: 9 .* float"),
        ("1651 9 0 0 2 c\n-15\n20\n", [-15, 20], "format: 9 .* integer"),
        ("1651 1 0 0 5\n0001\n0002\n", [1, 2], r"truncated: .*\b5\b.*\b2\b"),
        ("1651 1 0 0 1\n0001\n0002\n", [1, 2], r"length: .*\b1\b.*\b2\b"),
        ("0x0001\n0x0010\n", [1, 16], "header: .*'1651'.* hex"),
        ("-1\n10\n", [-1, 10], "header: .*'1651'.* integer"),
        ("1651 1 0 0 0\n0001\n0002\n00", [1, 2], "truncated: .*'00'"),
    ],
)
def test_variation_reads_with_a_warning(text, values, warning):
    data = read(text)
    assert data.values.tolist() == values
    assert len(data.warnings) == 1
    assert re.match(warning, data.warnings[0]), data.warnings


def test_headerless_digits_are_read_only_when_told():
    with pytest.raises(DataError, match="hex or decimal") as caught:
        read("12\n345\n")
    assert "Hex 16 bit" in caught.value.hint
    assert read("12\n345\n", headerless="hex").values.tolist() == [0x12, 0x345]
    assert read("12\n345\n", headerless="integer").values.tolist() == [12, 345]


def test_open_notation_that_nothing_tells_is_refused_with_a_hint():
    with pytest.raises(DataError, match="log.dat: .*'12'.* hex or decimal"):
        read("1651 9 0 0 2 c\n12\n345\n")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1651 1 0 0 3\n0001\nxyz\n0002\n", r"log.dat: line 3: .*'xyz'.* hex"),
        ("1651 1 0 0 3\n0001\n\n0002\n", r"line 3: .*''.* hex"),
        ("1651 1 0 0 3\n0001\n123456789\n", r"line 3: .*'123456789'.* 8 digits"),
        ("1651 1 0 0 3\n0001\n0001 0002\n", r"line 3: .*'0001 0002'.* hex"),
        ("1651 2 0 0 3\n1\n1.5\n", r"line 3: .*'1.5'.* decimal"),
        ("1651 4 0 0 3\n1.5\n0xff\n", r"line 3: .*'0xff'.* decimal"),
        ("1651 1 0 0 3\n-5\nff\n", r"line 3: .*'ff'.* decimal"),
        ("1651 1 0\n0001\n", r"line 1: .*'1651 1 0'.*'1651 format"),
        ("1652 1 0 0 1\n0001\n", r"line 1: .*'1652 1 0 0 1'.*'1651 format"),
        ("1651 7 0 0 1\n0001\n", r"line 1: .*format 7.* 1, 2, 3, 4 or 9"),
        (b"1651 1 0 0 1\n0001\n\x00\xff\n", r"line 3: .*0xff.*ASCII"),
    ],
)
def test_bad_file_is_refused_with_line_and_expectation(text, message):
    with pytest.raises(DataError, match=message):
        read(text)
