"""The whole way from another bench's logs to friction against pressure, on real measurements."""

import re
import shutil
from datetime import UTC, datetime
from html import unescape
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy import stats

from hbench import workflow
from hbench.store.campaign.folder import load_campaign

ROOT = Path(__file__).parents[1]
DATA = ROOT.parent / "shared" / "data" / "tudelft-cylinder"

pytestmark = pytest.mark.skipif(
    not DATA.is_dir(), reason="the TU Delft measurements are not beside the checkout"
)

# Half of the friction band [N] at 1, 3, 5, 7 bar, computed independently (the data's own README).
HALF_BANDS = {"O-ring": (4.0, 5.6, 7.2, 8.0), "NAPN": (3.3, 6.9, 9.8, 11.9)}


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tudelft") / "campaign"
    clock = lambda: datetime(2026, 1, 1, tzinfo=UTC)  # noqa: E731
    workflow.import_runs(DATA, folder, ROOT / "configs" / "tudelft.yaml", clock)
    return folder, workflow.report(folder)


def points(results, label, direction):
    curves = [c for c in results.curves if (c.label, c.direction) == (label, direction)]
    found = [c.points[0] for c in sorted(curves, key=lambda c: c.f_load_n)]
    assert len(found) == 4
    return found


@pytest.mark.parametrize("label", HALF_BANDS)
def test_half_of_the_friction_band_is_the_known_one_for_both_seals(campaign, label):
    half = [band.half_n for band in campaign[1].bands if band.label == label]
    np.testing.assert_allclose(half, HALF_BANDS[label], rtol=0.03)


def test_three_reruns_are_three_trials_with_an_interval(campaign):
    for direction in ("extend", "retract"):
        for point in points(campaign[1], "O-ring 25.7 mm", direction):
            assert point.n == 3 and len(point.runs) > 20
            expected = 4.303 * np.std(point.trials_n, ddof=1) / np.sqrt(3)
            assert point.ci95_n == pytest.approx(expected, rel=1e-3)


def test_the_band_of_three_reruns_has_the_interval_of_its_trials(campaign):
    bands = [band for band in campaign[1].bands if band.label == "O-ring 25.7 mm"]
    assert [round(band.p_tp_pa / 1e5) for band in bands] == [1, 3, 5, 7]
    assert [band.n for band in bands] == [3] * 4
    for band in bands:
        halves = (np.array(band.extend.trials_n) - band.retract.trials_n) / 2
        expected = stats.t.ppf(0.975, 2) * np.std(halves, ddof=1) / np.sqrt(3)
        assert band.half_ci95_n == pytest.approx(expected) and 0.5 < expected < 4


def test_friction_opposes_the_motion_and_strokes_of_a_file_are_its_trials(campaign):
    for label in HALF_BANDS:
        for direction, sign in (("extend", 1), ("retract", -1)):
            for point in points(campaign[1], label, direction):
                assert sign * point.friction_n > 0 and sign * point.v_m_s > 0
                assert point.n in (7, 8, 9) and 0 < point.ci95_n < 0.1 * abs(point.friction_n)


def test_strokes_with_a_gap_in_the_log_are_left_out_with_the_reason(campaign):
    rejected = [run for run in campaign[1].runs if not run.accepted]
    assert rejected and all(run.reasons[0].startswith("gapped") for run in rejected)
    assert len(rejected) < 0.02 * len(campaign[1].runs)


def test_the_report_shows_friction_against_pressure(campaign):
    results = campaign[0] / "results"
    assert "friction-pressure" in (results / "report.html").read_text()
    assert (results / "figures" / "friction-pressure.svg").stat().st_size > 10_000


def test_the_strokes_left_out_are_those_whose_lines_have_a_pause_in_the_file(campaign):
    """The log pauses 0.3 s now and then; two pauses fall into a steady window."""
    origins = {entry.plan.run: entry.origin for entry in load_campaign(campaign[0]).entries}
    rejected = [one for one in campaign[1].runs if not one.accepted]
    assert [one.run.plan.label for one in rejected] == ["NAPN", "NAPN"]
    for one in rejected:
        origin = origins[one.run.plan.run]
        first, last = origin["lines"]
        t_ms = np.loadtxt(DATA / origin["file"], usecols=0)[first - 1 : last]
        pause = np.diff(t_ms).max() / 1e3
        assert pause > 0.1
        (reason,) = one.reasons
        assert re.match(rf"gapped: {pause:.2f} s .* 0\.1 s$", reason)


