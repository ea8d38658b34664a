"""The whole way from other people's files to friction, with the shipped examples of maps."""

import re
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.io import savemat

from hbench import workflow
from hbench.config.import_map import parse_import_map
from hbench.errors import ConfigError
from hbench.report.campaign.reasons import cause_of
from hbench.store.campaign.folder import load_campaign

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
    assert (summary.runs, len(summary.notes)) == (9, 1)  # a zero each, one note
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
    assert sum("resampled from 875 samples" in note for note in summary.notes) == 1
    offset = re.compile(r"f_applied_n: zero offset (\S+)")
    (zero,) = filter(None, map(offset.search, summary.notes))
    assert float(zero[1]) == pytest.approx(40.0, abs=1.0)
    assert set(summary.notes) <= set(results.notes)
    (point,) = results.curves[0].points
    assert point.n == 3
    assert point.friction_n == pytest.approx(friction(0.05), abs=1.0)


def test_a_triangle_by_a_map_becomes_a_loop_of_the_static_frictions_energy(tmp_path):
    t = np.arange(0, 24.0, 0.004)
    v = 0.04 * (1 - 4 * np.abs((t / 8 + 0.25) % 1 - 0.5))  # three cycles of 8 s, from rest
    x = 0.15 + np.concatenate(([0], np.cumsum((v[1:] + v[:-1]) / 2 * np.diff(t))))
    force = 200 * np.tanh(v / 0.001) + 900 * v  # no memory
    rng = np.random.default_rng(3)
    p_p = (500 + force) / AREA_P + 1e3 * rng.standard_normal(len(t))
    (tmp_path / "logs").mkdir()
    rows = np.column_stack([t, x + 2e-5 * rng.standard_normal(len(t)), v, p_p])
    np.savetxt(
        tmp_path / "logs/1.csv", rows, delimiter=",", header="t_s,x_m,v_ref_m_s,p", comments=""
    )
    rules = {
        "name": "triangle",
        "kind": "triangle",
        "columns": {
            "t_s": {"column": "t_s"},
            "x_m": {"column": "x_m"},
            "v_ref_m_s": {"column": "v_ref_m_s"},
            "p_tp_pa": {"column": "p", "unit": "Pa"},
        },
        "constants": {"p_tr_pa": "0 bar", "f_applied_n": "500 N"},
        "series": [{"label": "", "files": "{trial}.csv", "cylinder": {"piston_diameter": "40 mm"}}],
        "resample": "100 Hz",
    }
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
    workflow.import_runs(tmp_path / "logs", tmp_path / "out", tmp_path / "map.yaml", CLOCK)
    results = workflow.analyze(tmp_path / "out")
    (run,) = results.runs
    # the highest mean over 10 ms lies up to 10 ms * 0.02 m/s^2 / 2 below the corner
    assert abs(run.run.plan.v_ref_m_s) == pytest.approx(0.04, abs=1.1e-4)
    assert run.accepted, run.reasons
    (loop,) = results.motions.loops
    cycle = t < 8
    energy = np.trapezoid((force * v)[cycle], t[cycle])
    assert loop.area_j == pytest.approx(energy, rel=0.01)


def test_the_top_speed_of_a_triangle_is_measured_where_nothing_states_it(tmp_path):
    (tmp_path / "logs").mkdir()
    t = np.arange(0, 8, 0.01)
    x = 0.1 + 0.03 * np.sin(1.5 * t)
    rows = "".join(f"{a},{b}\n" for a, b in zip(t, x, strict=True))
    (tmp_path / "logs/1.csv").write_text("t_s,x_m\n" + rows)
    rules = {
        "name": "triangle",
        "kind": "triangle",
        "columns": {"t_s": {"column": "t_s"}, "x_m": {"column": "x_m"}},
        "series": [{"label": "", "files": "{trial}.csv", "cylinder": {"piston_diameter": "40 mm"}}],
    }
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
    workflow.import_runs(tmp_path / "logs", tmp_path / "out", tmp_path / "map.yaml", CLOCK)
    (plan,) = load_campaign(tmp_path / "out").plans
    assert abs(plan.v_ref_m_s) == pytest.approx(0.045, rel=0.01)


