"""Effects that runs detect and distinguish, in tables of the terminal and the page."""

from dataclasses import replace

import pytest

from hbench.records import DetectableSize, EffectPair, PlannedEffects, Separability
from hbench.report.diagnosis.page import diagnosis_page
from hbench.report.diagnosis.tables.separability_tables import (
    matrix_table,
    planned_effects_text,
    sizes_table,
)
from tests.support.reconcile import made_diagnosis as made

NAN = float("nan")
NAMES = ("internal_leakage", "external_leakage", "valve_asymmetry", "supply_droop", "added_mass")
ANGLES = {
    ("internal_leakage", "external_leakage"): (12.4, 1.1, False),
    ("internal_leakage", "valve_asymmetry"): (64.0, 30.0, True),
    ("internal_leakage", "supply_droop"): (90.0, 50.0, True),
    ("internal_leakage", "added_mass"): (88.0, 50.0, True),
    ("external_leakage", "valve_asymmetry"): (67.0, 30.0, True),
    ("supply_droop", "added_mass"): (NAN, NAN, None),
}


@pytest.fixture
def separability():
    sizes = (
        DetectableSize("internal_leakage", "test", 1.05e-3, 3e-3, "l/min/bar", "size"),
        DetectableSize("added_mass", "test", 38.2, 20.0, "kg", "evidence"),
        DetectableSize("end_cushion", "damping", NAN, 1e4, "N s/m", "evidence"),
    )
    pairs = [
        EffectPair(one, other, *ANGLES.get((one, other), (80.0, 40.0, True)))
        for i, one in enumerate(NAMES)
        for other in NAMES[i + 1 :]
    ]
    return Separability(sizes, tuple(pairs))


def test_sizes_have_units_and_say_what_is_not_detectable(separability):
    rows = {row[0].split()[0]: row[1:] for row in sizes_table(separability).rows}
    assert rows["internal_leakage"] == ("l/min/bar", "0.0010 *", "0.0030", "yes")
    assert rows["added_mass"] == ("kg", "38", "20", "no")
    assert rows["end_cushion"][1] == "–" and rows["end_cushion"][3] == "no"
    text = planned_effects_text(PlannedEffects(separability, {}, (), ()))
    assert "*: limited by the least size" in text and "-: not detectable" in text


def test_the_terminal_lists_only_pairs_that_are_not_distinguishable(separability):
    missing = {"rest_time": "runs of the kind breakaway measure it"}
    planned = PlannedEffects(separability, missing, ("a second load",), ("the other direction",))
    text = planned_effects_text(planned)
    text.encode("ascii")
    alike = text.partition("do not distinguish")[2].splitlines()
    rows = [line.split() for line in alike[1:] if "_" in line and "tried" not in line]
    assert rows == [["internal_leakage", "external_leakage", "12", "1.1"]]
    assert "no effect can be named; missing: a second load" in text
    assert "the other direction" in text and "rest_time" in text
    clear = replace(separability, pairs=separability.pairs[1:])
    assert "distinguishable" in planned_effects_text(replace(planned, separability=clear))


def test_the_page_has_the_angles_of_the_effects_that_matter_and_of_the_closest(separability):
    """The pair that is alike is marked, wherever its angle stands."""
    diagnosis = replace(made.named(), separability=separability)
    table = matrix_table(diagnosis)
    assert table.head == ("", *NAMES[:3], "added_mass")
    cells = {row[0]: row[1:] for row in table.rows}
    assert cells["internal_leakage"] == ("–", "12° *", "64°", "88°")
    assert cells["external_leakage"][0] == "12° *"
    assert "supply_droop" not in cells
    page = diagnosis_page(diagnosis, ())
    assert "12° *" in page and table.title in page
    assert table.title not in diagnosis_page(made.named(), ())


def test_where_nothing_is_named_the_pairs_that_are_alike_matter(separability):
    diagnosis = replace(made.unknown(), separability=separability)
    assert matrix_table(diagnosis).head[1:3] == ("internal_leakage", "external_leakage")
    clear = replace(diagnosis, separability=replace(separability, pairs=separability.pairs[1:]))
    assert not matrix_table(clear).rows
