"""The tests of a ramp's acceleration, and of ramps against steady runs."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from hbench.analysis.curves.average import curves
from hbench.analysis.curves.ramp_tests import ramp_comparisons
from hbench.analysis.curves.ramps import ramp_curves, sliding
from hbench.analysis.screening.screen import screen
from hbench.config.schedule import Screening
from tests.support.analysis.other_plant import OTHER_MASS_KG, OTHER_PLANT

SPEEDS = np.linspace(0.02, 0.18, 17)


@pytest.fixture
def make_group(make_curve):
    """Return a function: a curve whose trials are 400 N + 1500 v, and a level each."""

    def make(levels, a=None, kind="ramp", direction="extend"):
        law = 400 + 1500 * SPEEDS
        curve = make_curve(SPEEDS, law, direction)
        sign = 1.0 if direction == "extend" else -1.0
        points = tuple(
            replace(
                point,
                trials=tuple(range(1, len(levels) + 1)),
                trials_n=tuple(sign * (f + level) for level in levels),
                n=len(levels),
            )
            for point, f in zip(curve.points, law, strict=True)
        )
        return replace(curve, kind=kind, a_ref_m_s2=a, points=points)

    return make


@pytest.mark.parametrize("direction", ["extend", "retract"])
def test_of_two_accelerations_the_f_test_is_students_and_the_effect_its_difference(
    make_group, direction
):
    slow, fast = [1.0, -3.0, 2.0], [12.0, 9.0, 10.5]
    found = ramp_comparisons(
        [make_group(fast, 0.1, direction=direction), make_group(slow, 0.05, direction=direction)]
    )
    assert [one.what for one in found] == ["acceleration"] * 2
    theirs = stats.ttest_ind(fast, slow)
    interval = theirs.confidence_interval()
    for one in found:
        assert one.a_m_s2 == (0.05, 0.1) and one.n == 6
        assert one.effect_n == pytest.approx(np.mean(fast) - np.mean(slow))
        assert one.p_value == pytest.approx(theirs.pvalue)
        assert one.ci95_n == pytest.approx((interval.high - interval.low) / 2)
        assert one.p_holm == pytest.approx(2 * theirs.pvalue)
    low, high = found
    assert low.v_high_m_s == high.v_low_m_s == pytest.approx(0.1)


def test_a_ramp_against_steady_runs_is_welchs_test_of_trials(make_group):
    ramp, steady = [8.0, 11.0, 9.0], [0.0, 5.0, -4.0, 1.0]
    found = ramp_comparisons([make_group(steady, kind="steady"), make_group(ramp, 0.1)])
    assert [one.what for one in found] == ["steady"] * 2
    theirs = stats.ttest_ind(ramp, steady, equal_var=False)
    for one in found:
        assert one.effect_n == pytest.approx(np.mean(ramp) - np.mean(steady))
        assert one.p_value == pytest.approx(theirs.pvalue) and one.n == 7


def test_single_trials_are_compared_without_a_verdict(make_group):
    found = ramp_comparisons([make_group([0.0], 0.05), make_group([9.0], 0.1)])
    assert [one.effect_n for one in found] == pytest.approx([9.0, 9.0])
    assert all(one.p_value is one.p_holm is one.ci95_n is None for one in found)
    assert "one trial" in found[0].message


def test_other_loads_and_directions_are_not_compared(make_group):
    other = replace(make_group([1.0, 2.0], 0.1), f_load_n=500.0)
    assert ramp_comparisons([make_group([1.0, 2.0], 0.05), other]) == ()
    back = make_group([1.0, 2.0], 0.1, direction="retract")
    assert ramp_comparisons([make_group([1.0, 2.0], 0.05), back]) == ()


def test_without_an_influence_one_campaign_in_twenty_finds_one_and_intervals_hold_zero(make_group):
    rng = np.random.default_rng(5)
    made, claimed, held = 300, 0, 0
    for _ in range(made):
        groups = [make_group(rng.normal(0, 6, 3), a) for a in (0.03, 0.07, 0.1)]
        one = ramp_comparisons(groups)[0]
        claimed += one.p_value < 0.05
        held += abs(one.effect_n) <= one.ci95_n
    assert stats.binomtest(claimed, made, 0.05).pvalue > 0.001
    assert stats.binomtest(held, made, 0.95).pvalue > 0.001


RAMPS = {
    "kind": "ramp",
    "direction": "extend",
    "p_lr": "15 bar",
    "loads": ["2000 N"],
    "speed": "180 mm/s",
    "accelerations": ["0.06 m/s^2", "0.3 m/s^2"],
    "trials": 3,
    "travel": {"start": "40 mm", "end": "340 mm"},
    "hold": "0.3 s",
}
SEALS = ("piston_seal", "rod_seal")  # friction by pressure would follow the load's own lag


def test_on_the_rig_ramps_of_a_lagging_friction_differ_and_those_of_a_stiff_one_do_not(rig_runs):
    own = {k: v for k, v in OTHER_PLANT["friction"]["test"].items() if k not in SEALS}
    own |= {"scatter": "0.5 %", "bristle_damping": "0 N s/m"}
    found = {}
    for name, stiffness in (("soft", "1e4 N/m"), ("stiff", "3e5 N/m")):
        runs = rig_runs([RAMPS], 4, own | {"bristle_stiffness": stiffness})
        ramps, _ = ramp_curves([screen(run, Screening()) for run in runs], OTHER_MASS_KG)
        assert len(ramps) == 2 and curves([]) == ()
        found[name] = ramp_comparisons(sliding(curve) for curve in ramps)
    assert max(abs(one.effect_n) for one in found["soft"]) > 20
    assert min(one.p_holm for one in found["soft"]) < 0.01
    for one in found["stiff"]:
        assert abs(one.effect_n) < 10


STRAIGHT = {
    "law": "tustin",
    "coulomb": "330 N",
    "stiction": "330 N",
    "stribeck_velocity": "60 mm/s",
    "viscous": "2400 N s/m",
    "scatter": "1.5 %",
}


@pytest.mark.slow
def test_on_the_rig_a_friction_without_memory_is_said_to_have_one_as_rarely_as_chance(rig_runs):
    """40 campaigns; friction has no memory, and its level scatters by 5 N from stroke to stroke."""
    claimed, held, corrected, on_law = [], [], [], []
    for seed in range(40):
        screened = [screen(run, Screening()) for run in rig_runs([RAMPS], seed, STRAIGHT)]
        ramps, _ = ramp_curves(screened, OTHER_MASS_KG)
        found = ramp_comparisons(sliding(curve) for curve in ramps)
        claimed += [one.p_value < 0.05 for one in found]
        held += [abs(one.effect_n) <= one.ci95_n for one in found]
        for point in (point for curve in ramps for point in sliding(curve).points):
            truth = 330 + 2400 * point.v_m_s
            on_law.append(abs(point.friction_n - truth) <= point.ci95_n)
        corrected.append(min(one.p_holm for one in found) < 0.05)
    print(
        f"{sum(claimed)} of {len(claimed)} tests below p = 0.05, {sum(corrected)} of 40 campaigns "
        f"after Holm; intervals hold 0 in {100 * np.mean(held):.0f} %, "
        f"those of {len(on_law)} points of the curves hold the law in {100 * np.mean(on_law):.0f} %"
    )
    assert 0.88 < np.mean(on_law) < 1.0 and 0.88 < np.mean(held) <= 1.0
    assert stats.binomtest(sum(corrected), 40, 0.05).pvalue > 0.001
