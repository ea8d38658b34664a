"""Two campaigns compared: against scipy, drawn campaigns with and without a difference."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from hbench.analysis.comparison.difference_tests import InstrumentPair, welch
from hbench.analysis.comparison.differences import campaign_differences
from hbench.analysis.comparison.drift_effects import with_drift_effects
from hbench.analysis.statistics.holm import holm
from hbench.analysis.summary.headline import headline
from hbench.analysis.summary.quality import quality
from hbench.analysis.summary.run_clock import RunClock
from hbench.analysis.uncertainty.budget import with_instruments
from hbench.analysis.uncertainty.efficiency import efficiency_curve
from hbench.config.sensors import Instruments
from hbench.records import FitParameter, Provenance, Results
from tests.support.analysis.chance import binomial_limits
from tests.support.analysis.fits import fit_tustin

SPEEDS = np.array([0.005, 0.02, 0.05, 0.1, 0.19])
INSTRUMENTS = Instruments.model_validate(
    {
        "force": {"tolerance": "1.0 %", "of": "reading", "full_scale": "12 kN"},
        "pressure": {"tolerance": "0.8 %", "of": "reading", "full_scale": "250 bar"},
    }
)


@pytest.fixture
def campaign(make_curve):
    """Return a function that draws a campaign's trials around friction over speed."""

    def draw(seed, level=1.0, *, speeds=SPEEDS, trials=3, scatter=6.0, directions=("extend",)):
        rng = np.random.default_rng(seed)
        curves = []
        for direction in directions:
            sign = 1.0 if direction == "extend" else -1.0
            f_load = sign * 2000.0
            friction = level * (350 + 200 * np.exp(-((speeds / 0.06) ** 1.4)) + 1100 * speeds)
            made = make_curve(speeds, friction, direction, f_load)
            points = []
            for point in made.points:
                drawn = point.friction_n + rng.normal(0, scatter, trials)
                f_test = point.f_applied_n + drawn
                points.append(
                    replace(
                        point,
                        n=trials,
                        friction_n=float(drawn.mean()),
                        f_test_n=float(f_test.mean()),
                        trials=tuple(range(1, trials + 1)),
                        trials_n=tuple(drawn.tolist()),
                        trials_f_test_n=tuple(f_test.tolist()),
                    )
                )
            curves.append(with_instruments(replace(made, points=tuple(points)), INSTRUMENTS))
        etas = tuple(efficiency_curve(curve, INSTRUMENTS) for curve in curves)
        provenance = Provenance("drawn", "simulated", "", "", "", "")
        return Results(
            provenance,
            (),
            tuple(curves),
            etas,
            (),
            (),
            headline=headline(curves, etas),
            quality=quality((), curves),
        )

    return draw


def compared(a, b, same=True, known=(INSTRUMENTS, INSTRUMENTS)):
    return campaign_differences(a, b, InstrumentPair(*known, same))


def test_each_number_has_its_own_uncertainty_of_trials_and_instruments(campaign):
    def expanded(trials, n, parts):
        """Welch and Satterthwaite with instruments of infinite degrees of freedom."""
        u = np.hypot(trials, np.linalg.norm(list(parts.values())))
        return u * stats.t.ppf(0.975, u**4 / (trials**4 / (n - 1)))

    a, b = campaign(1), campaign(2, 1.05)
    (found,), _ = compared(a, b)
    for point, *both in zip(found.points, a.curves[0].points, b.curves[0].points, strict=True):
        ours = point.friction_n.u95_a, point.friction_n.u95_b
        for u95, own in zip(ours, both, strict=True):
            assert u95 == pytest.approx(expanded(stats.sem(own.trials_n), own.n, own.parts_n))
    one = SPEEDS[2:3]
    a, b = campaign(1, speeds=one), campaign(2, 1.05, speeds=one)
    (found,), _ = compared(a, b)
    for u95, own in ((found.efficiency.u95_a, a), (found.efficiency.u95_b, b)):
        eta = own.efficiency[0].points[0]
        n = own.curves[0].points[0].n
        assert u95 == pytest.approx(expanded(eta.sigma_trials, n, eta.parts))
    (unknown,), _ = compared(a, b, known=(INSTRUMENTS, None))
    assert unknown.mean_n.u95_a is None


def test_a_point_is_compared_as_scipys_welch_test_does(campaign):
    a, b = campaign(1), campaign(2, 1.05)
    (found,), notes = compared(a, b)
    assert notes == ()
    for point, ours, theirs in zip(
        found.points, a.curves[0].points, b.curves[0].points, strict=True
    ):
        peer = stats.ttest_ind(theirs.trials_n, ours.trials_n, equal_var=False)
        interval = peer.confidence_interval()
        d = point.friction_n
        assert d.p_value == pytest.approx(peer.pvalue)
        assert d.value - d.ci95 == pytest.approx(interval.low)
        assert d.value + d.ci95 == pytest.approx(interval.high)
    p_values = [point.friction_n.p_value for point in found.points]
    assert [point.friction_n.p_holm for point in found.points] == pytest.approx(holm(p_values))


