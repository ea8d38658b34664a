"""Lines of runs as JSON: the same content as YAML, or left to the YAML parser."""

import json

import pytest
import yaml

from hbench.errors import DataError
from hbench.store.campaign.journal import Stop, journal_header, parse_journal, start_text, stop_text
from hbench.store.campaign.run_lines import json_line, parse_run_lines

START = '- run: \'0001\'\n  plan: {"kind": "steady"}\n  start: {"at": "x"}\n'


def by_yaml(text):
    """The content by the plain YAML loader."""
    return yaml.safe_load(text)


def test_lines_have_the_content_that_yaml_reads(make_plan, at):
    text = "".join(
        [
            start_text(make_plan("0001", label="NBR, 70 Shore: ü # {"), at(1)),
            stop_text(Stop(at(2).isoformat(), "done", 4, "3e5" + "ab" * 30)),
            start_text(make_plan("0002", f_load_n=None, motion=None), at(3), after_rejection="it"),
        ]
    )
    assert parse_run_lines(text) == by_yaml(text)


@pytest.mark.parametrize(
    "value", [1e-5, 1e22, -2.5e-7, 0.1, -0.0, 12, True, None, "1e-05", 'a "1e-05', "null", "ü\n"]
)
def test_a_line_is_the_same_value_in_yaml(value):
    line = json_line({"value": value})
    assert by_yaml(line) == json.loads(line) == {"value": value}


def test_characters_that_yaml_refuses_are_left_to_its_writer():
    assert json_line({"why": "\ufffe"}) is None
    assert json_line({"limit": float("inf")}) is None


@pytest.mark.parametrize(
    "line",
    [
        "  stop: {outcome: done}",
        '  stop: {"records": 1e5}',  # text in YAML
        '  stop: {"records": NaN}',  # likewise
        '  stop: {"records": -Infinity}',
        '  stop: {"why": "\\u0007"}',  # control characters are refused by the YAML parser
        '  stop: {"why": "\x85"}',
        '  stop: {"a": 1, "a": 2}',
        '  stop: {"a": ' + 60 * "[" + 60 * "]" + "}",
        '  start: {"at": "again"}',
        "# a comment",
        "",
    ],
)
def test_any_other_line_is_left_to_the_yaml_parser(line):
    assert parse_run_lines(START) == by_yaml(START)
    assert parse_run_lines(START + line + "\n") is None


def test_a_key_of_runs_before_the_runs_is_refused_as_duplicate(header, make_plan, at):
    text = journal_header(header) + start_text(make_plan("0001"), at(1))
    with pytest.raises(DataError, match="key 'runs' is duplicate"):
        parse_journal(("runs: []\n" + text).encode(), "campaign.yaml")
