"""Decisions on conformity under uncertainty, and the risks that they leave."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import integrate, special, stats

from hbench.analysis.conformity.acceptance import conformity_checks
from hbench.analysis.conformity.certified import certified_values, why_not_certified
from hbench.analysis.conformity.decision import decide, probability_of_conformity
from hbench.analysis.summary.drift_uncertainty import with_drift
from hbench.analysis.summary.run_clock import RunClock, campaign_place
from hbench.analysis.uncertainty.budget import (
    combined,
    of_instruments,
    of_trials,
    with_instruments,
)
from hbench.config.conformity.limits import parse_limits
from hbench.config.sensors import Instruments
from hbench.errors import ConfigError
from hbench.records import Specimen
from hbench.records.conformity.acceptance import ConformityCheck, Measurement, Requirement
from hbench.records.motions import Breakaway, Decay, Leakage, LeakCoefficient, Series
from hbench.records.rod_pressure import series_key
from hbench.report.conformity.decision_section import decision_section
from hbench.report.conformity.text import complete_u, next_steps
from hbench.store.campaign.folder import load_campaign
from hbench.workflow.results import derive
from tests.support import ROOT

HIGHEST = Requirement("friction", "N", low=None, high=100.0)
BETWEEN = Requirement("friction", "N", low=80.0, high=100.0)


@pytest.mark.parametrize("dof", [None, 3.0, 12.5])
@pytest.mark.parametrize("value", [60.0, 97.0, 100.0, 104.0])
def test_the_probability_is_that_of_students_distribution(value, dof):
    u = 4.0
    spread = stats.norm if dof is None else stats.t(dof)
    measured = Measurement(value, u95=u * spread.ppf(0.975), dof=dof)
    for requirement, low in ((HIGHEST, -np.inf), (BETWEEN, 80.0)):
        expected = spread.cdf((100 - value) / u) - spread.cdf((low - value) / u)
        assert probability_of_conformity(requirement, measured) == pytest.approx(expected, 1e-6)


@pytest.mark.parametrize("dof", [2.0, 9.0])
def test_a_factor_of_two_changes_no_probability(dof):
    """``expansion: k_2`` states U = 2 u, whatever the degrees of freedom of u are."""
    u, value = 4.0, 95.0
    by_student = Measurement(value, u95=u * stats.t(dof).ppf(0.975), dof=dof, u=u)
    by_two = Measurement(value, u95=2 * u, dof=dof, u=u)
    expected = stats.t(dof).cdf((100 - value) / u)
    for measured in (by_student, by_two):
        assert probability_of_conformity(HIGHEST, measured) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("low", "high", "value", "u", "published"),
    [
        (None, -5.40, -5.47, 0.05, 0.92),  # V, breakdown voltage of a Zener diode
        (490.0, None, 509.7, 8.6, 0.989),  # kPa, bursting strength of a container
        (12.5, 16.3, 13.6, 1.8, 0.66),  # mm^2/s, viscosity of a motor oil
    ],
)
def test_the_examples_of_jcgm_106(low, high, value, u, published):
    """Section 7 of the guide, typed from memory: the pages were not at hand."""
    requirement = Requirement("friction", "N", low=low, high=high)
    measured = Measurement(value, u95=u * stats.norm.ppf(0.975))
    found = probability_of_conformity(requirement, measured)
    assert found == pytest.approx(published, abs=0.006)


@pytest.mark.parametrize(
    ("value", "simple", "guarded"),
    [(91.9, "PASS", "PASS"), (92.1, "PASS", "MARGINAL"), (100.0, "PASS", "MARGINAL")]
    + [(100.1, "FAIL", "FAIL"), (88.1, "PASS", "PASS"), (87.9, "PASS", "MARGINAL")]
    + [(79.9, "FAIL", "FAIL")],
)
def test_a_guard_band_lies_inside_the_limits(value, simple, guarded):
    measured = Measurement(value, u95=8.0)
    assert decide(BETWEEN, measured, "simple").decision == simple
    assert decide(BETWEEN, measured, "guard_band").decision == guarded


def test_at_the_end_of_a_guard_band_one_cylinder_in_forty_does_not_conform():
    decided = decide(HIGHEST, Measurement(92.0, u95=8.0), "guard_band")
    assert decided[:2] == ("PASS", pytest.approx(0.975, abs=1e-6)) and not decided.reason


def test_shared_risk_decides_only_where_the_uncertainty_is_small_enough():
    assert decide(HIGHEST, Measurement(99.0, u95=9.0), "shared_risk", 0.1).decision == "PASS"
    assert decide(HIGHEST, Measurement(101.0, u95=9.0), "shared_risk", 0.1).decision == "FAIL"
    refused = decide(HIGHEST, Measurement(50.0, u95=11.0), "shared_risk", 0.1)
    assert refused.decision == "NOT TESTED" and "11 %" in refused.reason


def test_between_two_limits_the_uncertainty_is_compared_with_half_of_their_distance():
    from_zero = Requirement("friction", "N", low=0.0, high=100.0)
    assert decide(from_zero, Measurement(50.0, u95=4.9), "shared_risk", 0.1).decision == "PASS"
    assert decide(from_zero, Measurement(50.0, u95=5.1), "shared_risk", 0.1).decision != "PASS"
    limit = {"quantity": "friction", "min": "0 N"}
    shared = {"rule": "shared_risk", "largest_uncertainty": "10 %"}
    with pytest.raises(ConfigError, match="must not be 0"):
        parse_limits({"limits": [limit], **shared}, "limits.yaml")


def test_without_an_uncertainty_only_the_simple_rule_decides():
    measured = Measurement(50.0, u95=None)
    assert decide(HIGHEST, measured, "simple")[:3] == ("PASS", None, "")
    assert decide(HIGHEST, measured, "guard_band").decision == "NOT TESTED"


@pytest.mark.parametrize("rule", ["simple", "guard_band"])
def test_false_decisions_on_1000_cylinders_are_as_frequent_as_computed(rule):
    """Global risks of JCGM 106, 9.3, by integration over production and measurement.

    Each cylinder is measured in four trials whose scatter is not known to the rule, with an error
    of the instruments that is: the interval is Student's with effective degrees of freedom.
    """
    rng = np.random.default_rng(7)
    made, spread, trials, scatter, instruments = 90.0, 8.0, 4, 3.0, 2.0
    u = np.hypot(scatter / np.sqrt(trials), instruments)
    accepts_wrongly = rejects_wrongly = predicted = 0.0
    accepted_of = 1000
    for _ in range(accepted_of):
        truth = rng.normal(made, spread)
        shown = truth + rng.normal(0, instruments) + rng.normal(0, scatter, trials)
        a, b = shown.std(ddof=1) / np.sqrt(trials), instruments
        dof = (a**2 + b**2) ** 2 / (a**4 / (trials - 1))
        u95 = float(special.stdtrit(dof, 0.975) * np.hypot(a, b))
        decided = decide(HIGHEST, Measurement(float(shown.mean()), u95, dof), rule)
        accepted = decided.decision == "PASS"
        accepts_wrongly += accepted and truth > 100
        rejects_wrongly += not accepted and truth <= 100
        predicted += accepted * (1 - decided.probability)
    edge = 100.0 if rule == "simple" else 100.0 - 1.959964 * u

    def passing(y):
        return stats.norm.cdf((edge - y) / u) * stats.norm.pdf(y, made, spread)

    consumer = integrate.quad(passing, 100.0, made + 8 * spread)[0]
    producer = stats.norm.cdf((100 - made) / spread) - integrate.quad(passing, 0.0, 100.0)[0]
    print(f"{rule}: accepted wrongly {accepts_wrongly:.0f} of 1000, computed {1000 * consumer:.1f}")
    print(f"{rule}: rejected wrongly {rejects_wrongly:.0f} of 1000, computed {1000 * producer:.1f}")
    for counted, risk in ((accepts_wrongly, consumer), (rejects_wrongly, producer)):
        assert abs(counted / 1000 - risk) < 4 * np.sqrt(risk / 1000) + 0.003
    assert (accepts_wrongly <= 10) == (rule == "guard_band")


@pytest.fixture(scope="module")
def small():
    return derive(load_campaign(ROOT / "data_samples" / "stribeck-small"))


def requirements(*limits):
    return [limit.requirement for limit in parse_limits({"limits": list(limits)}, "limits").limits]


def checks(results, *limits, rule="simple"):
    return conformity_checks(results, requirements(*limits), rule, None)


def test_each_series_is_decided_by_its_worst_speed(small):
    found = checks(small, {"quantity": "friction", "max": "1 kN"})
    curves = [curve for curve in small.curves if curve.kind == "steady"]
    assert len(found) == len(curves)
    by_series = {series_key(check.measurement): check for check in found}
    for curve in curves:
        check = by_series[series_key(curve)]
        worst = max(curve.points, key=lambda point: abs(point.friction_n))
        assert check.measurement.value == pytest.approx(abs(worst.friction_n))
        assert check.measurement.u95 == worst.u95_n
        assert check.measurement.runs == worst.runs


def test_an_efficiency_of_three_trials_without_instruments_has_students_distribution(small):
    def trials_alone(point):
        return replace(point, sigma=None, u95=None, u95_dof=None)

    curves = [replace(c, points=tuple(map(trials_alone, c.points))) for c in small.efficiency]
    limit = {"quantity": "efficiency", "min": "75 %"}
    found = checks(replace(small, efficiency=tuple(curves)), limit)
    points = {point.efficiency: point for curve in curves for point in curve.points}
    assert len(found) > 1
    for check in found:
        point = points[check.measurement.value]
        expected = stats.t(2).cdf((point.efficiency - 0.75) / point.sigma_trials)
        assert check.probability == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(("expansion", "drift_n"), [("t_95", 0.0), ("k_2", 0.0), ("t_95", 40.0)])
def test_the_probability_has_the_combined_uncertainty_whatever_u_is(small, expansion, drift_n):
    """U is 2 u, or contains a drift that is not in the trials' degrees of freedom."""
    stated = {"tolerance": "0.1 %", "full_scale": "10 kN"}, {"tolerance": "0.1 %"}
    force, pressure = stated[0], stated[1] | {"full_scale": "250 bar"}
    instruments = Instruments.model_validate(
        {"force": force, "pressure": pressure, "expansion": expansion}
    )
    curve = with_instruments(small.curves[0], instruments)
    old = curve.points[0]
    dofs = combined([of_trials(old.ci95_n, old.n), of_instruments(old)])
    u = np.hypot(dofs.value, drift_n)
    dof = dofs.dof * (u / dofs.value) ** 4
    if drift_n:
        drift = replace(small.drift, scale="absolute", change=drift_n, change_ci95=0.0, p=0.0)
        clock = RunClock(
            {run: float(run in old.runs) for p in curve.points for run in p.runs}, True
        )
        place = campaign_place([curve], clock)(old)
        drift = replace(drift, change=drift_n / place, dof=9, separated=True)
        (curve,) = with_drift([curve], drift, clock)
        assert curve.points[0].sigma_drift_n == pytest.approx(drift_n)
    curve = replace(curve, points=curve.points[:1])
    value = abs(old.friction_n)
    (check,) = checks(
        replace(small, curves=(curve,)), {"quantity": "friction", "max": f"{value + u} N"}
    )
    assert check.probability == pytest.approx(stats.t(dof).cdf(1.0), abs=2e-4)
    (certified,) = (
        each
        for each in certified_values(replace(small, curves=(curve,)), instruments)[0]
        if each.quantity == "friction"
    )
    assert certified.k * u == pytest.approx(curve.points[0].u95_n)