def test_holms_values_by_hand():
    assert holm([0.01, 0.04, 0.03, 0.5]) == pytest.approx([0.04, 0.09, 0.09, 0.5])
    assert holm([0.9, 0.8]) == pytest.approx([1.0, 1.0])


@pytest.mark.parametrize("direction", ["extend", "retract"])
def test_higher_friction_is_a_positive_difference_in_both_directions(campaign, direction):
    (found,), _ = compared(
        campaign(1, directions=(direction,)), campaign(2, 1.2, directions=(direction,))
    )
    assert found.mean_n.value > 0 and found.mean_n.real
    assert found.efficiency.value < 0 and found.efficiency.real
    assert all(point.friction_n.value > 0 for point in found.points)


@pytest.mark.parametrize("count", [100, pytest.param(300, marks=pytest.mark.slow)])
def test_the_means_interval_holds_the_truth_in_95_percent_and_rarely_cries_wolf(campaign, count):
    held = wolf = 0
    for seed in range(count):
        (found,), _ = compared(campaign(2 * seed), campaign(2 * seed + 1))
        held += abs(found.mean_n.value) <= found.mean_n.ci95
        wolf += any(point.friction_n.real for point in found.points)
    least, most = binomial_limits(count, 0.95, 0.98)
    assert least <= held <= most
    assert wolf <= binomial_limits(count, 0.05, 0.98)[1]


def test_the_same_instruments_cancel_where_readings_agree_and_others_do_not(campaign):
    a, b = campaign(1, scatter=1.0), campaign(2, 1.001, scatter=1.0)
    (same,), _ = compared(a, b, same=True)
    (other,), _ = compared(a, b, same=False)
    of_one = a.curves[0].points[0].sigma_instruments_n
    assert same.mean_n.u95 < 1.2 * same.mean_n.ci95
    assert other.mean_n.u95 == pytest.approx(1.96 * np.sqrt(2) * of_one, rel=0.1)
    assert other.mean_n.p_holm == same.mean_n.p_holm


def drifting(results, sigmas_n):
    """Give the points of the first curve a significant drift, in friction and efficiency."""
    curve, eta = results.curves[0], results.efficiency[0]
    points = tuple(
        replace(p, sigma_drift_n=float(s)) for p, s in zip(curve.points, sigmas_n, strict=True)
    )
    return replace(results, curves=(replace(curve, points=points),), efficiency=(eta,))


def test_a_drift_within_each_campaign_is_part_of_u_and_common_instruments_do_not_cancel_it(
    campaign,
):
    """Far above the other parts, U is 1.96 times the root sum of squares of both drifts."""
    a, b = campaign(1), campaign(2)
    (both,), _ = compared(drifting(a, 5 * [3e4]), drifting(b, 5 * [4e4]))
    assert both.mean_n.u95 == pytest.approx(1.96 * 5e4, rel=1e-3)
    assert both.points[0].friction_n.u95 == pytest.approx(1.96 * 5e4, rel=1e-3)
    by_force = np.mean([eta.efficiency / p.f_test_n for p, eta in both_of(a)])
    by_force_b = np.mean([eta.efficiency / p.f_test_n for p, eta in both_of(b)])
    of_both = np.hypot(3e4 * by_force, 4e4 * by_force_b)
    assert both.efficiency.u95 == pytest.approx(1.96 * of_both, rel=1e-3)
    assert both.mean_n.ci95 == compared(a, b)[0][0].mean_n.ci95


def both_of(results):
    return zip(results.curves[0].points, results.efficiency[0].points, strict=True)


def test_a_drift_cancels_in_the_mean_of_points_before_and_after_the_middle(campaign):
    a, b = campaign(1), campaign(2)
    (plain,), _ = compared(a, b)
    (found,), _ = compared(drifting(a, [-20.0, 10.0, 0.0, 25.0, -15.0]), b)
    assert found.mean_n.u95 == pytest.approx(plain.mean_n.u95)
    assert found.points[0].friction_n.u95 > plain.points[0].friction_n.u95


