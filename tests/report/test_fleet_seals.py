"""A fleet of seals, one a campaign: rows, the kind that is compared, and the page."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from hbench.analysis.summary.fleet_numbers import fleet_numbers
from hbench.analysis.summary.headline import at_working_speed, planned_speed_m_s
from hbench.records import FleetRow
from hbench.report.fleet.figures import draw_fleet
from hbench.report.fleet.page import fleet_page
from hbench.report.fleet.row import fleet_row
from hbench.report.fleet.terminal import fleet_text
from hbench.report.fleet.text import campaign_table, fleet_json
from hbench.store.fleet.table import TABLE, cells_of, write_table
from tests.support.analysis.drawn_seal import LARGE, MIDDLE_N_BAR, drawn_seal, of_two_speeds
from tests.support.report.made_fleet import summary_of
from tests.support.report.spaces import ordinary_spaces

LABELS = tuple("ABCDEFGHIJKL")
STEEP = "H"  # its half band rises twice as much over pressure


def row_of(path, results):
    speed = planned_speed_m_s(run.run.plan for run in results.runs)
    results = at_working_speed(results, speed)
    return fleet_row(path, results, fleet_numbers(results))


def fleet_of(folder, rows):
    folder.mkdir(exist_ok=True)
    write_table(folder / TABLE, map(cells_of, rows))
    return summary_of(folder)


@pytest.fixture(scope="module")
def seals():
    """Twelve seals whose strokes have speeds of their own."""
    rng = np.random.default_rng(8)
    return [
        drawn_seal(
            seed,
            label,
            level=4.0 + 0.1 * rng.standard_normal(),
            slope=1.2 if label == STEEP else 0.6,
            speeds=tuple(np.array([8.3e-3, 6e-3]) * rng.uniform(0.95, 1.05)),
        )
        for seed, label in enumerate(LABELS)
    ]


@pytest.fixture(scope="module")
def fleet(seals, tmp_path_factory):
    rows = [row_of(f"/line/{label}", seal) for label, seal in zip(LABELS, seals, strict=True)]
    return fleet_of(tmp_path_factory.mktemp("fleet"), rows)


def test_a_row_has_the_band_at_the_median_pressure_and_the_slope(seals):
    seal = seals[0]
    numbers = row_of("/a", seal).numbers
    band, (trend,) = seal.bands[1], seal.band_trends  # 3 of 1, 3, 5, 7 bar: nothing is interpolated
    for name, values in (
        ("half_band_n", band.trials_half_n),
        ("middle_n", band.trials_middle_n),
        ("cycle_energy_j", band.trials_energy_j),
    ):
        found, half = numbers[name, None], stats.t.ppf(0.975, 4) * stats.sem(values)
        assert found.value == pytest.approx(np.mean(values))
        assert found.se == pytest.approx(stats.sem(values))
        assert (found.low, found.high) == pytest.approx((found.value - half, found.value + half))
    found, line = numbers["half_band_slope_n_pa", None], trend.half
    assert (found.value, found.se) == (line.slope_n_pa, line.slope_se_n_pa)
    assert found.high - found.value == pytest.approx(line.slope_ci95_n_pa)


def test_a_planned_pressure_without_a_band_leaves_out_what_would_be_of_other_pressures(seals):
    seal = seals[0]
    less = replace(seal, bands=seal.bands[:3], band_trends=seal.band_trends)
    assert not [name for name, side in row_of("/a", less).numbers if side is None]


def test_several_seals_of_one_campaign_give_their_mean(seals):
    first, second = seals[:2]
    names = ("runs", "curves", "bands", "band_trends")
    both = replace(
        first, **{name: (*getattr(first, name), *getattr(second, name)) for name in names}
    )
    found = row_of("/a", both).numbers["half_band_n", None].value
    assert found == pytest.approx((first.bands[1].half_n + second.bands[1].half_n) / 2)
    assert row_of("/a", both).label == "A, B"


def test_the_band_of_two_speeds_is_that_at_the_working_speed(seals):
    """The strokes at the working speed and faster ones, whose friction is larger."""
    slow, fast = seals[0], drawn_seal(30, "A", level=9.0, slope=1.5, speeds=(24e-3, 24e-3))
    both = of_two_speeds(slow, fast)
    for speed_m_s, seal in ((8.3e-3, slow), (24e-3, fast)):
        results = at_working_speed(both, speed_m_s)
        numbers = fleet_numbers(results)
        for name in ("half_band_n", "middle_n", "cycle_energy_j", "half_band_slope_n_pa"):
            alone = row_of("/a", seal).numbers[name, None]
            assert numbers[name, None].value == pytest.approx(alone.value)
            assert numbers[name, None].se == pytest.approx(alone.se)


def test_campaigns_that_differ_in_a_single_label_and_in_unset_speeds_are_one_kind(seals, fleet):
    assert (fleet.campaigns, fleet.compared, fleet.other_speeds) == (12, 12, 0)
    assert len(fleet.protocols) == 1
    a, b = seals[:2]
    both = replace(a, runs=(*a.runs, *b.runs))
    assert row_of("/a", both).protocol != row_of("/a", a).protocol
    assert row_of("/a", drawn_seal(1, specimen=LARGE)).protocol != row_of("/a", a).protocol


def test_set_speeds_are_part_of_the_kind():
    def protocol(v):
        seal = drawn_seal(1, speeds=(v, v), speed_is_measured=False)
        return row_of("/a", seal).protocol

    assert protocol(8.3e-3) == protocol(8.3e-3) != protocol(8.5e-3)


def test_a_seal_at_another_speed_is_listed_and_not_compared(seals, tmp_path):
    rows = [row_of(f"/line/{i}", seal) for i, seal in enumerate(seals)]
    fast = drawn_seal(99, "fast", speeds=(12e-3, 9e-3))
    found = fleet_of(tmp_path / "out", [*rows, row_of("/line/fast", fast)])
    assert (found.compared, found.other_speeds) == (12, 1)
    assert [row.label for row in found.rows if not row.compared] == ["fast"]
    (spread,) = (one for one in found.spreads if one.quantity.name == "half_band_n")
    assert spread.n == 12
    table = campaign_table(found)
    assert [row[-1] for row in table.rows] == [""] * 12 + ["not compared: other speed"]


def test_the_time_of_an_import_is_not_that_of_a_measurement(seals):
    assert row_of("/a", seals[0]).started is None


def test_each_seal_has_a_row_with_its_numbers_in_table_page_and_json(seals, fleet):
    assert [row.label for row in fleet.rows] == list(LABELS)
    for seal, row in zip(seals, fleet.rows, strict=True):
        assert row.numbers["half_band_n"].value == pytest.approx(seal.bands[1].half_n)
        assert row.numbers["middle_n"].value == pytest.approx(3 * MIDDLE_N_BAR, abs=0.3)
    document = json.loads(fleet_json(fleet))
    assert [row["label"] for row in document["rows"]] == list(LABELS)
    assert set(document["rows"][0]["numbers"]) >= {"half_band_n", "half_band_slope_n_pa"}
    table = campaign_table(fleet)
    assert [row[1] for row in table.rows] == list(LABELS)
    text = fleet_text(fleet)
    assert text.isascii() and sum(line.startswith(LABELS) for line in text.splitlines()) >= 12
    page = ordinary_spaces(fleet_page(fleet, ()))
    assert all(cell in page for row in table.rows for cell in row)


def test_the_steep_seal_is_the_outlier_by_its_slope(fleet):
    (worst, *_) = fleet.worst
    assert fleet.outliers == 1 and worst.path.endswith(STEEP)
    assert {d.quantity.name for d in worst.deviations if d.outlier} >= {"half_band_slope_n_pa"}


def test_figures_name_the_seals(fleet, undrawn):
    drawings = {drawing.name: drawing for drawing in draw_fleet(fleet)}
    lines = drawings["drift-half-band-n"].csv.decode().splitlines()
    assert [line.split(",")[1] for line in lines[1:]] == list(LABELS)


def test_a_large_fleet_has_no_rows_on_its_page(tmp_path):
    rows = [FleetRow(f"/line/{i:03d}", protocol="x", quality="good") for i in range(501)]
    assert fleet_of(tmp_path / "out", rows).rows == ()


def test_a_copied_campaign_is_listed_and_counts_once(seals, tmp_path):
    rows = [
        replace(row_of(f"/line/{i:02d}", seal), logs_sha256=f"{i:02d}")
        for i, seal in enumerate(seals)
    ]
    copies = [replace(rows[3], path=f"/line/copy-{i}") for i in range(5)]
    once, found = fleet_of(tmp_path / "a", rows), fleet_of(tmp_path / "b", [*rows, *copies])
    assert (found.campaigns, found.compared, found.copies, found.other_speeds) == (17, 12, 5, 0)
    assert (once.copies, once.compared) == (0, 12)
    assert {row.copy_of for row in found.rows if not row.compared} == {"/line/03"}
    for one, other in zip(once.spreads, found.spreads, strict=True):
        assert (one.n, one.between, one.median) == (other.n, other.between, other.median)
    assert "5 of 17 analysed campaigns are copies with the logs of another" in fleet_text(found)


def test_rows_without_logs_are_no_copies(seals, tmp_path):
    rows = [row_of(f"/line/{i}", seal) for i, seal in enumerate(seals)]
    assert fleet_of(tmp_path / "out", rows).copies == 0