def half_bands_from_the_files(bar):
    """Half of the band [N] of each rerun, from the middle half of each stroke, with numpy alone."""
    area, halves = np.pi / 4 * 0.0257**2, []
    for trial in (1, 2, 3):
        rows = np.loadtxt(DATA / "rerun" / f"{trial}_O-ring257_{bar}bar.csv")[15:]
        x, friction = -rows[:, 4], rows[:, 5] * 1e5 * area - rows[:, 6]
        low, high = np.quantile(x, [0.01, 0.99])
        inside = (x > low + 0.25 * (high - low)) & (x < high - 0.25 * (high - low))
        ahead = np.roll(x, -10) - np.roll(x, 10)
        out, back = friction[inside & (ahead > 0)], friction[inside & (ahead < 0)]
        halves.append((out.mean() - back.mean()) / 2)
    return np.array(halves)


@pytest.mark.parametrize("bar", [1, 3, 5, 7])
def test_the_interval_of_the_reruns_is_that_of_the_plain_files(campaign, bar):
    halves = half_bands_from_the_files(bar)
    interval = stats.t.ppf(0.975, 2) * halves.std(ddof=1) / np.sqrt(3)
    bands = [band for band in campaign[1].bands if band.label == "O-ring 25.7 mm"]
    (band,) = (band for band in bands if round(band.p_tp_pa / 1e5) == bar)
    # the windows differ: this one is the middle half, the analysis' begins after 0.3 s and 8 mm
    assert band.half_n == pytest.approx(halves.mean(), abs=0.2 * interval)
    assert band.half_ci95_n == pytest.approx(interval, rel=0.15)


def energies_from_the_file(name, bore_m):
    """Energy [J] of each cycle from one innermost position to the next, with numpy alone."""
    rows = np.loadtxt(DATA / name)[15:]
    x, friction = -rows[:, 4] / 1e3, rows[:, 5] * 1e5 * np.pi / 4 * bore_m**2 - rows[:, 6]
    inside = x < x.min() + 0.1 * np.ptp(x)
    edges = np.flatnonzero(np.diff(inside.astype(int)))
    starts = edges[~inside[edges]]  # from outside to inside
    turns = [i + np.argmin(x[i : i + 150]) for i in starts]
    return np.array(
        [
            np.sum((friction[a:b] + friction[a + 1 : b + 1]) / 2 * np.diff(x[a : b + 1]))
            for a, b in zip(turns, turns[1:], strict=False)
        ]
    )


@pytest.mark.parametrize(
    ("label", "name", "bore_m"),
    [
        ("O-ring", "friction/O-ring_1bar.csv", 0.025),
        ("NAPN", "friction/NAPN_3bar.csv", 0.025),
        ("O-ring 25.7 mm", "rerun/2_O-ring257_5bar.csv", 0.0257),
    ],
)
def test_the_energy_of_a_cycle_is_that_of_the_plain_file(campaign, label, name, bore_m):
    cycles = energies_from_the_file(name, bore_m)
    assert len(cycles) >= 8
    bar, rerun = int(name[-8]), "rerun" in name
    bands = [band for band in campaign[1].bands if band.label == label]
    (band,) = (band for band in bands if round(band.p_tp_pa / 1e5) == bar)
    energy = band.trials_energy_j[1] if rerun else band.energy_j  # of the trials 1, 2, 3
    assert energy == pytest.approx(cycles.mean(), rel=0.02)
    if not rerun:
        spread = stats.t.ppf(0.975, len(cycles) - 1) * cycles.std(ddof=1) / np.sqrt(len(cycles))
        assert band.energy_ci95_j == pytest.approx(spread, rel=0.35)


def test_the_middle_falls_with_pressure_as_the_data_states(campaign):
    """The data's README: 0.36 and 0.51 N/bar, with the force's sign turned."""
    slopes = {t.label: 1e5 * t.middle.slope_n_pa for t in campaign[1].band_trends}
    assert slopes["O-ring"] == pytest.approx(-0.36, abs=0.02)
    assert slopes["NAPN"] == pytest.approx(-0.51, abs=0.02)


@pytest.fixture(scope="module")
def one_each(tmp_path_factory):
    """A campaign for each seal, as their owner would make them."""
    folder = tmp_path_factory.mktemp("one-each")
    rules = yaml.safe_load((ROOT / "configs" / "tudelft.yaml").read_text())
    clock = lambda: datetime(2026, 1, 1, tzinfo=UTC)  # noqa: E731
    for series in rules["series"]:
        name = series["label"].replace(" ", "-")
        map_file = folder / f"{name}.yaml"
        map_file.write_text(yaml.safe_dump(rules | {"series": [series]}))
        workflow.import_runs(DATA, folder / "seals" / name, map_file, clock)
    return folder / "seals"