@pytest.mark.parametrize("same", [True, False])
def test_few_degrees_of_freedom_of_an_instrument_widen_the_interval_as_g2b_says(campaign, same):
    """By hand, from the forces alone: two transducers, a load cell calibrated with four readings.

    The effective degrees of freedom are those of JCGM 100, G.2b; the same errors are subtracted.
    """
    few = INSTRUMENTS.model_copy(
        update={"force": INSTRUMENTS.force.model_copy(update={"dof": 3.0})}
    )
    a, b = campaign(1, scatter=1.0), campaign(2, 1.3, scatter=1.0)
    (found,), _ = compared(a, b, same, known=(few, few))
    curves = a.curves[0], b.curves[0]
    for number, difference in enumerate(found.points):
        variances, dofs, parts = [], [], []
        for curve in curves:
            point, areas = curve.points[number], curve.specimen
            variances.append(np.var(point.trials_n, ddof=1) / 3)
            dofs.append(2.0)
            tolerances = np.array([0.01, 0.008, 0.008]) / 3**0.5
            forces = [
                -point.f_applied_n,
                point.p_tp_pa * areas.area_piston_m2,
                -point.p_tr_pa * areas.area_rod_m2,
            ]
            parts.append(tolerances * forces)
        of_instruments = [parts[1] - parts[0]] if same else parts
        variances += [u**2 for each in of_instruments for u in each]
        dofs += [3.0, np.inf, np.inf] * len(of_instruments)
        total = sum(variances)
        dof = total**2 / sum(v**2 / nu for v, nu in zip(variances, dofs, strict=True))
        expected = stats.t.ppf(0.975, dof) * np.sqrt(total)
        assert difference.friction_n.u95 == pytest.approx(expected, rel=1e-9)
    known, _ = compared(a, b, same)
    assert same or found.mean_n.u95 > known[0].mean_n.u95
    assert same or found.efficiency.u95 > known[0].efficiency.u95


@pytest.mark.parametrize("both", [True, False])
def test_a_stated_coverage_factor_of_two_is_that_of_each_u_and_of_a_difference_if_both_state_it(
    campaign, both
):
    """By hand, from the trials and the parts of three points: U = 2 u, or Student's factor."""
    k_2 = INSTRUMENTS.model_copy(update={"expansion": "k_2"})
    a, b = campaign(1), campaign(2, 1.05)
    (found,), _ = compared(a, b, same=False, known=(k_2, k_2 if both else INSTRUMENTS))
    curves = a.curves[0].points, b.curves[0].points
    for point, *measured in zip(found.points, *curves, strict=True):
        variances = [
            stats.sem(each.trials_n) ** 2 + sum(part**2 for part in each.parts_n.values())
            for each in measured
        ]
        d = point.friction_n
        assert d.u95_a == pytest.approx(2 * np.sqrt(variances[0]))
        assert both == (d.u95 == pytest.approx(2 * np.sqrt(sum(variances))))
        assert both == (d.u95_b == pytest.approx(2 * np.sqrt(variances[1])))
    (student,), _ = compared(a, b, same=False)
    assert both or found.mean_n.u95 == student.mean_n.u95
    assert found.mean_n.u95_a == pytest.approx(2 / 1.96 * student.mean_n.u95_a, rel=0.005)
    assert found.efficiency.u95_a == pytest.approx(2 / 1.96 * student.efficiency.u95_a, rel=0.005)


def test_each_speed_has_the_u_of_its_mean_over_both_directions(campaign):
    """That of other instruments is larger; the same ones leave the trials alone at equal forces."""
    both = ("extend", "retract")
    a, b = (campaign(seed, directions=both) for seed in (1, 2))

    def mean(same, known=INSTRUMENTS):
        pair = InstrumentPair(INSTRUMENTS, known, same)
        curves, _ = campaign_differences(a, b, pair)
        clocks = RunClock({}, False), RunClock({}, False)
        return with_drift_effects(curves, (a, b), clocks, pair, 0.02)[1]

    same, others, unknown = mean(True), mean(False), mean(False, None)
    assert len(same.speeds) == len(SPEEDS)
    for one, other, without in zip(same.speeds, others.speeds, unknown.speeds, strict=True):
        assert one.value_n == other.value_n == without.value_n
        assert one.u95_n == pytest.approx(one.ci95_n, rel=0.05)
        assert other.u95_n > 2 * one.u95_n
        assert without.u95_n is None and without.ci95_n == one.ci95_n


def test_unknown_instruments_leave_the_trials_alone(campaign):
    (found,), _ = compared(campaign(1), campaign(2, 1.2), known=(None, INSTRUMENTS))
    assert found.mean_n.u95 is None and found.mean_n.real


def test_between_bs_speeds_it_is_compared_on_a_straight_line_and_beyond_them_not(campaign):
    a = campaign(1, speeds=np.array([0.02, 0.06, 0.19]), scatter=1e-9)
    b = campaign(2, speeds=np.array([0.02, 0.05, 0.08]), scatter=1e-9)
    (found,), _ = compared(a, b)
    assert [round(point.v_m_s, 3) for point in found.points] == [0.02, 0.06]
    assert [point.between for point in found.points] == [False, True]
    low, high = (b.curves[0].points[i].friction_n for i in (1, 2))
    assert found.points[1].friction_n.b == pytest.approx(low + (high - low) / 3)


