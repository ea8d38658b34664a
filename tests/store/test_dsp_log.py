import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hbench.errors import DataError
from hbench.store.dsp_logs.ccs_text import parse_ccs
from hbench.store.dsp_logs.dsp_log import format_words, parse_records, parse_words

words = arrays(np.uint16, st.integers(0, 60), elements=st.integers(0, 0xFFFF))


def test_file_is_a_ccs_hex_file():
    assert format_words(np.array([[0, 10], [255, 65535]], np.uint16)) == (
        b"1651 1 0 0 4\n0000\n000a\n00ff\nffff\n"
    )


@given(words)
def test_words_come_back(values):
    back, warnings = parse_words(format_words(values), "x")
    assert back.dtype == np.uint16
    assert back.tolist() == values.tolist()
    assert warnings == ()


@given(words)
def test_lines_are_what_python_formats(values):
    lines = "".join(f"{int(v):04x}\n" for v in values)
    assert format_words(values) == f"1651 1 0 0 {len(values):x}\n{lines}".encode()


def outcome(read, data):
    try:
        values, warnings = read(data)
        return values.dtype, values.tolist(), warnings
    except DataError as error:
        return error.message


@given(words, st.integers(0, 5), st.integers(0, 400), st.binary(max_size=3))
def test_damaged_files_read_alike_on_the_fast_and_the_general_way(values, missing, at, inserted):
    data = format_words(values)
    data = data[: max(0, len(data) - missing)]
    data = data[:at] + inserted + data[at:]

    def general(data):
        parsed = parse_ccs(data, "x", headerless="hex")
        return parsed.values, parsed.warnings

    fast, slow = outcome(lambda d: parse_words(d, "x"), data), outcome(general, data)
    if isinstance(fast, str) or isinstance(slow, str) or slow[0] == np.uint16:
        assert fast == slow or "16-bit words" in fast
    else:  # the general way alone knows 32-bit and decimal samples
        assert fast[2] == slow[2]


def test_32_bit_numbers_are_two_words_the_low_one_first():
    back, _ = parse_words(b"1651 1 0 0 2\r\n0x00010002\r\n0xFFFE0003\r\n", "x")
    assert back.tolist() == [2, 1, 3, 0xFFFE]


def test_negative_decimals_are_words_in_twos_complement():
    back, _ = parse_words(b"1651 2 0 0 3\n-1\n-32768\n65535\n", "x")
    assert back.tolist() == [0xFFFF, 0x8000, 0xFFFF]


@pytest.mark.parametrize("sample", [b"65536", b"-32769"])
def test_numbers_wider_than_a_word_are_refused(sample):
    with pytest.raises(DataError, match="a.dat: sample 2 is .*; expected 16-bit words"):
        parse_words(b"1651 2 0 0 2\n1\n" + sample + b"\n", "a.dat")


def test_fractions_are_refused():
    with pytest.raises(DataError, match="decimal fractions"):
        parse_words(b"1651 4 0 0 1\n1.5\n", "a.dat")


@given(st.integers(1, 7), words)
def test_whole_records_are_kept_and_the_rest_is_told(channels, values):
    records, warnings = parse_records(format_words(values), channels, "x")
    kept = len(values) // channels * channels
    assert records.shape == (len(values) // channels, channels)
    assert records.ravel().tolist() == values[:kept].tolist()
    told = [w for w in warnings if w.startswith("truncated: the last record has")]
    assert len(told) == (len(values) % channels > 0)


@pytest.mark.parametrize("lost", range(1, 20))
def test_a_file_cut_anywhere_is_told_and_never_gives_a_wrong_word(lost):
    values = np.arange(0x1230, 0x1250, dtype=np.uint16)
    data = format_words(values)
    back, warnings = parse_words(data[:-lost], "x")
    assert back.tolist() == values[: len(back)].tolist()
    # one byte lost is the last newline alone: all words are there
    assert any(w.startswith("truncated") for w in warnings) == (lost > 1)


def test_a_large_file_of_another_make_is_refused_before_its_lines_are_read():
    ours = format_words(np.zeros(3_400_000, np.uint16))
    assert len(parse_words(ours, "a.dat")[0]) == 3_400_000
    with pytest.raises(DataError, match="a.dat: .* 17 MB.* 16 MB"):
        parse_words(ours[:-2] + b"x\n", "a.dat")
