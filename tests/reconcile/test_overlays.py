"""Which signals of held-out runs are drawn: made-up logs whose errors are known."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.reconcile.gaps.gap_map import point_of
from hbench.reconcile.gaps.overlays import overlays
from hbench.reconcile.measured.balances import balance_model
from hbench.records import Run, RunPlan, Specimen
from tests.support.reconcile.rounds import plant_of

SPEEDS = (0.02, 0.06, 0.1)
VALUES = {
    "p_tp_pa": 60e5, "p_tr_pa": 50e5, "p_lp_pa": 40e5, "p_lr_pa": 15e5, "p_s_pa": 150e5,
    "f_applied_n": 2500.0, "u_t_v": 1.0, "u_l1_v": 0.5, "u_l2_v": -1.0,
}  # fmt: skip
SCATTER = 0.01  # of a sample, as a share of these values


def logged(speed, trial, seed=None):
    """A run with noise, or without where there is no ``seed``."""
    n = 200
    noise = 0.0 if seed is None else SCATTER * np.random.default_rng(seed).standard_normal((9, n))
    channels = np.array(list(VALUES.values()))[:, None] * (np.ones((9, n)) + noise)
    t = 0.01 * np.arange(n)
    return Run(
        RunPlan(f"{1e3 * speed:.0f}-{trial}", "steady", trial, speed, Specimen(1e-3, 8e-4)),
        t, 0.05 + speed * t, v_m_s=np.full(n, speed), **dict(zip(VALUES, channels, strict=True)),
    )  # fmt: skip


def simulated(errors):
    """One run of each speed, with errors as multiples of the scatter by speed and channel."""
    runs = [logged(speed, 1) for speed in SPEEDS]
    for (speed, channel), error in errors.items():
        i = SPEEDS.index(speed)
        off = {channel: getattr(runs[i], channel) + error * SCATTER * abs(VALUES[channel])}
        runs[i] = replace(runs[i], **off)
    return runs


@pytest.fixture(scope="module")
def shown(bench):
    measured = [
        logged(speed, trial, seed=10 * i + trial)
        for i, speed in enumerate(SPEEDS)
        for trial in (1, 2, 3)
    ]
    points = frozenset(point_of(run.plan) for run in measured)
    model = balance_model(bench, plant_of(bench))

    def shown(before, after, points=points):
        return overlays(measured, simulated(before), simulated(after), model, points)

    return shown


ERRORS = {(0.06, "p_tp_pa"): 6.0, (0.1, "f_applied_n"): 4.0, (0.06, "f_applied_n"): 1.0}


def test_without_an_addition_the_largest_gaps_are_shown_with_their_runs(shown):
    found = shown(ERRORS, ERRORS)
    assert [(each.signal, each.run) for each in found[:2]] == [
        ("p_tp", "60-1"), ("f_applied", "100-1"),
    ]  # fmt: skip
    assert not any(each.shrank for each in found)
    held_out = frozenset([point_of(logged(0.1, 1).plan)])
    (first, *_) = shown(ERRORS, ERRORS, held_out)
    assert (first.signal, first.run) == ("f_applied", "100-1")


def test_with_an_addition_only_gaps_that_it_reduces_are_shown_most_reduced_first(shown):
    """The largest gap stays as it is and is not shown; that of the load cell falls at 100 mm/s."""
    found = shown(ERRORS, ERRORS | {(0.1, "f_applied_n"): 0.5})
    assert [(each.signal, each.run) for each in found] == [("f_applied", "100-1")]
    assert found[0].shrank


def test_an_addition_that_reduces_no_gap_shows_the_largest_that_remain(shown):
    worse = {key: 2 * error for key, error in ERRORS.items()} | {(0.02, "u_t_v"): 20.0}
    found = shown(ERRORS, worse)
    assert [(each.signal, each.run) for each in found[:2]] == [("u_t", "20-1"), ("p_tp", "60-1")]
    assert not any(each.shrank for each in found)