def test_a_leakage_of_three_holds_has_students_distribution(small):
    """The interval of three holds is 4.303 standard errors."""
    se = 2e-17
    interval = (1e-15 - 4.303 * se, 1e-15 + 4.303 * se)
    coefficient = LeakCoefficient("piston_side_out", 1e-15, se, interval)
    holds = tuple(Decay(f"{n}", Series("", None, None), 6e6, 4e6, -1, -1, 0, 0) for n in range(3))
    leakage = Leakage("", (coefficient,), holds, 7e8, "")
    measured = replace(small, motions=replace(small.motions, leakages=(leakage,)))
    limit = {"quantity": "leakage", "leak": "piston_side_out", "pressure": "60 bar"}
    (check,) = checks(measured, limit | {"max": "0.37 ml/min"})
    expected = stats.t(2).cdf((0.37e-6 / 60 - 1e-15 * 6e6) / (se * 6e6))
    assert check.probability == pytest.approx(expected, abs=1e-4)
    (check,) = checks(measured, limit | {"pressure": "100 bar", "max": "1 ml/min"})
    assert check.reason == "the highest mean pressure of a hold is 60 bar"  # its start is higher


def test_a_pressure_is_that_on_the_driving_area(small):
    in_n = checks(small, {"quantity": "friction", "max": "1 kN"})
    in_bar = checks(small, {"quantity": "friction", "max": "1 bar"})
    specimen = small.runs[0].run.plan.specimen
    areas = {"extend": specimen.area_piston_m2, "retract": specimen.area_rod_m2}
    for force, pressure in zip(in_n, in_bar, strict=True):
        area = areas[force.measurement.direction]
        assert pressure.measurement.value == pytest.approx(force.measurement.value / area)
        assert pressure.measurement.u95 == pytest.approx(force.measurement.u95 / area)


