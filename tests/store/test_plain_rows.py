"""Text tables are converted by whole columns with the numbers and messages of single cells."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hbench.config.import_layout import Format
from hbench.errors import DataError
from hbench.store.formats.plain_rows import PlainRows
from hbench.store.formats.text import parse_table

NUMBERS = [
    *("0", "-0", "1.5", "-2,25", "+3", "1e3", "1E-4", ".5", "7.", ",5", "1e400", "1e-400"),
    *("123456789.123456789", "0.1", "1,234.5", "1.234,5", "1'234", "1 234", "12 345 678"),
    *("0.30000000000000004", "5e-324", "9007199254740993", "1" * 30, "0." + "3" * 40),
]
GAPS = ["", " ", "nan", "NaN", "NA", "n/a", "null"]
NO_NUMBERS = [
    *("x", "1_0", "0x1f", "inf", "-infinity", "1d5", "1e", "--1", "1 mm", "١", "1\x00", "1\ufeff"),
    *("#1", "nan(1)", "True", "1j", "12:00", "?", "1;2", "²"),
]
LONG_LAST, QUOTED = "0,0\n" * 5 + "0,,5", '"0"'  # a cell too many in a row without an end
SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t", "whitespace": " "}


@st.composite
def tables(draw):
    """A text, the same with quotes about a cell, the format and the number of columns."""
    layout = Format(
        **draw(
            st.sampled_from(
                [
                    {},
                    {"comment": "#"},
                    {"header": False},
                    {"units_row": True, "skip_rows": 1},
                    {"separator": "semicolon", "decimal": ","},
                    {"separator": "semicolon", "decimal": ",", "thousands": "."},
                    {"separator": "semicolon", "thousands": "'"},
                    {"separator": "semicolon", "thousands": ","},
                    {"separator": "tab", "thousands": " "},
                    {"separator": "whitespace", "preamble": 2},
                    {"separator": "whitespace", "decimal": ","},
                ]
            )
        )
    )
    separator = SEPARATORS[layout.separator]
    pools = [NUMBERS, NUMBERS[:8], GAPS + NUMBERS[:8], GAPS + NUMBERS + NO_NUMBERS]
    width = draw(st.integers(1, 4))
    columns = [st.sampled_from(draw(st.sampled_from(pools))) for _ in range(width)]
    above = layout.skip_rows
    top = ["preamble"] * layout.preamble
    top += [separator.join("abcd"[:width])] * layout.header
    top += [separator.join(["mm"] * width)] * layout.units_row
    newline, end = (
        draw(st.sampled_from(["\n", "\r\n", "\r"])),
        draw(st.sampled_from(["", separator])),
    )
    rows = [[draw(column) for column in columns] for _ in range(draw(st.integers(1, 6)) + above)]
    between = [draw(st.sampled_from(["", "", "", newline, f"  {newline}"])) for _ in rows]
    quotable = [
        (row, at)
        for row, cells in enumerate(rows)
        for at, cell in enumerate(cells)
        if cell.strip(" #") == cell != "" and separator not in cell and row >= above
    ]
    texts = []
    for quoted in (None, draw(st.sampled_from(quotable)) if quotable else None):
        lines = [separator.join(cells) + end for cells in rows]
        if quoted and separator != " ":
            row, at = quoted
            cells = [*rows[row][:at], f'"{rows[row][at]}"', *rows[row][at + 1 :]]
            lines[row] = separator.join(cells) + end
        body = newline.join(f"{gap}{line}" for gap, line in zip(between, lines, strict=True))
        texts.append(newline.join([*top, body]))
    return *texts, layout, width


def result(call):
    """What a call returns, or its message."""
    try:
        return call()
    except DataError as error:
        return error.message, error.hint


def told(text, layout, width):
    """All that a table says of its columns."""
    table = result(lambda: parse_table(text.encode(), "a.csv", layout))
    if isinstance(table, tuple):
        return table
    table.prefetch([*table.names, *range(1, width + 1)])
    return (
        (table.names, table.units, table.lines.tolist()),
        [
            np.array(result(lambda n=n, g=gaps: table.numbers(n, gaps=g))).tolist()
            for n in range(1, width + 1)
            for gaps in (False, True)
        ],
    )


@settings(max_examples=150)
@given(tables())
@example((f"a,b\n{LONG_LAST}", f"a,b\n{LONG_LAST.replace('0', QUOTED, 1)}", Format(), 2))
def test_whole_columns_and_single_cells_give_the_same(made):
    plain, quoted, layout, width = made
    expected = told(plain, layout, width)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(PlainRows, "numbers", refuse)
        np.testing.assert_equal(told(plain, layout, width), expected)
    np.testing.assert_equal(told(quoted, layout, width), expected)  # all split by csv


def refuse(*_):
    raise ValueError
