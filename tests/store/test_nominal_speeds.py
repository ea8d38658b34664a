"""Nominal speeds of strokes whose speed no name and no map states."""

import numpy as np
import pytest


@pytest.fixture
def imported(rules, import_by, tmp_path):
    """Return a function: the plans of files with times [s] and positions [mm] at 5 bar."""

    def imported(files, **keys):
        (tmp_path / "logs").mkdir()
        for name, (t, x) in files.items():
            rows = np.stack([t, x, 0 * t + 5, 0 * t], axis=1)
            path = tmp_path / "logs" / name
            np.savetxt(path, rows, "%.4f", ",", header="t,x,p,f", comments="")
        units = {"t_s": ("t", "s"), "x_m": ("x", "mm"), "p_tp_pa": ("p", "bar")}
        units["f_applied_n"] = ("f", "N")
        rules["columns"] = {c: {"column": n, "unit": u} for c, (n, u) in units.items()}
        rules["series"][0]["files"] = "*.csv"
        runs, _ = import_by(rules | keys, tmp_path / "logs")
        return [run.plan for run in runs]

    return imported


@pytest.fixture
def nominal(imported):
    """Return a function: nominal speeds [mm/s] of strokes of 60 mm with given speeds [mm/s]."""

    def nominal(*speeds):
        x, t = [20.0], [0.0]
        for number, speed in enumerate(speeds):
            t.append(t[-1] + 60.0 / speed)
            x.append(80.0 if number % 2 == 0 else 20.0)
        times = np.arange(-1.0, t[-1] + 1.0, 0.01)
        positions = np.interp(times, t, x)
        plans = imported({"a.csv": (times + 1.0, positions)}, cut="reversals")
        return [1e3 * plan.v_ref_m_s for plan in plans if plan.v_ref_m_s > 0]

    return nominal


def test_speeds_that_are_repeated_are_not_averaged_with_the_next(nominal):
    """80 and 100 mm/s differ by 20 % of the faster, which strokes of one speed may do."""
    found = nominal(80, 80, 80.2, 80, 100, 100, 100.2, 100)
    assert found == pytest.approx([80.1, 80.1, 100, 100], rel=2e-3)


@pytest.mark.parametrize(
    "speeds",
    [(40, 40, 43, 40, 47, 40, 45, 40), (40, 40, 44, 40)],
    ids=["steps below 5 %", "each speed once"],
)
def test_strokes_of_a_speed_that_is_not_controlled_have_one(nominal, speeds):
    assert len(set(nominal(*speeds))) == 1


def test_a_larger_difference_is_another_speed_even_once(nominal):
    assert nominal(40, 40, 60, 40) == pytest.approx([40, 60], rel=2e-3)


def _ramp(top_mm_s):
    """Rest for 1 s, then rise to a speed in 2 s."""
    t = np.arange(0.0, 3.0, 0.01)
    return t, 20 + top_mm_s / 4 * np.maximum(t - 1, 0) ** 2


def _push(distance_mm):
    """Rest for 1 s, then move ever faster over a distance in a second."""
    t = np.arange(0.0, 2.0, 0.01)
    return t, 20 + distance_mm * np.maximum(t - 1, 0) ** 4


@pytest.mark.parametrize(
    ("kind", "files"),
    [
        ("ramp", [_ramp(60), _ramp(60.6), _ramp(61.2)]),
        ("triangle", [_ramp(60), _ramp(60.6), _ramp(61.2)]),
        ("breakaway", [_push(0.5), _push(0.9), _push(2.5)]),
    ],
)
def test_motions_of_nearly_one_top_speed_and_all_pushes_are_trials_of_one_point(
    imported, kind, files
):
    """By hand no two pushes end at the same speed; each would be a point with a single trial."""
    plans = imported({f"{n}.csv": file for n, file in enumerate(files)}, kind=kind)
    assert [plan.trial for plan in plans] == [1, 2, 3]
    assert len({plan.v_ref_m_s for plan in plans}) == 1


def test_motions_of_other_top_speeds_are_other_points(imported):
    plans = imported({"1.csv": _ramp(60), "2.csv": _ramp(90)}, kind="ramp")
    assert [plan.trial for plan in plans] == [1, 1]
