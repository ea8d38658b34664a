"""Learned laws on made-up logs: laws of other forms than tables, and friction that wanders."""

from types import SimpleNamespace

import numpy as np
import pytest

from hbench.config.bench import parse_plant
from hbench.reconcile.evidence.likelihood import Priors
from hbench.reconcile.evidence.window_sums import products
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.gaps.log_map import Windows, log_map
from hbench.reconcile.learned.balance_products import BalanceProducts
from hbench.reconcile.learned.law_search import (
    best_tables,
    is_worse,
    reductions,
    sign_test,
    table_threshold,
)
from hbench.reconcile.learned.table import Table, empty_table
from hbench.reconcile.measured.balances import BALANCES, balance_model
from hbench.reconcile.measured.session import Session
from hbench.reconcile.measured.weak import window

POINTS, TRIALS, SAMPLES, DT_S = 24, 2, 400, 5e-3
BALANCES_OF_ONE = ("force_test",)
MATERIAL = 0.3  # scatters


def logs(seed) -> Session:
    """Strokes at several speeds, starts and loads, one after another."""
    rng = np.random.default_rng(seed)
    t = np.arange(SAMPLES) * DT_S
    x, v, p_tp, p_tr = [], [], [], []
    for i in range(POINTS * TRIALS):
        point = i % POINTS
        speed = (-1) ** point * 0.02 * (1 + point % 4)
        start = 0.05 if speed > 0 else 0.3
        x.append(start + speed * t)
        v.append(np.full(SAMPLES, speed))
        p_tr.append(np.full(SAMPLES, 10e5 + 8e5 * (point % 3)))
        p_tp.append(p_tr[-1] + 3e5 * (point % 5) + rng.normal(0, 1e4, SAMPLES))
    still = np.zeros(POINTS * TRIALS * SAMPLES)
    names = ("p_lp_pa", "p_lr_pa", "p_s_pa", "u_t_v", "u_l1_v", "u_l2_v", "f_applied_n")
    channels = dict.fromkeys(names, still) | {
        "x_m": np.concatenate(x),
        "p_tp_pa": np.concatenate(p_tp),
        "p_tr_pa": np.concatenate(p_tr),
    }
    runs = tuple(SimpleNamespace(t_s=t) for _ in x)
    session = Session(runs, window(DT_S), channels, np.zeros(len(runs)))
    still = np.zeros(session.counts.sum(), bool)
    vars(session).update(velocity_m_s=np.concatenate(v), oscillating=still)
    return session


def one_balance(bench, bench_data, law, seed=1, level_n=2.0, noise_n=1.0) -> BalanceProducts:
    """Residuals of a force balance that lacks ``law(x, v, pressure drop)`` [N].

    The level of friction differs from run to run, and windows have noise with heavy tails.
    """
    session, rng = logs(seed), np.random.default_rng([seed, 7])
    channels = session.channels
    drop = channels["p_tp_pa"] - channels["p_tr_pa"]
    force = session.mean(law(channels["x_m"], session.velocity_m_s, drop))
    v = session.mean(session.velocity_m_s)
    run = session.run_of_window
    values = np.full((len(v), len(BALANCES)), np.nan)
    wander = rng.normal(0, level_n, len(session.runs))[run] * np.sign(v)
    values[:, 0] = force + wander + noise_n * rng.standard_t(4, len(v))
    points = tuple(i % POINTS for i in range(len(session.runs)))
    windows = Windows(run, points, v, session.mean(channels["x_m"]), v, v)
    found = log_map(windows, BALANCES_OF_ONE, values[:, :1], np.zeros(1))
    residuals = GapMap(**vars(found) | {"material": np.array([MATERIAL])})
    constant = {"/friction.test.coulomb": np.sign(v)[:, None] * 20.0}
    model = balance_model(bench, parse_plant(bench_data, {}, "model"))
    measured = SimpleNamespace(logs=(session,), smoothed_sessions=(session,))
    priors = Priors(*(np.array([value]) for value in (0.0, 1.0, -3.0, 3.0)))
    base = products(residuals, constant)
    return BalanceProducts(measured, BALANCES_OF_ONE, model, residuals, constant, base, priors)


def best(one) -> tuple[Table, float, float]:
    """The best table of a balance, its score, and the score that it must exceed."""
    points = np.arange(POINTS)
    table, gain = best_tables(one, points)[-1]
    return table, gain, table_threshold(gain, one, one.without(table, points), table, points)