def test_a_pressure_of_each_series_is_that_on_the_area_of_its_own_cylinder(small):
    """Seals of two bores in one campaign: 60/30 mm beside the sample's."""
    other = Specimen(np.pi / 4 * 0.06**2, np.pi / 4 * (0.06**2 - 0.03**2))
    first, *others = small.curves
    both = replace(small, curves=(replace(first, specimen=other, label="60 mm"), *others))
    areas = {"extend": other.area_piston_m2, "retract": other.area_rod_m2}
    in_n, in_bar = (
        checks(both, {"quantity": "friction", "label": "60 mm", "max": limit})[0].measurement
        for limit in ("1 kN", "9 bar")
    )
    assert in_bar.value == pytest.approx(in_n.value / areas[first.direction])
    assert in_bar.u95 == pytest.approx(in_n.u95 / areas[first.direction])
    certified, _ = certified_values(both, None)
    of_other = [each for each in certified if each.measurement.label == "60 mm"]
    forces = [each for each in of_other if each.quantity == "friction"]
    assert forces
    for each in forces:
        expected = each.measurement.value / areas[first.direction]
        assert each.pressure_pa == pytest.approx(expected)


def test_the_way_back_of_a_plunger_is_not_passed_over_by_a_limit_in_bar(small):
    """A weight moves it, so that no oil drives it."""
    area = small.curves[0].specimen.area_piston_m2
    curves = [replace(each, specimen=Specimen(area, 0.0)) for each in small.curves]
    plunger = replace(small, curves=tuple(curves))
    limit = {"quantity": "friction", "max": "9 bar"}
    *driven, back = checks(plunger, limit)
    assert {check.measurement.direction for check in driven} == {"extend"}
    assert (back.decision, back.measurement) == ("NOT TESTED", None)
    assert "retracting plunger" in back.reason
    for other in (limit | {"direction": "extend"}, limit | {"max": "9 kN"}):
        assert all(check.measurement for check in checks(plunger, other))


