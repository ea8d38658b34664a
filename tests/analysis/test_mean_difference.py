"""The mean difference over curves against scipy, with independent trials and with common files."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from hbench.analysis.comparison.difference_tests import WeightedCurve, mean_u95, mean_with_test
from hbench.config.sensors import Instruments
from hbench.records import Curve, CurvePoint, Specimen

SPECIMEN = Specimen(1e-3, 6e-4)
INSTRUMENTS = Instruments.model_validate(
    {
        "force": {"tolerance": "1 %", "of": "reading", "full_scale": "10 kN"},
        "pressure": {"tolerance": "1 %", "of": "reading", "full_scale": "250 bar"},
    }
)


def curve(direction, trials_n):
    """A curve of one point, with friction against the motion of its trials."""
    sign = 1.0 if direction == "extend" else -1.0
    trials = tuple(range(1, len(trials_n) + 1))
    values = tuple(sign * np.asarray(trials_n))
    mean = float(np.mean(values))
    runs = tuple(f"{direction}-{trial}" for trial in trials)
    point = CurvePoint(
        sign * 0.05, mean, 1.0, len(trials), mean, 0.0, 1e5, 1e5, trials, values, values, runs
    )
    return Curve(
        kind="steady",
        direction=direction,
        f_load_n=None,
        p_lr_ref_pa=None,
        label="",
        specimen=SPECIMEN,
        points=(point,),
    )


def mean_test(a, b, setups):
    """Test the mean over both directions of ``b`` less ``a``: (direction, trial) each."""
    sides = []
    for values, factor in ((a, -0.5), (b, 0.5)):
        for direction, trials in zip(("extend", "retract"), values, strict=True):
            sides.append(WeightedCurve(factor, curve(direction, trials), {0: 1.0}, setups))
    return mean_with_test(float(np.mean(b) - np.mean(a)), sides)


FILES = {f"{way}-{trial}": f"file {trial}" for way in ("extend", "retract") for trial in (1, 2, 3)}


def test_strokes_of_common_files_are_welch_s_test_of_the_files_means():
    a, b = np.random.default_rng(4).normal(400.0, 5.0, (2, 2, 3))
    test = stats.ttest_ind(b.mean(axis=0), a.mean(axis=0), equal_var=False)
    low, high = test.confidence_interval()
    half, p = mean_test(a, b, FILES)
    assert (half, p) == (pytest.approx((high - low) / 2), pytest.approx(test.pvalue))


def test_independent_trials_are_tested_by_welch_and_satterthwaite():
    a, b = np.random.default_rng(5).normal(400.0, 5.0, (2, 2, 3))
    parts = np.var([*a, *b], axis=1, ddof=1) / 3 / 4
    se, dof = np.sqrt(parts.sum()), parts.sum() ** 2 / np.sum(parts**2 / 2)
    half, p = mean_test(a, b, {})
    assert half == pytest.approx(stats.t.ppf(0.975, dof) * se)
    assert p == pytest.approx(2 * stats.t.sf(abs(b.mean() - a.mean()) / se, dof))


@pytest.mark.parametrize(("together", "setups"), [(True, FILES), (False, FILES), (False, {})])
def test_campaigns_without_a_difference_differ_in_5_of_100(together, setups):
    """With scatter that strokes share, single trials would differ in 15 of 100."""
    rng = np.random.default_rng(6)
    p = []
    for _ in range(2000):
        errors = rng.normal(0.0, 5.0, (2, 2, 3))
        if together:
            errors[:, 1] = errors[:, 0]
        p.append(mean_test(*(400.0 + errors), setups)[1])
    assert 0.02 < np.mean(np.array(p) < 0.05) < 0.065


def test_a_single_trial_is_not_tested():
    assert mean_test(np.full((2, 1), 400.0), np.full((2, 1), 410.0), {}) is None


def test_u_of_a_mean_over_both_directions_is_the_scatter_under_common_errors_of_the_sensors():
    """Gains that are 1 % wrong for a whole campaign, drawn 200 000 times.

    U is 29 N; errors that were independent from curve to curve would give 36 N.
    """
    area_p, area_r = SPECIMEN.area_piston_m2, SPECIMEN.area_rod_m2
    p_tp, p_tr, f_applied = np.array([40e5, 20e5]), np.array([10e5, 55e5]), [3000.0, -900.0]
    sides, limits = np.array([1.0, -1.0]), 0.01
    trials = np.array([399.9, 400.0, 400.1])
    curves = []
    for i, direction in enumerate(("extend", "retract")):
        made = curve(direction, trials)
        point = replace(made.points[0], p_tp_pa=p_tp[i], p_tr_pa=p_tr[i], f_applied_n=f_applied[i])
        curves.append(WeightedCurve(0.5, replace(made, points=(point,)), {0: 1.0}, {}))
    u95 = mean_u95(curves, INSTRUMENTS)

    gain_tp, gain_tr, gain_f = np.random.default_rng(7).uniform(-limits, limits, (3, 200_000, 1))
    error = gain_tp * p_tp * area_p - gain_tr * p_tr * area_r - gain_f * f_applied
    scatter = np.std((sides * error).mean(axis=1))
    independent = np.hypot.reduce(np.std(error, axis=0)) / 2
    assert u95 == pytest.approx(1.96 * scatter, rel=0.01)
    assert abs(independent / scatter - 1) > 0.2
    assert mean_u95(curves, None) is None
