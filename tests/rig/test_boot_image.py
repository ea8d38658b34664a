"""A boot image is taken as TI's tool writes it, or refused with what is wrong and where."""

import re
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hbench.errors import ConfigError, DataError, ExitCode
from hbench.rig.flash.f28335.boot_image import parse_boot_image
from hbench.rig.flash.image import read_image
from tests.support.board.boot_rom_standin import octets_of, stream_of, text_of

GOOD = stream_of(0x008000, [(0x008000, [0x1234, 0xABCD]), (0x000000, [0x0040, 0x8000])])


def parse(stream: bytes, **how):
    return parse_boot_image(text_of(stream, **how), "image.txt")


def refusal(text: str) -> DataError:
    with pytest.raises(DataError) as caught:
        parse_boot_image(text, "image.txt")
    assert caught.value.exit_code == ExitCode.DATA
    assert caught.value.message.startswith("image.txt: ")
    assert caught.value.hint
    return caught.value


def test_the_first_22_bytes_for_entry_8000_are_those_of_the_manual():
    text = "AA 08" + 16 * " 00" + " 00 00 00 80 01 00 00 00 00 80 34 12 00 00"
    image = parse_boot_image(text, "image.txt")
    assert image.stream[:22] == bytes.fromhex("AA08" + 16 * "00" + "00000080")
    assert image.entry == 0x008000
    assert [(b.address, b.words) for b in image.blocks] == [(0x008000, (0x1234,))]


@pytest.mark.parametrize("marks", [True, False])
@pytest.mark.parametrize("columns", [1, 16, 24, 1000])
def test_marks_and_line_length_make_no_difference(marks, columns):
    assert parse(GOOD, marks=marks, columns=columns).stream == GOOD


def test_windows_line_ends_and_small_letters_are_taken():
    text = text_of(GOOD).replace("\n", "\r\n").lower()
    assert parse_boot_image(text, "image.txt").stream == GOOD


def test_one_mark_alone_is_taken():
    assert parse_boot_image(text_of(GOOD).removeprefix("\x02"), "image.txt").stream == GOOD


@pytest.mark.parametrize("start, words", [(0x000050, 0x7B0), (0x008000, 0x8000)])
def test_a_block_may_fill_a_region_to_its_last_word(start, words):
    assert parse(stream_of(start, [(start, [0] * words)])).size == f"{words} words in 1 blocks"


@pytest.mark.parametrize(
    "address, count, outside",
    [
        (0x000000, 3, 0x000002),  # the ROM's stack, from below
        (0x00004F, 1, 0x00004F),
        (0x0007FF, 2, 0x000800),
        (0x007FFF, 2, 0x007FFF),
        (0x00FFFF, 2, 0x010000),
        (0x300000, 8, 0x300000),  # flash
    ],
)
def test_a_block_outside_loadable_ram_is_named_with_its_address(address, count, outside):
    stream = stream_of(0x8000, [(0x8000, [1, 2]), (address, [0] * count)])
    message = refusal(text_of(stream)).message
    assert f"block 2 ({count} words at 0x{address:06X}): 0x{outside:06X} is outside" in message
    assert "0x000050-0x0007FF, 0x008000-0x00FFFF" in message


@pytest.mark.parametrize("first", ["AA 00", "AA 10", "08 AA"])
def test_a_header_of_another_boot_mode_is_told_from_a_wrong_key(first):
    error = refusal(first + text_of(GOOD, marks=False)[5:])
    assert first in error.message and "AA 08" in error.message
    assert "-sci8" in error.message


def test_a_wrong_key_is_refused_before_the_rom_would_jump_to_flash():
    error = refusal(text_of(stream_of(0x8000, [(0x8000, [1])], key=0x1234)))
    assert "34 12" in error.message and "-sci8" not in error.message
    assert "flash" in error.message


@pytest.mark.parametrize("stood", ["XY", "123", "0xAA", "A", "Ä9"])
def test_what_is_not_hex_is_shown_with_its_line(stood):
    lines = text_of(GOOD, columns=16).split("\n")
    lines[2] = lines[2].replace("00", stood, 1)
    assert f"line 3: '{stood}'" in refusal("\n".join(lines)).message


def test_an_address_record_is_an_image_made_without_boot():
    error = refusal("\x02\n$A8000,\nAA 08 \x03")
    assert "line 2: " in error.message and "'$A8000,'" in error.message and "-boot" in error.hint


@given(st.integers(0, len(GOOD) - 1))
def test_an_image_cut_anywhere_is_truncated(length):
    assert "truncated in" in refusal(text_of(GOOD[:length])).message


def test_the_place_of_the_cut_is_named():
    error = refusal(text_of(GOOD[:-7]))
    assert re.search(r"truncated .*\bblock 2: 3 of 4 .*\b37\b", error.message)
    assert re.search(r"block 1 .*0x008000.* 1 of 4", refusal(text_of(GOOD[:29])).message)


def test_octets_after_the_end_are_refused_but_padding_is_not_sent():
    assert parse(GOOD + b"\0\0").stream == GOOD
    assert ": 3 octets" in refusal(text_of(GOOD + b"\0\1\0")).message


@pytest.mark.parametrize("entry", [0x008002, 0x33FFF6])
def test_an_entry_where_nothing_is_loaded_is_refused(entry):
    error = refusal(text_of(stream_of(entry, [(0x8000, [1, 2])])))
    assert f" 0x{entry:06X}" in error.message


def test_text_is_found_a_character_a_word_across_split_blocks():
    words = [ord(c) for c in "hbench"]
    image = parse(stream_of(0x8000, [(0x8003, words[3:]), (0x8000, words[:3])]))
    assert image.contains_text("hbench") and image.contains_text("ench")
    assert not image.contains_text("bench!") and not image.contains_text("hbenhc")


@given(st.binary(max_size=200))
def test_no_file_is_anything_but_an_image_or_a_data_error(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "any.txt"
    path.write_bytes(content)
    with pytest.raises(DataError):
        read_image(path)


@given(st.lists(st.integers(0, 0xFFFF), max_size=60))
def test_no_words_are_anything_but_an_image_or_a_data_error(words):
    stream = GOOD[:2] + octets_of(words)
    with suppress(DataError):
        assert stream.startswith(parse(stream).stream)


def test_a_missing_file_is_a_usage_error(tmp_path):
    with pytest.raises(ConfigError, match="none.txt"):
        read_image(tmp_path / "none.txt")
