"""The whole way from other people's files to friction, with the shipped examples of maps."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from hbench import workflow

CONFIGS = Path(__file__).parents[1] / "configs"
AREA_P, AREA_R = np.pi / 4 * 0.04**2, np.pi / 4 * (0.04**2 - 0.025**2)
CLOCK = lambda: datetime(2026, 1, 1, tzinfo=UTC)  # noqa: E731


def friction(v_m_s):
    """A Stribeck curve of Gaussian form [N]."""
    return 150 + 90 * np.exp(-((v_m_s / 0.03) ** 2)) + 900 * v_m_s


def stroke(v_m_s, load_n, seed, rate_hz=250.0, rest_s=1.0):
    """A stroke after a rest without load: t [s], x [m], P_p, P_r [Pa], F_applied [N]; uneven."""
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.5, 1.5, round((rest_s + 2.5) * rate_hz))) / rate_hz
    moving = t > rest_s
    x = 0.01 + v_m_s * np.maximum(0, t - rest_s)
    p_r = np.where(moving, 8e5, 0.0)
    p_p = np.where(moving, (load_n + friction(v_m_s) + 8e5 * AREA_R) / AREA_P, 0.0)
    noise = rng.standard_normal((4, len(t)))
    x = x + 1e-5 * noise[0]
    return t, x, p_p + 2e3 * noise[1], p_r + 2e3 * noise[2], load_n * moving + 3 * noise[3]


def german(value):
    """1234.5678 as 1.234,57."""
    return f"{value:,.3f}".translate(str.maketrans(",.", ".,"))


def imported(tmp_path, map_name):
    arguments = tmp_path / "logs", tmp_path / "campaign", CONFIGS / map_name, CLOCK
    summary = workflow.import_runs(*arguments)
    return summary, workflow.analyze(tmp_path / "campaign")


def test_a_german_loggers_files_become_a_stribeck_curve(tmp_path):
    (tmp_path / "logs").mkdir()
    speeds = (0.02, 0.05, 0.1)
    for seed, (v, trial) in enumerate((v, trial) for v in speeds for trial in (1, 2, 3)):
        t, x, p_p, p_r, f = stroke(v, 2000.0, seed)
        rows = zip(1e3 * t, 1e3 * x, p_p / 1e5, p_r / 1e5, (f + 25.0) / 1e3, strict=True)
        text = "Messung vom 3.5.2024, Prüfstand 2\nZeit;Weg;p_A;p_B;Kraft\nms;mm;bar;bar;kN\n"
        text += "".join(";".join(german(cell) for cell in row) + "\n" for row in rows)
        name = f"NBR_{1e3 * v:.0f}mm_s_2000N_{trial}.csv"
        (tmp_path / "logs" / name).write_bytes(text.encode("latin-1"))
    summary, results = imported(tmp_path, "import-csv.yaml")
    assert (summary.runs, len(summary.notes)) == (9, 9)  # a zero each
    assert all(run.accepted for run in results.runs), [run.reasons for run in results.runs]
    (curve,) = results.curves
    assert (curve.f_load_n, curve.label) == (2000.0, "NBR")
    for v, point in zip(speeds, curve.points, strict=True):
        assert point.n == 3 and point.v_m_s == pytest.approx(v, rel=1e-3)
        assert point.friction_n == pytest.approx(friction(v), abs=1.0)


def test_matlab_files_with_a_bridges_voltage_become_friction(tmp_path):
    (tmp_path / "logs").mkdir()
    newton_per_volt = 4 * 200e-6 * 210e9 / (2 * 5 * 2.1 * 1.3 * 100)  # C.6
    for trial in (1, 2, 3):
        t, x, p_p, p_r, f = stroke(0.05, 3000.0, 100 + trial)
        psi = np.column_stack([p_p, p_r]) / 6894.757293168361
        bridge = 1e3 * (f + 40.0) / newton_per_volt
        data = {"t": t, "stroke": 1e3 * x, "p": psi, "bridge": bridge}
        savemat(tmp_path / "logs" / f"run_{trial}.mat", {"data": data}, oned_as="column")
    summary, results = imported(tmp_path, "import-mat.yaml")
    assert sum("resampled from 875 samples" in note for note in summary.notes) == 3
    zeros = [float(note.split()[2]) for note in summary.notes if "f_applied_n" in note]
    np.testing.assert_allclose(zeros, [40.0] * 3, atol=1.0)
    assert set(summary.notes) <= set(results.notes)
    (point,) = results.curves[0].points
    assert point.n == 3
    assert point.friction_n == pytest.approx(friction(0.05), abs=1.0)