def test_two_seals_differ_by_the_known_half_bands_and_slopes(one_each):
    found = workflow.compare(one_each / "O-ring", one_each / "NAPN")
    assert len(found.curves) == 8 and found.notes == ()
    known = np.subtract(HALF_BANDS["NAPN"], HALF_BANDS["O-ring"])
    for band, difference in zip(found.bands, known, strict=True):
        assert band.half_n.value == pytest.approx(difference, abs=0.15)  # known to 0.1 N each
        assert 0 < band.half_n.ci95 < 0.4 and band.half_n.real
    (slope,) = found.band_trends
    expected = np.polyfit([1, 3, 5, 7], known, 1)[0]
    assert slope.half_slope_n_pa.value * 1e5 == pytest.approx(expected, abs=0.03)
    assert slope.half_slope_n_pa.real and slope.half_slope_n_pa.ci95 * 1e5 < 0.5


def test_another_bore_is_compared_where_the_speeds_agree(one_each):
    """Speeds differ by 27 % at 1 bar and by 18 % at most at 7 bar."""
    found = workflow.compare(one_each / "O-ring", one_each / "O-ring-25.7-mm")
    assert [round(band.a.p_tp_pa / 1e5) for band in found.bands] == [7]
    assert len(found.notes) == 6 and found.band_trends == ()
    every = workflow.compare(one_each / "O-ring", one_each / "O-ring-25.7-mm", speed_tolerance=0.85)
    assert len(every.bands) == 4 and len(every.band_trends) == 1
    assert not any(band.half_n.real for band in every.bands)  # three reruns scatter by 1 to 3.5 N


def test_a_fleet_has_a_row_for_each_seal_and_compares_those_of_one_bore(
    one_each, tmp_path, one_process
):
    silent = {"report": lambda *counts: None, "note": lambda text: None}
    fleet = workflow.analyze_fleet(
        [str(one_each)], tmp_path / "fleet", scheduler=None, speed_m_s=None, **silent
    )
    rows = {row.label: row for row in fleet.rows}
    assert {label: row.compared for label, row in rows.items()} == {
        "NAPN": True, "O-ring": True, "O-ring 25.7 mm": False
    }  # fmt: skip
    for label, halves in HALF_BANDS.items():
        numbers = rows[label].numbers
        assert numbers["half_band_n"].value == pytest.approx(halves[1], rel=0.03)  # 3 bar
        slope = np.polyfit([1, 3, 5, 7], halves, 1)[0]
        assert numbers["half_band_slope_n_pa"].value * 1e5 == pytest.approx(slope, rel=0.03)


def test_no_file_is_another_ones_copy_and_a_copy_is_noticed(campaign, tmp_path):
    names = [f"rerun/{k}_O-ring257_3bar.csv" for k in (1, 3)]
    assert not [note for note in campaign[1].notes if any(name in note for name in names)]
    shutil.copytree(DATA, tmp_path / "logs")
    original, copy = (tmp_path / "logs" / name for name in names)
    copy.write_bytes(original.read_bytes())
    clock = lambda: datetime(2026, 1, 1, tzinfo=UTC)  # noqa: E731
    map_file = ROOT / "configs" / "tudelft.yaml"
    summary = workflow.import_runs(tmp_path / "logs", tmp_path / "out", map_file, clock)
    assert [note for note in summary.notes if all(name in note for name in names)]


def test_what_one_pressure_and_no_bench_file_leave_open_is_named(campaign):
    (open_,) = (note for note in campaign[1].notes if "not contain the instruments" in note)
    assert "tolerances" in open_ and "bench" in open_
    assert f"{open_[:1].upper()}{open_[1:]}" in unescape(
        (campaign[0] / "results" / "report.html").read_text()
    )


def test_print_the_table_of_the_seals(campaign):
    """Printed with -s; what it says is asserted above."""
    print("\nseal            bar   extending  retracting  half band   middle  trials [N, 95 %]")
    for band in campaign[1].bands:

        def with_interval(value, half):
            return f"{value:6.2f}" + ("      " if half is None else f" ±{half:4.2f}")

        print(
            f"{band.label:14} {band.p_tp_pa / 1e5:4.2f}"
            f" {with_interval(band.extend.friction_n, band.extend.ci95_n)}"
            f" {with_interval(band.retract.friction_n, band.retract.ci95_n)}"
            f" {with_interval(band.half_n, band.half_ci95_n)} {band.middle_n:8.2f} {band.n:4}"
        )
    assert len(campaign[1].bands) == 12
