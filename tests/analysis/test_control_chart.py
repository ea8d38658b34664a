"""Control charts against a textbook's numbers, and charts of several cylinders."""

import numpy as np
import pytest

from hbench.analysis.fleet.control_chart import Charted, control_charts
from hbench.records import QUANTITIES

FRICTION = next(q for q in QUANTITIES if q.name == "friction_n")
# Montgomery, Introduction to Statistical Quality Control, 6th edition, 2009, example 6.5: viscosity
# of primer paint.
VISCOSITY = np.array(
    [33.75, 33.05, 34.00, 33.81, 33.46, 34.02, 33.68, 33.27, 33.49, 33.20, 33.62, 33.00, 33.54,
     33.12, 33.84]
)  # fmt: skip


def charted(x, cylinders=None, at=None):
    n = len(x)
    cylinders = np.zeros(n, dtype=int) if cylinders is None else cylinders
    at = np.arange(n, dtype=float) if at is None else at
    charts = control_charts(
        [Charted(FRICTION, None, at, x, cylinders, lambda rows: [f"c{i}" for i in rows])]
    )
    return charts[0] if charts else None


def test_montgomerys_viscosity():
    found = charted(VISCOSITY)
    assert found.centre == pytest.approx(33.52, abs=0.005)
    assert found.limits == pytest.approx((32.24, 34.80), abs=0.01)
    assert 1.128 * found.sigma == pytest.approx(0.48, abs=0.005)
    assert found.outside == () and found.moved == 0 and not found.of_cylinders


def test_a_shift_is_a_signal_and_the_order_is_that_of_the_dates():
    x = np.append(VISCOSITY, 36.0)
    order = np.random.default_rng(1).permutation(16)
    found = charted(x[order], at=np.arange(16.0)[order])
    assert found.values == pytest.approx(x)
    last = f"c{order.tolist().index(15)}"
    assert found.outside == (last,) and (found.beyond, found.moved) == (1, 1)


def test_the_level_of_a_cylinder_is_no_signal_where_several_were_measured_often():
    """Levels 100 apart, scatter 1: the chart has the scatter of the measurement."""
    rng = np.random.default_rng(2)
    cylinders = np.tile(np.arange(4), 25)
    x = 300.0 + 100.0 * cylinders + rng.standard_t(5, size=100) * np.sqrt(3 / 5)
    found = charted(x, cylinders)
    assert found.of_cylinders and found.n == 100
    assert found.sigma == pytest.approx(1.0, rel=0.25)
    assert np.std(found.values, ddof=1) == pytest.approx(1.0, rel=0.25)
    assert found.beyond <= 4
    each_once = charted(x[:12], np.arange(12))
    assert not each_once.of_cylinders and each_once.values == pytest.approx(x[:12])


def test_a_few_campaigns_have_no_chart():
    assert charted(VISCOSITY[:9]) is None


def test_the_limits_are_those_before_a_step_of_the_mean():
    """Ten values about 100 and four about 110, scatter 1: the later ones are beyond the limits."""
    x = np.array([100.0, 101, 99, 100, 101, 100, 99, 101, 100, 99, 110, 111, 109, 110])
    found = charted(x)
    assert found.step.real and found.step.name == "c10"
    assert (found.n, found.n_limits) == (14, 10)
    assert found.centre == pytest.approx(100.0)
    assert found.limits == pytest.approx((100 - 3 * 11 / 9 / 1.128, 100 + 3 * 11 / 9 / 1.128))
    assert found.outside == ("c10", "c11", "c12") and found.beyond == 4 and found.moved == 1
    assert charted(VISCOSITY).n_limits == len(VISCOSITY)