def test_the_breakaway_of_a_plungers_way_back_is_not_passed_over_by_a_limit_in_bar(small):
    area = small.curves[0].specimen.area_piston_m2

    def breakaway(direction, breakaway_pa):
        return Breakaway(
            *(Series("", 0.0, None), direction, 60.0, 200.0, 400.0, 8.0, 12.0, 3, (400.0,) * 3),
            *(1e-3, 5e5, None, 0.0, ("0001", "0002", "0003")),
            breakaway_pa=breakaway_pa,
        )

    both = breakaway("extend", 400.0 / area), breakaway("retract", None)
    plunger = replace(small, motions=replace(small.motions, breakaways=both))
    runs = tuple(
        replace(r, run=replace(r.run, plan=replace(r.run.plan, specimen=Specimen(area, 0.0))))
        for r in small.runs
    )
    plunger = replace(plunger, runs=runs)
    limit = {"quantity": "breakaway", "max": "9 bar"}
    driven, back = checks(plunger, limit)
    assert driven.measurement.direction == "extend"
    assert (back.decision, back.measurement) == ("NOT TESTED", None)
    assert "retracting plunger" in back.reason
    for other in (limit | {"direction": "extend"}, limit | {"max": "9 kN"}):
        assert all(check.measurement for check in checks(plunger, other))


def test_a_campaign_of_two_sizes_of_cylinders_gets_no_certificate(small):
    """The certificate would state the bore of the first as that of its item."""
    first, *others = small.runs
    plan = replace(first.run.plan, specimen=Specimen(3e-3, 2e-3))
    mixed = replace(small, runs=(replace(first, run=replace(first.run, plan=plan)), *others))
    assert not any("sizes" in reason for reason in why_not_certified(small))
    assert any("2 sizes of cylinders" in reason for reason in why_not_certified(mixed))