def test_a_copied_file_is_no_further_trial(tmp_path):
    logs = tmp_path / "logs"
    logs.mkdir()
    for seed, v in enumerate((0.02, 0.05)):
        t, x, p_p, p_r, f = stroke(v, 2000.0, seed)
        rows = zip(1e3 * t, 1e3 * x, p_p / 1e5, p_r / 1e5, (f + 25.0) / 1e3, strict=True)
        text = "Messung\nZeit;Weg;p_A;p_B;Kraft\nms;mm;bar;bar;kN\n"
        text += "".join(";".join(german(cell) for cell in row) + "\n" for row in rows)
        for trial in (1, 2, 3):
            (logs / f"NBR_{1e3 * v:.0f}mm_s_2000N_{trial}.csv").write_bytes(text.encode())
    _, results = imported(tmp_path, "import-csv.yaml")
    assert [run.accepted for run in results.runs] == [True, False, False] * 2
    assert {run.reason.partition(":")[0] for run in results.runs if not run.accepted} == {"copy"}
    assert "of run 0001" in results.runs[1].reason and "of run 0004" in results.runs[5].reason
    assert [point.n for curve in results.curves for point in curve.points] == [1, 1]


def test_fast_strokes_are_accepted_with_the_limits_that_the_report_names(tmp_path):
    """1005 and 1045 mm/s for 1000 mm/s, and a log that ends 0.25 s after the piston moved off."""
    (tmp_path / "logs").mkdir()
    names = ("t_s", "x_m", "p_tp_pa", "p_tr_pa", "f_applied_n")
    for trial, v_m_s, end_s in ((1, 1.005, 3.4), (2, 1.045, 3.4), (3, 1.005, 1.25)):
        log = np.stack(stroke(v_m_s, 1500.0, seed=trial), axis=1)
        log = log[log[:, 0] < end_s]
        file = tmp_path / f"logs/1000_{trial}.csv"
        np.savetxt(file, log, "%.8g", ",", header=",".join(names), comments="")
    size = {"piston_diameter": "40 mm", "rod_diameter": "25 mm"}
    rules = {
        "name": "fast",
        "columns": {name: {"column": name} for name in names},
        "series": [{"label": "A", "files": "{speed}_{trial}.csv", "cylinder": size}],
    }
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
    workflow.import_runs(tmp_path / "logs", tmp_path / "out", tmp_path / "map.yaml", CLOCK)
    results = workflow.analyze(tmp_path / "out")
    assert [run.accepted for run in results.runs] == [True, False, False]
    causes = cause_of(results, "off_reference") + cause_of(results, "too_short")
    limits = {"settle_time": "0.05 s", "min_window": "0.1 s", "low_speed_error_relative": "5 %"}
    assert all(f"screening.{key}" in causes for key in limits)
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules | {"screening": limits}))
    workflow.import_runs(tmp_path / "logs", tmp_path / "out2", tmp_path / "map.yaml", CLOCK)
    (curve,) = workflow.analyze(tmp_path / "out2").curves
    assert curve.points[0].friction_n == pytest.approx(friction(1.018), rel=0.01)
    assert curve.points[0].n == 3


@pytest.mark.parametrize(
    ("stated", "accepted"), [({}, True), ({"high_speed_error": "2 mm/s"}, False)]
)
def test_the_sources_limit_of_the_speed_is_that_of_its_own_bench(tmp_path, stated, accepted):
    """A limit that the map states holds as it is; an export keeps the limits of the map."""
    (tmp_path / "logs").mkdir()
    names = ("t_s", "x_m", "p_tp_pa", "p_tr_pa", "f_applied_n")
    log = np.stack(stroke(0.505, 1500.0, seed=1), axis=1)
    np.savetxt(tmp_path / "logs/500_1.csv", log, "%.8g", ",", header=",".join(names), comments="")
    size = {"piston_diameter": "40 mm", "rod_diameter": "25 mm"}
    rules = {
        "name": "fast",
        "columns": {name: {"column": name} for name in names},
        "series": [{"label": "A", "files": "{speed}_{trial}.csv", "cylinder": size}],
        "screening": {"settle_time": "0.2 s"} | stated,
    }
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
    workflow.import_runs(tmp_path / "logs", tmp_path / "out", tmp_path / "map.yaml", CLOCK)
    workflow.export(tmp_path / "out", tmp_path / "csv", "csv")
    workflow.import_runs(tmp_path / "csv", tmp_path / "again", None, CLOCK)
    for campaign in ("out", "again"):
        (run,) = workflow.analyze(tmp_path / campaign).runs
        assert run.accepted is accepted
    with pytest.raises(ConfigError, match="high_speed_error.* must be at most"):
        parse_import_map(rules | {"screening": {"high_speed_error": "100 m/s"}}, "map")
