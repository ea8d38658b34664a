"""Cyclic strokes of made-up seals: bands, energy and slopes against the law that made them."""

import numpy as np
import pytest

from hbench.store.campaign.folder import load_campaign
from hbench.workflow.results import derive
from tests.support.seal_strokes import energy_j, half_band_n, stroke_campaign, write_strokes

SPEED = 0.02
SEAL = {1: (4.0, -0.5), 3: (6.0, -1.5), 5: (9.0, -3.5), 7: (10.0, -3.5)}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("strokes")
    logs = write_strokes(folder / "logs", "A", SEAL, SPEED)
    return derive(load_campaign(stroke_campaign(logs, folder / "campaign")))


def test_half_band_middle_and_energy_are_those_of_the_law(results):
    assert [run.reason for run in results.runs if not run.accepted] == []
    assert [band.n for band in results.bands] == [5] * 4
    for band, (bar, (half, middle)) in zip(results.bands, SEAL.items(), strict=True):
        assert band.p_tp_pa == pytest.approx(bar * 1e5)
        assert band.half_n == pytest.approx(half_band_n(half, SPEED), rel=1e-6)
        assert band.middle_n == pytest.approx(middle, abs=1e-5)
        assert len(band.trials_energy_j) == 5
        assert band.energy_j == pytest.approx(energy_j(half, SPEED), rel=2e-4)


def test_the_slopes_over_pressure_are_those_of_a_plain_regression(results):
    (trend,) = results.band_trends
    halves, middles = zip(*SEAL.values(), strict=True)
    for line, forces in ((trend.half, halves), (trend.middle, middles)):
        slope, _ = np.polyfit([1e5 * bar for bar in SEAL], forces, 1)
        assert line.slope_n_pa == pytest.approx(slope, rel=1e-5)


def test_a_pause_of_the_log_leaves_the_stroke_without_energy_and_not_without_friction(tmp_path):
    logs = write_strokes(tmp_path / "logs", "A", {1: SEAL[1]}, SPEED)
    (log,) = logs.glob("*.csv")
    head, *rows = log.read_text().splitlines()
    t, x = np.loadtxt(rows, delimiter=",", usecols=(0, 1)).T
    pause = (t > 5.2) & (t < 5.4)  # as the second extension begins, before its window
    assert x[pause].max() < 5.0
    log.write_text("\n".join([head, *np.array(rows)[~pause], ""]))
    results = derive(load_campaign(stroke_campaign(logs, tmp_path / "campaign")))
    (band,) = results.bands
    assert (band.n, len(band.trials_energy_j)) == (5, 4)
    assert band.energy_j == pytest.approx(energy_j(4.0, SPEED), rel=2e-4)