def test_the_headlines_pressure_is_what_the_chambers_and_the_load_cell_leave(small):
    """Of the driving side, less the other side's and the load's share of it."""
    specimen = small.runs[0].run.plan.specimen
    a_p, a_r = specimen.area_piston_m2, specimen.area_rod_m2
    compared = 0
    for series in small.headline.series:
        for curve in small.curves:
            same = (curve.direction, curve.f_load_n) == (series.direction, series.f_load_n)
            for point in curve.points if same else ():
                if abs(point.v_m_s) != series.v_m_s:
                    continue
                drag = point.p_tp_pa - (point.p_tr_pa * a_r + point.f_applied_n) / a_p
                if curve.direction == "retract":
                    drag = point.p_tr_pa - (point.p_tp_pa * a_p - point.f_applied_n) / a_r
                assert series.friction_pa.value == pytest.approx(drag, rel=1e-6)
                assert series.friction_pa.u95 / drag == pytest.approx(
                    series.friction_n.u95 / series.friction_n.value
                )
                compared += 1
    assert compared == len(small.headline.series) > 1


def test_without_hydraulics_a_limit_in_bar_is_not_tested(small):
    def bare(screened):
        plan = replace(screened.run.plan, specimen=Specimen(0.0, 0.0))
        return replace(screened, run=replace(screened.run, plan=plan))

    without = tuple(replace(curve, specimen=Specimen(0.0, 0.0)) for curve in small.curves)
    drive = replace(small, runs=tuple(map(bare, small.runs)), curves=without)
    (check,) = checks(drive, {"quantity": "friction", "max": "1 bar"})
    assert check.decision == "NOT TESTED" and "area" in check.reason
    assert checks(drive, {"quantity": "friction", "max": "1 kN"})[0].measurement is not None


def test_what_was_not_measured_is_not_tested_and_the_nearest_is_stated(small):
    (check,) = checks(small, {"quantity": "friction", "speed": "333 mm/s", "max": "1 kN"})
    assert check.decision == "NOT TESTED" and check.measurement is None
    assert check.reason == "no speed within 5 % of 333 mm/s was measured; nearest: 180 mm/s"
    for quantity, limit in (("breakaway", "5 N"), ("drift", "5 %")):
        (check,) = checks(replace(small, drift=None), {"quantity": quantity, "max": limit})
        assert check.decision == "NOT TESTED" and check.reason


def test_points_at_which_every_run_was_rejected_are_not_tested(small):
    """Nothing is known of them, although the other points pass."""

    def screened(each, rejected):
        plan = each.run.plan
        slow = plan.kind == "steady" and plan.direction == "retract" and plan.v_ref_m_s > -0.03
        return replace(each, reasons=("not_steady: x",)) if slow and rejected(plan) else each

    def with_rejected(rejected):
        runs = tuple(screened(each, rejected) for each in small.runs)
        return checks(replace(small, runs=runs), {"quantity": "friction", "max": "9 kN"})

    before = with_rejected(lambda plan: False)
    assert with_rejected(lambda plan: plan.trial == 1) == before
    passed, missing = [], []
    for check in with_rejected(lambda plan: True):
        (missing if check.measurement is None else passed).append(check)
    assert all(check.decision == "PASS" for check in passed)
    assert missing and all(check.decision == "NOT TESTED" for check in missing)
    assert all("retracting" in check.reason for check in missing)
    assert all("no run was accepted (not_steady)" in check.reason for check in missing)


def test_a_drift_is_limited_both_ways(small):
    (requirement,) = requirements({"quantity": "drift", "max": "5 %"})
    assert (requirement.low, requirement.high) == pytest.approx((-0.05, 0.05))


def test_a_drift_that_is_extrapolated_from_the_order_of_files_is_not_tested(small):
    drift = replace(small.drift, basis="order", separated=False)
    (check,) = checks(replace(small, drift=drift), {"quantity": "drift", "max": "10 %"})
    assert (check.decision, check.measurement) == ("NOT TESTED", None)
    assert "order of their files does not separate a drift from speed" in check.reason


def test_the_ripple_is_that_of_screening(small):
    found = checks(small, {"quantity": "speed_ripple", "max": "5 %"})
    assert found and all(0 < check.measurement.value < 0.05 for check in found)
    assert all(check.decision == "PASS" for check in found)