def test_one_trial_gives_a_difference_without_an_interval(campaign):
    (found,), _ = compared(campaign(1, trials=1), campaign(2, 1.5, trials=1))
    assert found.mean_n.value > 0
    assert found.mean_n.ci95 is None and not found.mean_n.real


def test_curves_without_a_rival_are_named(campaign):
    a, b = campaign(1, directions=("extend", "retract")), campaign(2)
    found, notes = compared(a, b)
    assert len(found) == 1
    (note,) = notes
    assert note.startswith("steady retracting -2000 N: ") and note.endswith(" A")


def _at_rod_pressure(results, bar):
    pressure = None if bar is None else 1e5 * bar
    curves = tuple(replace(curve, p_lr_ref_pa=pressure) for curve in results.curves)
    return replace(results, curves=curves)


def test_a_bench_without_a_load_cylinder_has_no_rod_pressure_that_could_differ(campaign):
    for rig, foreign in ((20.0, None), (None, 20.0)):
        found, notes = compared(
            _at_rod_pressure(campaign(1), rig), _at_rod_pressure(campaign(2), foreign)
        )
        assert len(found) == 1 and not notes


def test_one_of_several_rod_pressures_needs_the_same_one(campaign):
    both = campaign(1, directions=("extend", "retract"))
    low, high = (_at_rod_pressure(both, bar).curves[0] for bar in (20.0, 60.0))
    several = replace(both, curves=(low, high))
    found, notes = compared(several, _at_rod_pressure(campaign(2), None))
    assert not found and len(notes) == 3


def test_other_rod_pressures_are_named(campaign):
    found, notes = compared(_at_rod_pressure(campaign(1), 20.0), _at_rod_pressure(campaign(2), 25))
    assert not found
    assert [note.split(": ")[0] for note in notes] == [
        "steady extending 2000 N at 20 bar",
        "steady extending 2000 N at 25 bar",
    ]


def test_parameters_at_a_bound_are_not_tested_and_others_are(campaign):
    def fitted(results, f_c, at_bound):
        value = FitParameter(f_c, 5.0, (f_c - 11.0, f_c + 11.0), at_bound, "N")
        (curve,) = results.curves
        fit = replace(fit_tustin(curve), parameters={"f_coulomb_n": value})
        return replace(results, curves=(replace(curve, fits=(fit,)),))

    a = fitted(campaign(1), 300.0, None)
    (found,), _ = compared(a, fitted(campaign(2), 340.0, None))
    (p,) = found.parameters
    assert p.value.ci95 == pytest.approx(11.0 * np.sqrt(2)) and p.value.real
    (bound,), _ = compared(a, fitted(campaign(2), 340.0, "lower"))
    assert bound.parameters[0].value.p_value is None


@pytest.mark.parametrize("count", [100, pytest.param(300, marks=pytest.mark.slow)])
def test_a_ramps_points_share_their_strokes_so_a_trial_is_one_value(campaign, count):
    """Campaigns without a difference, whose trials' levels scatter: 5 % of them differ."""
    rng = np.random.default_rng(7)
    wolf = 0
    for seed in range(count):
        pair = []
        for one in (campaign(2 * seed, scatter=1.0), campaign(2 * seed + 1, scatter=1.0)):
            level = rng.normal(0, 10.0, 3)
            points = tuple(
                replace(p, trials_n=tuple((np.array(p.trials_n) + level).tolist()))
                for p in one.curves[0].points
            )
            curve = replace(one.curves[0], kind="steps", points=points)
            pair.append(replace(one, curves=(curve,), efficiency=()))
        (found,), _ = compared(*pair)
        wolf += found.mean_n.real
        trials = [np.mean([p.trials_n for p in one.curves[0].points], axis=0) for one in pair]
        if seed == 0:
            peer = stats.ttest_ind(trials[1], trials[0], equal_var=False)
            assert found.mean_n.p_value == pytest.approx(peer.pvalue)
    least, most = binomial_limits(count, 0.05, 0.98)
    assert max(least, 1) <= wolf <= most


def test_welch_of_a_weighted_sum_is_that_of_each_mean_by_hand():
    trials = [1.0, 2.0, 3.0], [2.0, 4.0]
    se, dof = welch([(0.5, trials[0]), (-1.0, trials[1])])
    parts = 0.25 * 1.0 / 3, 2.0 / 2
    assert se == pytest.approx(np.sqrt(sum(parts)))
    assert dof == pytest.approx(sum(parts) ** 2 / (parts[0] ** 2 / 2 + parts[1] ** 2))
