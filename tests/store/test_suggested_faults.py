"""Files that a suggested map does not read, and names of columns in comments."""

import numpy as np
import pytest

from hbench.config.files.yaml_text import parse_yaml
from hbench.errors import DataError
from hbench.store.suggesting.dialect import text_dialect
from hbench.store.suggesting.suggest import suggest_map
from tests.support.strokes import one_stroke

NAMES = ("t", "x", "pA", "pB", "F")
UNITS = ("s", "mm", "bar", "bar", "N")


@pytest.fixture
def logs(tmp_path):
    (tmp_path / "logs").mkdir()
    return tmp_path / "logs"


def rows_of(load_n, write="{:.3f}".format):
    run = one_stroke(0.05, load_n)
    columns = (run["t_s"], 1e3 * run["x_m"], run["p_tp_pa"] / 1e5, run["p_tr_pa"] / 1e5)
    table = np.column_stack([*columns, run["f_applied_n"]])
    return [[write(value) for value in row] for row in table.tolist()]


def write_table(path, rows, *head, separator=";"):
    lines = [*head, *(separator.join(row) for row in rows), ""]
    path.write_text("\n".join(lines))


@pytest.mark.parametrize(
    ("grouped", "mark"),
    [
        (lambda value: f"{value:,.3f}".translate(str.maketrans(",.", ".,")), "."),
        (lambda value: f"{value:,.3f}".replace(",", "'"), "'"),
    ],
)
def test_a_file_that_the_map_of_the_first_does_not_read_is_reported(logs, grouped, mark):
    """The first file has no number of a thousand or more."""
    head = ";".join(f"{name} [{unit}]" for name, unit in zip(NAMES, UNITS, strict=True))
    for trial, load in enumerate((500, 4000, 500), 1):
        write_table(logs / f"50mm_s_{trial}_{load}N.csv", rows_of(load, grouped), head)
    notes = " ".join(suggest_map(logs).notes)
    assert "not read: 50mm_s_2_4000N.csv: line 2: column F [N]: found" in notes
    assert f'format.thousands: "{mark}"' in notes


def test_a_header_within_the_rows_is_reported_with_its_line(logs):
    rows = rows_of(500)
    rows.insert(len(rows) // 2, list(NAMES))
    write_table(logs / "a.csv", rows, ";".join(NAMES))
    with pytest.raises(DataError, match="no file contains a table of numbers") as refused:
        suggest_map(logs)
    assert refused.value.hint.startswith("a.csv: line 177: column t: found 't'; expected a number")


def test_names_in_a_comment_above_a_comment_of_units_are_those_of_the_columns(logs):
    head = ("# bench 3", f"# {' '.join(NAMES)}", f"# {' '.join(UNITS)}")
    write_table(logs / "a.dat", rows_of(500), *head, separator=" ")
    columns = parse_yaml(suggest_map(logs).text)["columns"]
    channels = ("t_s", "x_m", "p_tp_pa", "p_tr_pa", "f_applied_n")
    expected = {
        c: {"column": n, "unit": u} for n, (c, u) in enumerate(zip(channels, UNITS, strict=True), 1)
    }
    assert columns == expected


def test_thousands_that_only_later_times_have_are_found():
    """A time in ms reaches 1.000,0 after a thousand lines: it was no column of numbers."""
    german = str.maketrans(".,", ",.")
    rows = [f"{n:,.1f};{0.1 * n:.2f}".translate(german) for n in range(1200)]
    layout = text_dialect("\n".join(["Zeit;Weg", *rows])).layout
    assert (layout.decimal, layout.thousands) == (",", ".")
    assert text_dialect("\n".join(["Zeit;Weg", *rows[:900]])).layout.thousands is None
