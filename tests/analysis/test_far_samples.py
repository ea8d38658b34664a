"""Samples far from all others: the mean with them differs from the friction by no more than U."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.curves.average import curves
from hbench.analysis.screening.limitations import not_computed
from hbench.analysis.screening.screen import screen
from hbench.analysis.uncertainty.budget import with_instruments
from hbench.analysis.uncertainty.input_errors import is_of_log
from hbench.config.sensors import Instruments

FRICTION_N = 300.0
EXACT = Instruments.model_validate(
    {
        "force": {"tolerance": "0.01 %", "of": "full_scale", "full_scale": "10 kN"},
        "pressure": {"tolerance": "0.01 %", "of": "full_scale", "full_scale": "160 bar"},
    }
)


@pytest.fixture
def trials(make_run, rules):
    """Return a function that screens three trials, whose piston-side pressure drops to 0 bar.

    It does in ``dropouts`` of about 160 samples of each window.
    """

    def make(dropouts):
        rng = np.random.default_rng(1)
        runs = []
        for trial in (1, 2, 3):
            run = make_run(v_m_s=0.1, friction_n=FRICTION_N + rng.normal(0, 3), noise=1.0)
            p_tp = run.p_tp_pa.copy()
            p_tp[100 + trial : 100 + trial + 10 * dropouts : 10] = 0.0
            plan = replace(run.plan, run=f"{trial:04d}", trial=trial)
            runs.append(screen(replace(run, plan=plan, p_tp_pa=p_tp), rules))
        return runs

    return make


@pytest.mark.parametrize("dropouts", [0, 1])
def test_friction_without_dropouts_is_within_u_of_a_mean_with_them(trials, dropouts):
    screened = trials(dropouts)
    assert all(run.accepted for run in screened)
    (curve,) = curves(screened)
    (point,) = with_instruments(curve, EXACT).points
    assert abs(point.friction_n - FRICTION_N) < point.u95_n
    assert (point.friction_n < FRICTION_N - 15) == bool(dropouts)
    own = [part for name, part in point.parts_n.items() if is_of_log(name)]
    shift_n = point.friction_n - FRICTION_N
    assert own == ([pytest.approx(shift_n / 3**0.5, abs=3)] if dropouts else [])


def test_a_note_counts_the_samples_and_states_what_they_change(trials):
    assert not_computed(trials(0), (), EXACT) == ()
    (note,) = not_computed(trials(1), (), EXACT)
    assert note.startswith("3 samples in 3 of 3 runs are far from all others")
    assert "change mean friction by up to -2" in note and "this is part of U" in note