def test_series_without_a_stated_speed_are_in_the_order_of_speed_direction_and_load(small):
    """Runs are made in random order, and each series may have its worst ripple elsewhere."""
    mixed = replace(small, runs=tuple(np.random.default_rng(4).permutation(np.array(small.runs))))
    found = [each.measurement for each in checks(mixed, {"quantity": "speed_ripple", "max": "5 %"})]
    places = [(round(1e3 * m.v_m_s, 1), m.direction, abs(m.f_load_n)) for m in found]
    assert len({speed for speed, *_ in places}) > 1
    assert places == sorted(places)


@pytest.mark.parametrize(
    "limits",
    [
        {"quantity": "friction"},
        {"quantity": "friction", "max": "5 mm"},
        {"quantity": "efficiency", "max": "5 N"},
        {"quantity": "friction", "max": "5 N", "dwell": "3 s"},
        {"quantity": "leakage", "max": "5 ml/min"},
        {"quantity": "friction", "min": "5 N", "max": "4 N"},
        {"quantity": "wear", "max": "5 N"},
        {"quantity": "speed_ripple", "max": 5},
        {"quantity": "efficiency", "min": "0.8"},
        {"quantity": "friction", "max": "-900 N"},
        {"quantity": "friction", "max": "0 N"},
        {"quantity": "breakaway", "min": "-1 bar", "max": "3 bar"},
        {"quantity": "efficiency", "min": "950 %"},
        {"quantity": "efficiency", "min": "75 %", "max": "101 %"},
        {"quantity": "leakage", "pressure": "100 bar", "max": "-1 ml/min"},
        {"quantity": "drift", "max": "-5 %"},
    ],
)
def test_a_limit_that_says_nothing_is_refused_with_its_place(limits):
    with pytest.raises(ConfigError) as refused:
        parse_limits({"limits": [limits]}, "limits.yaml")
    assert "limits.yaml" in refused.value.message
    assert "limits.0" in refused.value.message


@pytest.mark.parametrize(
    ("limit", "words"),
    [
        ({"quantity": "friction", "max": "-900 N"}, "max = -900 N: can never be met"),
        ({"quantity": "efficiency", "min": "950 %"}, "min = 950 %: can never be met"),
        ({"quantity": "efficiency", "max": "120 %"}, "max = 120 %: is always met"),
        ({"quantity": "friction", "min": "-9 N"}, "min = -9 N: is always met"),
        ({"quantity": "drift", "max": "-5 %"}, "max = -5 %: must be positive"),
    ],
)
def test_a_limit_that_no_or_every_value_meets_is_refused_with_the_reason(limit, words):
    with pytest.raises(ConfigError, match=words):
        parse_limits({"limits": [limit]}, "limits.yaml")


@pytest.mark.parametrize(
    "limit",
    [
        {"quantity": "efficiency", "min": "0 %", "max": "100 %"},
        {"quantity": "leakage", "pressure": "100 bar", "max": "0 ml/min"},
        {"quantity": "drift", "min": "-5 %", "max": "0 %"},
    ],
)
def test_limits_at_the_ends_of_what_is_possible_are_kept(limit):
    assert parse_limits({"limits": [limit]}, "limits.yaml").limits


@pytest.mark.parametrize("rule", ["simple", "guard_band", "shared_risk"])
@pytest.mark.parametrize(
    ("quantity", "limits", "value", "u95", "words"),
    [
        ("friction", {"high": 240.0}, -511.0, 11.0, "friction has the direction of the motion"),
        ("breakaway", {"high": 240.0}, -2.0, None, "friction has the direction of the motion"),
        ("efficiency", {"low": 0.75, "high": None}, 2.0, 0.05, "the efficiency is above 100 %"),
    ],
)
def test_an_impossible_value_passes_no_limit(rule, quantity, limits, value, u95, words):
    requirement = Requirement(quantity, "%", **{"low": None, **limits})
    measured = Measurement(value, u95)
    decided = decide(requirement, measured, rule, 0.5)
    assert (decided.decision, decided.reason) == ("NOT TESTED", words)
    check = ConformityCheck(requirement, measured, None, "NOT TESTED", words)
    assert [step for _, step in next_steps([check])] == [
        "check the signs, zeros and units of the channels, and the areas, then repeat hbench accept"
    ]


