"""Import of real measurements, where they are at hand."""

from collections import Counter, defaultdict
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from hbench.store.campaign.folder import load_campaign
from hbench.store.importing.importer import import_folder

ROOT = Path(__file__).parents[2]
DATA = ROOT.parent / "shared" / "data" / "tudelft-cylinder"

# Half of the friction band [N] by pressure [bar], computed independently (the data's README).
HALF_BAND_N = {
    "O-ring": {1: 4.0, 3: 5.6, 5: 7.2, 7: 8.0},
    "NAPN": {1: 3.3, 3: 6.9, 5: 9.8, 7: 11.9},
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    if not DATA.is_dir():
        pytest.skip(f"the TU Delft measurements are not at {DATA}")
    out = tmp_path_factory.mktemp("tudelft") / "campaign"
    at = datetime(2024, 5, 1, tzinfo=UTC)
    summary = import_folder(DATA, out, ROOT / "configs" / "tudelft.yaml", {}, at)
    assert summary.files == 20
    return list(load_campaign(out).runs())


def pressure_bar(run):
    return round(run.plan.f_load_n / run.plan.specimen.area_piston_m2 / 1e5, 6)


def test_nine_whole_strokes_each_way_in_every_file(runs):
    """Of the reruns, a file is a trial; of single files, a stroke is one."""
    counts = Counter((r.plan.label, pressure_bar(r), r.plan.trial, r.plan.direction) for r in runs)
    reruns = {key: count for key, count in counts.items() if key[0] == "O-ring 25.7 mm"}
    assert len(reruns) == 24 and set(reruns.values()) == {9}  # 12 files, both directions
    # One stroke of the eight files settles late and covers two thirds of the others' positions.
    assert len(counts) - 24 == 8 * 9 * 2 - 1


def test_three_trials_of_the_rerun_at_each_pressure(runs):
    trials = {(pressure_bar(r), r.plan.trial) for r in runs if r.plan.label == "O-ring 25.7 mm"}
    assert trials == {(p, trial) for p in (1, 3, 5, 7) for trial in (1, 2, 3)}


def test_measured_pressure_is_near_the_one_in_the_file_name(runs):
    for run in runs:
        assert np.mean(run.p_tp_pa) / 1e5 == pytest.approx(pressure_bar(run), abs=0.15)


def test_half_of_the_friction_band_is_as_computed_elsewhere(runs):
    means = defaultdict(list)
    for run in runs:
        part = (run.x_m - run.x_m[0]) / (run.x_m[-1] - run.x_m[0])
        middle = (part > 0.25) & (part < 0.75)
        friction = run.p_tp_pa * run.plan.specimen.area_piston_m2 - run.f_applied_n
        key = run.plan.label, pressure_bar(run), run.plan.direction
        means[key].append(friction[middle].mean())
    for label, by_pressure in HALF_BAND_N.items():
        for pressure, expected in by_pressure.items():
            extend, retract = (
                np.mean(means[label, pressure, way]) for way in ("extend", "retract")
            )
            assert (extend - retract) / 2 == pytest.approx(expected, abs=0.15)
            assert extend > 0 > retract
