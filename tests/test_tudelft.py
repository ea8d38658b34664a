"""The whole way from another bench's logs to friction against pressure, on real measurements."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from hbench import workflow

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
    np.testing.assert_allclose(half, HALF_BANDS[label], atol=0.15)


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
    half_widths = [band.half_ci95_n for band in bands]
    np.testing.assert_allclose(half_widths, (0.89, 1.43, 2.42, 3.09), atol=0.02)


def test_friction_opposes_the_motion_and_single_runs_have_no_interval(campaign):
    for label in HALF_BANDS:
        for direction, sign in (("extend", 1), ("retract", -1)):
            for point in points(campaign[1], label, direction):
                assert sign * point.friction_n > 0 and sign * point.v_m_s > 0
                assert point.n == 1 and point.ci95_n is None


def test_strokes_with_a_gap_in_the_log_are_left_out_with_the_reason(campaign):
    rejected = [run for run in campaign[1].runs if not run.accepted]
    assert rejected and all(run.reasons[0].startswith("gapped") for run in rejected)
    assert len(rejected) < 0.02 * len(campaign[1].runs)


def test_the_report_shows_friction_against_pressure(campaign):
    results = campaign[0] / "results"
    assert "Friction against pressure" in (results / "report.html").read_text()
    assert (results / "figures" / "friction-pressure.png").stat().st_size > 10_000