@pytest.mark.parametrize("rule", ["simple", "guard_band", "shared_risk"])
def test_a_leakage_against_its_pressure_passes_no_limit(rule):
    requirement = Requirement("leakage", "ml/min", low=None, high=8e-8, leak="rod_side_out")
    against, within = Measurement(-2e-8, 5e-9), Measurement(-4e-9, 5e-9)
    decided = decide(requirement, against, rule, 0.5)
    assert decided.decision == "NOT TESTED" and "negative by more than U" in decided.reason
    assert decide(requirement, within, rule, 0.5).decision == "PASS"
    check = ConformityCheck(requirement, against, None, "NOT TESTED", decided.reason)
    ((_, step),) = next_steps([check])
    assert "oil temperature" in step and "areas" not in step


def test_a_value_that_is_impossible_within_its_uncertainty_is_decided():
    assert decide(HIGHEST, Measurement(-3.0, 11.0), "guard_band").decision == "PASS"


def test_a_largest_uncertainty_belongs_to_shared_risk():
    limit = {"quantity": "drift", "max": "5 %"}
    for extra in ({"rule": "shared_risk"}, {"largest_uncertainty": "10 %"}):
        with pytest.raises(ConfigError):
            parse_limits({"limits": [limit], **extra}, "limits.yaml")


def test_the_decision_states_the_value_nearest_to_its_limit():
    """15 N is 2.5 times a U of 6 N; the other value is farther from its limit."""

    def decided(u95, rule="guard_band", near=85.0):
        measured = Measurement(near, u95), Measurement(50.0, 4.0)
        return [
            ConformityCheck(HIGHEST, each, 0.99, decide(HIGHEST, each, rule).decision)
            for each in measured
        ]

    def words(decision, checks, rule="guard_band"):
        return decision_section(decision, checks, rule).paragraphs[0]

    passed = words("PASS", decided(6.0))
    assert passed.startswith("PASS: 2 of 2 checks pass. Nearest to its limit in multiples of U is")
    assert "85.0 ± 6.0 N, limit at most 100 N, margin 15 N, probability" in passed
    assert [check.decision for check in decided(2.49 * 6.0)] == ["PASS", "PASS"]
    assert [check.decision for check in decided(2.51 * 6.0)] == ["MARGINAL", "PASS"]
    failed = words("FAIL", decided(6.0, near=109.0))
    assert failed.startswith("FAIL: 1 of 2 checks fails (friction). Farthest beyond its limit in")
    assert "is friction: 109.0 ± 6.0 N, limit at most 100 N" in failed
    seal = replace(HIGHEST, name="rod seal")
    named = [ConformityCheck(seal, Measurement(109.0, 6.0), 0.01, "FAIL")]
    assert " is rod seal (friction): 109.0 ± 6.0 N, limit at most" in words("FAIL", named)
    marginal = words("MARGINAL", decided(6.0, near=96.0))
    assert "MARGINAL: 1 of 2 checks is too near its limit for its U (friction). Near" in marginal
    others = [*decided(6.0, near=109.0), *decided(6.0, near=96.0), *decided(6.0, near=97.0)]
    assert (
        " (friction). Of the other 5, 2 are too near their limits for their U and 3 pass. Farthest"
    ) in words("FAIL", others)
    unknown = [ConformityCheck(HIGHEST, Measurement(85.0, None), None, "PASS")]
    assert " U" not in words("PASS", unknown, "simple")


def measured_checks(*quantities):
    return [
        ConformityCheck(Requirement(quantity, "", None, 1.0), Measurement(0.5, 0.1), 0.99, "PASS")
        for quantity in quantities
    ]


@pytest.mark.parametrize(
    ("quantities", "words"),
    [
        (("friction", "efficiency"), "U"),
        (("friction", "breakaway", "leakage"), "U of friction and breakaway"),
        (("friction", "speed_ripple"), "U of friction"),
        (("speed_ripple", "leakage"), ""),
    ],
)
def test_u_of_ripple_and_leakage_does_not_contain_the_instruments(quantities, words):
    assert complete_u(measured_checks(*quantities)) == words


def test_the_decisions_on_leakage_state_what_its_u_leaves_out():
    _, terms = decision_section("PASS", measured_checks("leakage"), "guard_band").parts
    facts = dict(terms.facts)
    assert "an assumed error of 10 % of the effective bulk modulus" in facts["U of leakage"]
    assert "an assumption for leakage" in facts["Conforms"]
    assert "drift of transducers" in facts["U of leakage"]
    _, without = decision_section("PASS", measured_checks("friction"), "guard_band").parts
    assert "U of leakage" not in dict(without.facts)


