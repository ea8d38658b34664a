"""Nominal speeds of strokes whose speed no name and no map states."""

import numpy as np
import pytest


@pytest.fixture
def nominal(rules, import_by, tmp_path):
    """Return a function: nominal speeds [mm/s] of strokes of 60 mm with given speeds [mm/s]."""

    def nominal(*speeds):
        x, t = [20.0], [0.0]
        for number, speed in enumerate(speeds):
            t.append(t[-1] + 60.0 / speed)
            x.append(80.0 if number % 2 == 0 else 20.0)
        times = np.arange(-1.0, t[-1] + 1.0, 0.01)
        positions = np.interp(times, t, x)
        rows = np.stack([times + 1.0, positions, 0 * times + 5, 0 * times], axis=1)
        (tmp_path / "logs").mkdir()
        np.savetxt(tmp_path / "logs/a.csv", rows, "%.4f", ",", header="t,x,p,f", comments="")
        units = {"t_s": ("t", "s"), "x_m": ("x", "mm"), "p_tp_pa": ("p", "bar")}
        units["f_applied_n"] = ("f", "N")
        rules["columns"] = {c: {"column": n, "unit": u} for c, (n, u) in units.items()}
        rules["cut"] = "reversals"
        runs, _ = import_by(rules, tmp_path / "logs")
        return [1e3 * run.plan.v_ref_m_s for run in runs if run.plan.v_ref_m_s > 0]

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
