"""Uncertainty budgets against another library, drawn readings and the limits of their formulas."""

from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from hbench.analysis.curves.average import student_interval
from hbench.analysis.uncertainty.budget import (
    StandardUncertainty,
    combined,
    errors_of,
    friction_contributions,
    of_instruments,
    of_trials,
    with_instruments,
)
from hbench.analysis.uncertainty.efficiency import efficiency_curve
from hbench.analysis.uncertainty.monte_carlo import checked_by_monte_carlo, standardised
from hbench.config.sensors import Instruments
from hbench.errors import DataError

GAINS = {"load cell": 0.01, "piston-side pressure": 0.008, "rod-side pressure": 0.008}


@pytest.fixture
def instruments():
    return Instruments.model_validate(
        {
            "force": {"tolerance": "1.0 %", "of": "reading", "full_scale": "12 kN"},
            "pressure": {"tolerance": "0.8 %", "of": "reading", "full_scale": "250 bar"},
        }
    )


@pytest.fixture
def curve(make_curve):
    """Five speeds, three trials each."""
    speeds = np.array([0.01, 0.03, 0.06, 0.1, 0.19])
    friction = np.array([520.0, 410.0, 380.0, 400.0, 480.0])
    made = make_curve(speeds, friction, f_applied_n=2000.0)
    rng = np.random.default_rng(5)
    points = []
    for point in made.points:
        off = rng.normal(0, 8.0, 3)
        off -= off.mean()
        trials_n = tuple((point.friction_n + off).tolist())
        f_test = tuple((point.f_test_n + off).tolist())
        own = replace(point, n=3, trials_n=trials_n, trials_f_test_n=f_test)
        points.append(replace(own, ci95_n=student_interval(trials_n)))
    return replace(made, points=tuple(points))


def shared_errors(curve):
    """The readings of each point, with one error for each instrument in all of them."""
    uncertainties = pytest.importorskip("uncertainties")
    gain = {name: uncertainties.ufloat(1.0, limit / 3**0.5) for name, limit in GAINS.items()}
    areas = curve.specimen
    for point in curve.points:
        f_test = (
            point.p_tp_pa * gain["piston-side pressure"] * areas.area_piston_m2
            - point.p_tr_pa * gain["rod-side pressure"] * areas.area_rod_m2
        )
        yield f_test, point.f_applied_n * gain["load cell"]


def test_the_instruments_part_of_a_mean_is_that_of_the_uncertainties_package(curve, instruments):
    etas = [f_applied / f_test for f_test, f_applied in shared_errors(curve)]
    mean = efficiency_curve(curve, instruments).mean
    expected = sum(etas) / len(etas)
    assert mean.efficiency == pytest.approx(expected.nominal_value, rel=1e-9)
    assert mean.sigma == pytest.approx(expected.std_dev, rel=1e-9)


def test_errors_of_instruments_do_not_average_out_and_those_of_trials_do(curve, instruments):
    found = efficiency_curve(curve, instruments)
    sigmas = [point.sigma for point in found.points]
    of_trials = [point.sigma_trials for point in found.points]
    assert min(sigmas) <= found.mean.sigma <= max(sigmas)
    assert found.mean.sigma_trials == pytest.approx(np.sqrt(np.mean(np.square(of_trials)) / 5))
    assert found.mean.sigma_combined == pytest.approx(
        np.hypot(found.mean.sigma, found.mean.sigma_trials)
    )


def test_frictions_part_is_that_of_the_uncertainties_package(curve, instruments):
    found = with_instruments(curve, instruments)
    for point, (f_test, f_applied) in zip(found.points, shared_errors(curve), strict=True):
        assert point.sigma_instruments_n == pytest.approx((f_test - f_applied).std_dev, rel=1e-9)
        parts = friction_contributions(point, curve.specimen, instruments)
        assert parts["load cell"].value == pytest.approx(-0.01 * 2000.0 / 3**0.5)
        assert combined(list(parts.values())).value == pytest.approx(point.sigma_instruments_n)


def test_without_tolerances_a_curve_stays_as_it_is(curve):
    assert with_instruments(curve, None) is curve


def with_sources(**sections):
    """The instruments of a bench with further sources of error."""
    base = {
        "force": {"tolerance": "1.0 %", "of": "reading", "full_scale": "12 kN"},
        "pressure": {"tolerance": "0.8 %", "of": "reading", "full_scale": "250 bar"},
    }
    return Instruments.model_validate(
        {name: base.get(name, {}) | sections.get(name, {}) for name in {*base, *sections}}
    )