def test_a_leakage_has_the_step_of_its_pressures_and_the_loads_of_its_holds():
    friction = ConformityCheck(
        HIGHEST, Measurement(8.0, 1.0, direction="extend", f_load_n=0.0), 0.99, "PASS"
    )
    (leak,) = measured_checks("leakage")
    holds = Measurement(0.5, 0.1, step_pa=360.0, lowest_load_n=-10000.0, highest_load_n=11500.0)
    checks = [friction, replace(leak, measurement=holds)]
    section = decision_section("PASS", checks)
    facts = dict((*section.facts, *section.parts[1].facts))
    assert facts["Load"] == "Friction: 0 N; leakage: holds at −10000 to 11500 N."
    assert "smallest step of its logged values (0.0036 bar)" in facts["U of leakage"]


def test_a_load_that_all_series_have_is_stated_once():
    def section(*loads):
        checks = [
            ConformityCheck(
                HIGHEST, Measurement(8.0, 1.0, direction="extend", f_load_n=load), 0.99, "PASS"
            )
            for load in loads
        ]
        made = decision_section("PASS", checks)
        rows = made.parts[0].tables[0].rows
        return [str(row[2].text) for row in rows], dict(made.facts).get("Load")

    assert section(500.0, 500.0) == (["extending"] * 2, "Friction: 500 N.")
    assert section(500.0, 900.0) == (["extending, load 500 N", "extending, load 900 N"], None)


def test_reasons_are_facts_by_the_limits_that_they_are_of():
    check = ConformityCheck(HIGHEST, None, None, "NOT TESTED", "no run was made")
    section = decision_section("NOT TESTED", [check])
    assert ("Friction", "No run was made.") in section.facts
    assert "Reason" not in section.parts[0].tables[0].head


def test_the_next_step_after_a_limit_that_was_not_tested_is_that_of_its_reason():
    missing = ConformityCheck(HIGHEST, None, None, "NOT TESTED", "no runs")
    too_uncertain = ConformityCheck(
        HIGHEST, Measurement(85.0, 60.0), 0.7, "NOT TESTED", "U is 60 %"
    )
    ((_, only_missing),) = next_steps([missing])
    ((_, only_uncertain),) = next_steps([too_uncertain])
    ((_, both),) = next_steps([missing, too_uncertain])
    assert only_missing == "measure what is missing, then repeat hbench accept"
    assert "reduce U" in only_uncertain and "missing" not in only_uncertain
    assert "measure what is missing and reduce U" in both


@pytest.mark.parametrize(
    ("limits", "causes", "reason"),
    [
        (
            {"load": "1 kN", "speed": "100 mm/s"},
            ("speed",),
            "no speed within 5 % of 100 mm/s was measured; nearest: 84.8 mm/s and 128 mm/s",
        ),
        (
            {"load": "9 kN", "speed": "180 mm/s"},
            ("load",),
            "no load within 5 % of 9000 N was measured; nearest: 5000 N",
        ),
        (
            {"load": "-700 N", "speed": "300 mm/s"},
            ("speed", "load"),
            "no speed within 5 % of 300 mm/s was measured; nearest: 180 mm/s; "
            "no load within 5 % of −700 N was measured; nearest: −1000 N and 1000 N",
        ),
    ],
)
def test_not_tested_states_which_value_of_the_limit_was_not_measured(small, limits, causes, reason):
    (check,) = checks(small, {"quantity": "friction", "max": "900 N"} | limits)
    assert (check.decision, check.causes, check.reason) == ("NOT TESTED", causes, reason)


def test_not_tested_states_the_series_that_were_measured(small):
    curves = tuple(replace(curve, label="NBR") for curve in small.curves)
    limit = {"quantity": "friction", "max": "900 N", "label": "nbr"}
    (check,) = checks(replace(small, curves=curves), limit)
    assert check.reason == "only other series were measured: NBR extending, NBR retracting"


def test_not_tested_states_that_speed_and_load_were_not_measured_together(small):
    """The larger loads are without their points above 50 mm/s."""
    curves = tuple(
        replace(curve, points=tuple(p for p in curve.points if abs(p.v_m_s) < 0.06))
        if abs(curve.f_load_n) > 1000
        else curve
        for curve in small.curves
    )
    limit = {"quantity": "friction", "max": "900 N", "load": "5 kN", "speed": "180 mm/s"}
    (check,) = checks(replace(small, curves=curves), limit)
    assert check.reason == "speed and load were measured, but not together"