def bump(x, v, drop):
    """A tight place of the bore."""
    return 15.0 * np.sign(v) * np.exp(-(((x - 0.17) / 0.06) ** 2))


def test_a_tight_place_of_the_bore_becomes_friction_over_the_position(bench, bench_data):
    one = one_balance(bench, bench_data, bump)
    table, gain, threshold = best(one)
    assert gain > 3 * threshold
    assert (table.adds_to, list(table.knots)) == ("friction_test", ["position"])


def test_a_table_that_was_fitted_has_nothing_more_to_explain(bench, bench_data):
    one, points = one_balance(bench, bench_data, bump), np.arange(POINTS)
    table = one.table("friction_test", ("position",))
    assert one.score(table, points)[0] > 10
    assert one.without(table, points).score(table, points)[0] < 1


def test_a_law_of_two_quantities_gets_a_table_over_both(bench, bench_data):
    one = one_balance(
        bench, bench_data, lambda x, v, drop: np.sign(v) * 3e-5 * drop * (x / 0.2) ** 2
    )
    table, gain, threshold = best(one)
    assert gain > threshold
    assert "position" in table.knots and len(table.knots) == 2


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (2, 3, 4))]
)
def test_friction_that_wanders_from_run_to_run_is_no_law(bench, bench_data, seed):
    one = one_balance(bench, bench_data, lambda x, v, drop: 0.0 * x, seed, level_n=6.0)
    gains = [gain for _, gain in best_tables(one, np.arange(POINTS))]
    assert all(gain <= 5.0 or gain <= best(one)[2] for gain in gains)


def test_a_law_that_held_out_runs_contradict_is_refused(bench, bench_data):
    """The bump is in the training runs alone, so the table makes the held-out runs worse."""
    one, without = (one_balance(bench, bench_data, law) for law in (bump, lambda x, v, drop: 0 * x))
    train, held_out = np.arange(POINTS) % 5 != 2, np.arange(POINTS) % 5 == 2
    table, _ = best_tables(one, np.flatnonzero(train))[-1]
    left = one.without(table, np.flatnonzero(train)).residuals
    in_training = reductions(one.residuals, left)
    fitted = one.residuals.difference - left.difference
    contradicted = GapMap(
        **vars(without.residuals) | {"difference": without.residuals.difference - fitted}
    )
    elsewhere = reductions(without.residuals, contradicted)
    assert sign_test(in_training[train]) < 0.01
    assert sign_test(in_training[held_out]) < 0.1  # the same law there: four points
    assert sign_test(elsewhere[held_out]) > 0.5


@pytest.mark.parametrize("elsewhere, worse", [(1.0, False), (1.2, False), (2.0, True)])
def test_a_law_may_not_disturb_other_balances_more_than_it_helps_its_own(
    bench, bench_data, elsewhere, worse
):
    """Where all residuals of a balance halve, those of another one may grow to 1.32 times."""
    one = one_balance(bench, bench_data, bump, level_n=6.0, noise_n=30.0).residuals
    both = {name: np.tile(getattr(one, name), 2) for name in ("difference", "scatter", "noise")}
    before = GapMap(**vars(one) | both | {"names": ("force_test", "force_load")})
    after = GapMap(**vars(before) | {"difference": before.difference * [0.5, elsewhere]})
    assert is_worse(before, after, np.arange(POINTS)) is worse


def test_the_sign_test_is_that_of_all_sign_patterns():
    changes = np.array([0.4, 0.1, 0.3, -0.05, 0.2])
    patterns = np.array(np.meshgrid(*[[-1, 1]] * 5)).reshape(5, -1)
    exact = np.mean(changes @ patterns >= changes.sum() - 1e-12)
    assert sign_test(changes) == pytest.approx(exact, abs=0.01)
    assert sign_test(np.full(4, 1.0)) > 0.05  # four points are too few


def test_the_prior_of_a_table_is_smooth():
    table = empty_table("force_test", {"velocity": tuple(np.linspace(-1, 1, 6))}, 5.0)
    covariance = table.basis @ table.basis.T
    assert np.diag(covariance) == pytest.approx(25.0, rel=1e-3)
    steps = np.diff(np.eye(6), axis=0)
    assert np.all(np.diag(steps @ covariance @ steps.T) < 2 * 25.0 * 0.25)