@pytest.mark.parametrize(
    ("distribution", "divisor"),
    [("rectangular", 3**0.5), ("triangular", 6**0.5), ("normal", 2.0), ("standard", 1.0)],
)
def test_a_tolerance_has_the_standard_uncertainty_of_its_distribution(curve, distribution, divisor):
    """And the divisor is that of draws between these limits, but for the stated ones."""
    stated = {"distribution": distribution}
    parts = friction_contributions(
        curve.points[0], curve.specimen, with_sources(force=stated, pressure=stated)
    )
    assert parts["load cell"].value == pytest.approx(-0.01 * 2000.0 / divisor)
    error = errors_of(curve.points[0], curve.specimen, with_sources(force=stated))[0]
    drawn = standardised(error, np.random.default_rng(0), 200_000)
    assert np.std(drawn) == pytest.approx(1.0, rel=0.01)
    if distribution in ("rectangular", "triangular"):
        assert np.abs(drawn).max() == pytest.approx(divisor, rel=0.01)


def test_tolerances_are_of_full_scale_unless_the_file_tells_otherwise():
    stated = Instruments.model_validate(
        {
            "force": {"tolerance": "1 %", "full_scale": "10 kN"},
            "pressure": {"tolerance": "1 %", "full_scale": "250 bar"},
        }
    )
    assert stated.force.of == stated.pressure.of == "full_scale"
    assert stated.force.standard_uncertainty(stated.force, 3.0) == pytest.approx(100 / 3**0.5)


def test_every_source_of_error_is_an_input_and_a_common_one_keeps_its_sign(curve):
    """Both transducers calibrated against one standard: its error partly cancels in A_p and A_r."""
    zero = {"tolerance": "0.5 %", "source": "data sheet"}
    standard = {"tolerance": "0.2 %", "of": "reading", "distribution": "normal", "common": True}
    known = with_sources(pressure={"further": {"zero": zero, "standard": standard | {"dof": 9}}})
    point, areas = curve.points[0], curve.specimen
    errors = {error.name: error for error in errors_of(point, areas, known)}
    assert list(errors) == [
        "load cell",
        *("piston-side pressure", "piston-side pressure, zero"),
        *("pressures, standard", "rod-side pressure", "rod-side pressure, zero"),
    ]
    offset = 0.005 * 250e5 / 3**0.5
    assert errors["piston-side pressure, zero"].f_test_n == pytest.approx(
        offset * areas.area_piston_m2
    )
    assert errors["rod-side pressure, zero"].f_test_n == pytest.approx(-offset * areas.area_rod_m2)
    assert errors["pressures, standard"].f_test_n == pytest.approx(0.001 * point.f_test_n)
    assert errors["pressures, standard"].dof == 9
    assert errors["rod-side pressure, zero"].source == "data sheet"


def test_diameters_and_alignment_change_the_forces_as_their_own_differences_do(curve):
    limits = {"bore": "0.05 mm", "rod": "0.02 mm", "alignment": "2 deg"}
    point, areas = curve.points[0], curve.specimen
    errors = {e.name: e for e in errors_of(point, areas, with_sources(geometry=limits))}
    bore = np.sqrt(4 * areas.area_piston_m2 / np.pi)
    rod = np.sqrt(4 * (areas.area_piston_m2 - areas.area_rod_m2) / np.pi)

    def f_test(d_bore, d_rod):
        piston = np.pi / 4 * (bore + d_bore) ** 2
        return point.p_tp_pa * piston - point.p_tr_pa * (piston - np.pi / 4 * (rod + d_rod) ** 2)

    for name, off in (("bore", (5e-5 / 3**0.5, 0.0)), ("rod", (0.0, 2e-5 / 3**0.5))):
        change = (f_test(*off) - f_test(*(-np.array(off)))) / 2
        assert errors[name].f_test_n == pytest.approx(change, rel=1e-6)
    short = point.f_applied_n * (1 - np.cos(np.deg2rad(2))) / 3**0.5
    assert errors["load cell alignment"].f_applied_n == pytest.approx(short)


def test_effective_degrees_of_freedom_by_hand():
    """JCGM 100, G.4.2, and its example H.1.6: 32 nm with 16 degrees of freedom."""
    parts = [(25, 18), (9.7, 25.6), (2.9, 50), (16.6, 2)]
    found = combined([StandardUncertainty(*part) for part in parts])
    assert found.value == pytest.approx(31.6, abs=0.2)
    assert int(found.dof) == 16
    assert found.expanded() == pytest.approx(2.12 * found.value, rel=0.005)
    assert combined([StandardUncertainty(3.0), StandardUncertainty(4.0)]) == (5.0, np.inf)
    assert StandardUncertainty(5.0).expanded() == pytest.approx(1.959964 * 5.0)


