"""Trials that contradict the others of their point are listed, and no honest ones."""

from types import SimpleNamespace

import numpy as np
import pytest

from hbench.analysis.summary.unlike_trials import unlike_check, unlike_notes, unlike_trials


def campaign(seed, scatter=0.02, trials=3, wrong=None, dof=4):
    """Two curves of eight speeds; the scatter has heavy tails and a part that wanders in time.

    ``wrong`` maps (curve, speed, trial) to the friction that a wrong file gives, as a factor.
    """
    rng = np.random.default_rng(seed)
    wander = np.cumsum(rng.normal(0, scatter / 6, (trials, 16)), axis=1)
    made = []
    for number, (direction, sign) in enumerate((("extend", 1), ("retract", -1))):
        points = []
        for k, v in enumerate(np.geomspace(5e-3, 0.25, 8)):
            truth = sign * (210.0 + 90.0 / (1 + (v / 0.02) ** 2) + 900.0 * v**0.8)
            level = 1 + scatter * rng.standard_t(dof, trials) + wander[:, 8 * number + k]
            friction = [
                truth * level[i] * (wrong or {}).get((number, k, i), 1.0) for i in range(trials)
            ]
            runs = tuple(f"{16 * i + 8 * number + k + 1:04d}" for i in range(trials))
            of = {"n": trials, "trials": tuple(range(1, trials + 1)), "runs": runs}
            points.append(SimpleNamespace(v_m_s=sign * v, trials_n=tuple(friction), **of))
        curve = {"label": "", "direction": direction, "f_load_n": 800.0, "points": tuple(points)}
        made.append(SimpleNamespace(**curve))
    return made


@pytest.mark.parametrize(("scatter", "dof"), [(0.0, 4), (0.01, 4), (0.03, 1e6), (0.1, 1e6)])
def test_at_most_one_campaign_in_twenty_has_an_honest_trial_listed(scatter, dof):
    """With tails of 4 degrees of freedom and 3 %, a quarter has a trial 15 % from the others."""
    listed = [bool(unlike_trials(campaign(seed, scatter, dof=dof))) for seed in range(300)]
    assert np.mean(listed) <= 0.05


@pytest.mark.parametrize("factor", [-1.0, 0.1, 10.0, 1.6])
@pytest.mark.parametrize("trials", [3, 5])
def test_wrong_files_are_listed_by_their_runs_and_no_others(factor, trials):
    wrong = {(0, 1, 2): factor, (1, 6, 0): factor}
    curves = campaign(3, 0.01, trials, wrong)
    found = [(t.curve.direction, t.point.runs[t.index]) for t in unlike_trials(curves)]
    assert found == [("extend", "0034"), ("retract", "0015")]
    (check,) = unlike_check(curves)
    assert (check.grade, check.value, check.of) == ("with care", 2, 16 * trials)
    (note,) = unlike_notes(curves)
    assert "run 0034 (extending, 800 N, 8.74 mm/s)" in note and "run 0015 (retracting" in note


def test_two_trials_do_not_show_which_is_wrong():
    assert not list(unlike_check(campaign(3, 0.01, 2, {(0, 1, 1): 10.0})))
