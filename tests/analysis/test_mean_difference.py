"""The mean difference over curves against scipy, with independent trials and with common files."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from scipy import stats

from hbench.analysis.comparison.difference_tests import (
    InstrumentPair,
    WeightedCurve,
    mean_difference_u95,
    mean_u95,
    mean_with_test,
)
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


SIDES = np.array([1.0, -1.0])
P_TP_PA, P_TR_PA = np.array([40e5, 20e5]), np.array([10e5, 55e5])
F_APPLIED_N = np.array([3000.0, -900.0])


def both_directions(factor):
    """The curves of a campaign whose trials agree, in the mean over both directions."""
    curves = []
    for i, direction in enumerate(("extend", "retract")):
        made = curve(direction, np.array([399.9, 400.0, 400.1]))
        read = {"p_tp_pa": P_TP_PA[i], "p_tr_pa": P_TR_PA[i], "f_applied_n": F_APPLIED_N[i]}
        point = replace(made.points[0], **read)
        curves.append(WeightedCurve(factor, replace(made, points=(point,)), {0: 1.0}, {}))
    return curves


def drawn_errors():
    """Errors of |F| (200 000, 2) in each direction, of gains 1 % wrong for a whole campaign."""
    gain_tp, gain_tr, gain_f = np.random.default_rng(7).uniform(-0.01, 0.01, (3, 200_000, 1))
    of_pressures = gain_tp * P_TP_PA * SPECIMEN.area_piston_m2
    of_pressures -= gain_tr * P_TR_PA * SPECIMEN.area_rod_m2
    return SIDES * (of_pressures - gain_f * F_APPLIED_N)


def test_u_of_a_mean_over_both_directions_is_the_scatter_under_common_errors_of_the_sensors():
    """U is 29 N; errors that were independent from curve to curve would give 36 N."""
    u95 = mean_u95(both_directions(0.5), INSTRUMENTS)
    scatter = np.std(drawn_errors().mean(axis=1))
    independent = np.hypot.reduce(np.std(drawn_errors(), axis=0)) / 2
    assert u95 == pytest.approx(1.96 * scatter, rel=0.01)
    assert abs(independent / scatter - 1) > 0.2
    assert mean_u95(both_directions(0.5), None) is None


def test_u_of_a_difference_of_means_has_the_errors_of_both_benches_or_of_none():
    """Both campaigns have the same forces: errors of the same instruments cancel."""
    both = [*both_directions(-0.5), *both_directions(0.5)]
    scatter = sqrt(2) * np.std(drawn_errors().mean(axis=1))
    other, same = (InstrumentPair(INSTRUMENTS, INSTRUMENTS, same) for same in (False, True))
    assert mean_difference_u95(both, other) == pytest.approx(1.96 * scatter, rel=0.01)
    of_trials, _ = mean_with_test(0.0, both)
    assert mean_difference_u95(both, same) == pytest.approx(of_trials)
    assert mean_difference_u95(both, other._replace(b=None)) is None