def test_the_factor_is_two_where_the_file_asks_for_it(curve):
    known = with_sources()
    k_2 = known.model_copy(update={"expansion": "k_2"})
    for t_95, two in zip(
        with_instruments(curve, known).points, with_instruments(curve, k_2).points, strict=True
    ):
        standard = np.hypot(two.sigma_instruments_n, of_trials(two.ci95_n, two.n).value)
        assert two.u95_n == pytest.approx(2 * standard)
        assert t_95.u95_n / standard > 1.96


@pytest.mark.parametrize("count", [5_000, pytest.param(20_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("ratio", [0.2, 1.0, 5.0])  # instruments' error over that of the mean
@pytest.mark.parametrize("n", [3, 5])
def test_the_expanded_uncertainty_holds_the_truth(ratio, n, count):
    """Three rectangular errors of unequal size and the trials; 92 to 97 % of the campaigns."""
    rng = np.random.default_rng(1)
    share = np.array([1.0, 0.8, 0.5])
    sigmas = ratio / np.sqrt(n) * share / np.linalg.norm(share)
    errors = rng.uniform(-1, 1, (count, 3)) * 3**0.5 @ sigmas
    trials = rng.standard_normal((count, n)) + errors[:, None]
    inputs = [StandardUncertainty(sigma) for sigma in sigmas]
    held = [
        abs(t.mean()) <= combined([of_trials(student_interval(t), n), *inputs]).expanded()
        for t in trials
    ]
    assert 0.915 < np.mean(held) < 0.97


def test_monte_carlo_agrees_where_many_trials_and_many_inputs_make_it_normal(curve):
    points = []
    rng = np.random.default_rng(3)
    for point in curve.points:
        trials = point.friction_n + rng.normal(0, 8.0, 30)
        trials = trials - trials.mean() + point.friction_n
        points.append(
            replace(
                point,
                n=30,
                trials_n=tuple(trials.tolist()),
                trials_f_test_n=tuple((trials + point.f_applied_n).tolist()),
                ci95_n=student_interval(trials),
            )
        )
    known = with_sources(pressure={"further": {"zero": {"tolerance": "0.1 %"}}})
    many = with_instruments(replace(curve, points=tuple(points)), known)
    eta = efficiency_curve(many, known)
    (frictions,), (efficiencies,), notes = checked_by_monte_carlo([many], [eta], known)
    assert all("5 of 5 points" in note for note in notes)
    for point in (*frictions.points,):
        assert point.u95_monte_carlo_n == pytest.approx(point.u95_n, rel=0.04)
    for point in efficiencies.points:
        assert point.u95_monte_carlo == pytest.approx(point.u95, rel=0.04)


def test_monte_carlo_tells_where_one_rectangular_error_dominates(curve):
    """Its 95 % interval is 1.65 standard uncertainties, not 1.96."""
    known = with_sources(force={"tolerance": "20 %"}, pressure={"tolerance": "0.01 %"})
    loud = with_instruments(curve, known)
    (found,), _, notes = checked_by_monte_carlo([loud], [efficiency_curve(loud, known)], known)
    for point in found.points:
        assert point.u95_n / point.u95_monte_carlo_n == pytest.approx(1.96 / 1.645, rel=0.02)
    assert "0 of 5 points" in notes[0]


def test_monte_carlo_needs_tolerances(curve):
    with pytest.raises(DataError, match="--monte-carlo"):
        checked_by_monte_carlo([curve], [efficiency_curve(curve, None)], None)


def test_without_any_error_nothing_is_divided(curve):
    none = with_sources(force={"tolerance": "0 %"}, pressure={"tolerance": "0 %"})
    same = [
        replace(p, trials_n=(p.friction_n,) * 3, trials_f_test_n=(p.f_test_n,) * 3, ci95_n=0.0)
        for p in curve.points
    ]
    exact = with_instruments(replace(curve, points=tuple(same)), none)
    (found,), _, notes = checked_by_monte_carlo([exact], [efficiency_curve(exact, none)], none)
    assert all(point.u95_n == point.u95_monte_carlo_n == 0.0 for point in found.points)
    assert notes[0].endswith("agrees at 5 of 5 points")  # no ratio of zeros


def test_degrees_of_freedom_of_a_tolerance_widen_every_interval_that_contains_it(curve):
    few = with_instruments(curve, with_sources(force={"dof": 1}, pressure={"tolerance": "0 %"}))
    for point in few.points:
        part = of_instruments(point)
        assert part.dof == pytest.approx(1.0)
        assert part.expanded() == pytest.approx(12.706 * point.sigma_instruments_n, rel=1e-3)


def test_a_further_source_of_error_has_a_name():
    for name in ("", " ", "a\nb", "x" * 41):
        with pytest.raises(ValidationError):
            with_sources(pressure={"further": {name: {"tolerance": "1 %"}}})
