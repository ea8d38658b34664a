"""Coulomb and viscous friction from both directions, where no law is fitted."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hbench.analysis.curves.motion_balance import motion_balances
from hbench.records import Fit
from hbench.report.campaign.page_tables import balance_table

SPEEDS = np.array([0.05, 0.1, 0.2])
COULOMB_N, VISCOUS_N_S_M = 180.0, 900.0


@pytest.fixture
def curves(make_curve):
    """Both directions at three speeds, with pressures; trials scatter by 1 N."""
    rng = np.random.default_rng(3)
    made = []
    for direction in ("extend", "retract"):
        curve = make_curve(SPEEDS, COULOMB_N + VISCOUS_N_S_M * SPEEDS, direction)
        points = []
        for point in curve.points:
            trials = point.friction_n + rng.normal(0, 1.0, 3)
            points.append(
                replace(
                    point,
                    friction_n=float(trials.mean()),
                    n=3,
                    trials=(1, 2, 3),
                    trials_n=tuple(trials.tolist()),
                )
            )
        made.append(replace(curve, points=tuple(points), f_load_n=500.0))
    return made


def test_three_speeds_in_both_directions_give_coulomb_and_viscous_friction(curves):
    (found,) = motion_balances(curves)
    assert found.f_load_n == 500.0 and found.speeds_m_s == pytest.approx(SPEEDS)
    assert abs(found.coulomb_n - COULOMB_N) < found.coulomb_ci95_n < 30
    assert abs(found.viscous_n_s_m - VISCOUS_N_S_M) < found.viscous_ci95_n_s_m < 200
    assert abs(found.offset_n) < found.offset_ci95_n


def test_there_is_none_beside_a_fitted_law_and_none_of_a_single_direction(curves):
    fit = Fit("tustin", {}, {}, True, "")
    assert motion_balances([replace(curve, fits=(fit,)) for curve in curves]) == ()
    assert motion_balances(curves[:1]) == ()
    other = replace(curves[1], p_lr_ref_pa=60e5)
    assert motion_balances([curves[0], other]) == ()


def test_the_table_has_the_load_of_each_series_where_there_is_one(curves):
    light = motion_balances(curves)
    heavy = motion_balances([replace(curve, f_load_n=12000.0) for curve in curves])
    table = balance_table(SimpleNamespace(motion_balances=(*light, *heavy)))
    at = table.head.index("Load (N)")
    assert [row[at].text for row in table.rows] == ["500", "12000"]
    none = tuple(replace(each, f_load_n=None) for each in light)
    assert "Load (N)" not in balance_table(SimpleNamespace(motion_balances=none)).head
