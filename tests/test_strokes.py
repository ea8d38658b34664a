"""Cyclic strokes of made-up seals: bands, energy and slopes against the law that made them."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from hbench.cli.main import app
from hbench.errors import ConfigError, DataError
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


@pytest.fixture(scope="module")
def seals(tmp_path_factory):
    """Return the campaigns of two seals whose strokes have other speeds."""
    folder = tmp_path_factory.mktemp("seals")
    pk = {bar: (half - 1.0 + 0.4 * bar, middle) for bar, (half, middle) in SEAL.items()}
    return tuple(
        stroke_campaign(
            write_strokes(folder / f"{label}-logs", label, bands, v, scatter_n=0.05, seed=seed),
            folder / label,
        )
        for seed, (label, bands, v) in enumerate((("NAP310", SEAL, 0.0203), ("PK", pk, 0.0197)))
    )


def test_two_seals_have_a_difference_with_an_interval(seals, tmp_path):
    done = CliRunner().invoke(app, ["compare", *map(str, seals), "--json", "-o", str(tmp_path)])
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert [(band["label_a"], band["label_b"]) for band in found["bands"]] == [("NAP310", "PK")] * 4
    assert len(found["curves"]) == 8 and found["notes"] == []
    viscous = half_band_n(0.0, 0.0197) - half_band_n(0.0, 0.0203)
    for band, bar in zip(found["bands"], SEAL, strict=True):
        expected = 0.4 * bar - 1.0 + viscous
        assert 0 < band["half_n"]["ci95"] < 0.2
        assert abs(band["half_n"]["difference"] - expected) < 2 * band["half_n"]["ci95"]
        assert not band["middle_n"]["real"]
        energy = energy_j(0.4 * bar - 1.0, 0.0197) - energy_j(0.0, 0.0203)
        assert abs(band["energy_j"]["difference"] - energy) < 2 * band["energy_j"]["ci95"]
    (slope,) = found["band_trends"]
    assert slope["half_slope_n_pa"]["difference"] == pytest.approx(0.4e-5, abs=0.03e-5)
    page = (tmp_path / "comparison.html").read_text()
    assert page.count("<svg") == 1  # half bands over pressure; each curve has one speed


def test_another_tolerance_of_speed_leaves_strokes_unmatched(seals):
    done = CliRunner().invoke(app, ["compare", *map(str, seals), "--speed-tolerance", "1 %"])
    assert isinstance(done.exception, DataError)
    assert "20.3 mm/s" in done.exception.message and "19.7 mm/s" in done.exception.message
    for wrong in ("1 mm", "-1 %", "100 %"):
        arguments = ["compare", *map(str, seals), f"--speed-tolerance={wrong}"]
        assert isinstance(CliRunner().invoke(app, arguments).exception, ConfigError)
