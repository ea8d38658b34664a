"""YAML that anybody may have written is read like any other reader's, or refused with its line."""

import time

import pytest
import yaml

from hbench.config.files.yaml_text import parse_yaml

BOMB = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
BOMB += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 12)]


def test_good_text_is_read_as_another_loader_reads_it():
    text = (
        "a: &x [1, 2.5, .5, 1e3, yes, ~, 'it''s']\nb: *x\nc: {<<: {d: 1}, e: 2026-01-01}\n"
        "f: |\n  two\n  lines\n? 7\n: '1'\n"
    )
    assert parse_yaml(text) == yaml.safe_load(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1\nb: 2026-99-99\n", "line 2: '2026-99-99' .*timestamp"),
        ("a: 1\nb: !!bool maybe\n", "line 2: 'maybe' .*bool"),
        ("a: !!int x", "line 1: 'x' .*int"),
        ("a: " + "9" * 5000, "line 1: '9{40}' .*int"),
        ("a: 1\nb: {c: 1,\n c: 2}", "line 3: .*'c'.*line 2"),
        ("a: b: c", "line 1: "),
        ("a: \x00", "character"),
        ("a: &a [*a]", "line 1: alias .a "),
        ("\n".join(BOMB), "line 6: aliases .*100000"),
        ("a: " + "[" * 60 + "]" * 60, "line 1: nested .*50"),
        ("a:\n" + "\n".join(" " * n + "a:" for n in range(1, 60)), "line 51: nested .*50"),
        ("? [a, b]\n: c", "unhashable key"),
    ],
    ids=range(12),
)
def test_what_cannot_be_read_is_named_with_its_line(text, message):
    with pytest.raises(ValueError, match=message):
        parse_yaml(text)


def test_numbers_of_yaml_1_1_that_are_others_than_they_show_are_text():
    shown = ["010", "-0360", "007", "1:30", "1:30.5", "190:20:30"]
    assert parse_yaml(f"[{', '.join(shown)}]") == shown
    others = ("0", "-0", "0.5", "00.5", "0x10", "1_000", "+1", "1.5e+3", "2026-01-01", "0b11")
    text = f"[{', '.join(others)}]"
    assert parse_yaml(text) == yaml.safe_load(text)


def test_a_long_number_in_base_60_is_text_that_nothing_converts():
    shown = ":".join(["59"] * 100_000)
    assert parse_yaml(f"a: {shown}") == {"a": shown}


@pytest.mark.parametrize("opening", ["[", "- ", "{a: ", "? "])
def test_the_deepest_nesting_is_refused_at_once_and_breaks_no_stack(opening):
    start = time.perf_counter()
    with pytest.raises(ValueError, match="line .: nested .*50"):
        parse_yaml("a:\n " + opening * 200_000)
    assert time.perf_counter() - start < 5
