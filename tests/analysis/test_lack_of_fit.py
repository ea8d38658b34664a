"""Whether identified laws describe friction of another form: made-up curves and motions."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.identification import identify
from hbench.analysis.identification.identify import identify_laws
from hbench.analysis.identification.lack_of_fit import with_lack_of_fit
from hbench.analysis.identification.position_noise import with_position_noise
from hbench.analysis.screening.sample_friction import logged_motion
from hbench.records import Curve, CurvePoint, Fit, Specimen
from tests.support import driven_axis
from tests.support.analysis import bristle_triangles

SPEEDS = np.array([3, 6, 10, 20, 30, 50, 80, 120]) / 1e3
FORMS = {
    "tustin": lambda v: 120 + 100 * np.exp(-v / 0.012) + 900 * v,
    "power": lambda v: 140 + 90 * np.exp(-((v / 0.012) ** 2)) + 900 * v**0.8,
    "hess": lambda v: 140 + 90 / (1 + (v / 0.02) ** 2) + 900 * v**1.2,
    "arctan": lambda v: 127 * np.arctan(v / 0.004) + 400 * v,
    "hump": lambda v: 150 + 70 * np.sin(2.2 * np.log(v / 0.005)),
}


def curves(form, scatter, seed, offset_n=0.0, parts_n=None):
    """Both directions of ``form`` with three trials a point that differ by ``scatter``."""
    rng, found = np.random.default_rng(seed), []
    for direction, sign in (("extend", 1), ("retract", -1)):
        points = []
        for v in SPEEDS.tolist():
            trials = sign * FORMS[form](v) * (1 + scatter * rng.standard_normal(3)) + offset_n
            mean = float(trials.mean())
            points.append(
                CurvePoint(
                    sign * v, mean, None, 3, mean, 0.0, None, None, (1, 2, 3),
                    tuple(trials.tolist()), tuple(trials.tolist()), ("a", "b", "c"),
                    parts_n=parts_n or {},
                )
            )  # fmt: skip
        specimen = Specimen(0.0, 0.0)
        found.append(Curve("steady", direction, None, None, "", specimen, tuple(points)))
    return found


@pytest.fixture(autouse=True)
def without_further_laws(monkeypatch):
    """Leave out the laws that no test looks at here: they take four fifths of the time."""

    def left_out(*_):
        raise identify._NotDetermined("left out")

    monkeypatch.setattr(identify, "_lines", left_out)
    monkeypatch.setattr(identify, "_leuven", left_out)


def tustin(measured):
    laws = with_lack_of_fit(identify_laws(measured, ()), measured, ())
    return next(law.misfit for law in laws if law.law == "tustin")


@pytest.mark.parametrize("scatter", [0.002, pytest.param(0.01, marks=pytest.mark.slow), 0.04])
@pytest.mark.parametrize("form", FORMS)
def test_only_a_form_that_is_far_from_the_law_is_not_described(form, scatter):
    found = [tustin(curves(form, scatter, seed)) for seed in range(5)]
    assert {fit.describes for fit in found} == {form != "hump"}


def test_the_misfit_is_the_distance_of_the_form_from_the_best_law():
    """Against the distance without any scatter, of which the trials' scatter is no part."""
    exact = tustin(curves("hump", 1e-6, 1))
    for scatter in (0.01, 0.04):
        found = tustin(curves("hump", scatter, 1))
        assert found.misfit_n == pytest.approx(exact.misfit_n, rel=0.1)
        assert found.scatter_n == pytest.approx(scatter * 150 / np.sqrt(3), rel=0.3)


def test_the_law_itself_has_no_misfit():
    found = [tustin(curves("tustin", 0.01, seed)) for seed in range(60)]
    assert sum(fit.significant for fit in found) <= 1  # at a level of 0.001


def test_errors_of_the_instruments_are_no_misfit_up_to_their_tolerances():
    unknown = tustin(curves("tustin", 0.01, 1, offset_n=60.0))
    assert unknown.describes and unknown.error_n == pytest.approx(60.0, rel=0.05)
    wide = tustin(curves("tustin", 0.01, 1, offset_n=60.0, parts_n={"f_applied": 40.0}))
    assert wide.describes
    narrow = tustin(curves("tustin", 0.01, 1, offset_n=60.0, parts_n={"f_applied": 10.0}))
    assert not narrow.describes
    assert narrow.misfit_n == pytest.approx(60 - 1.96 * 10, rel=0.05)


def in_motion(runs, mass_kg):
    motions = [logged_motion(run, mass_kg) for run in runs]
    laws = with_lack_of_fit(identify_laws((), motions), (), motions)
    return next(law for law in laws if law.law == "lugre")


def axis_runs(effect, **options):
    """Runs of the driven axis as a bench without a load cell is imported."""
    runs = driven_axis.axis_runs(effect, count=4, **options)
    return [replace(run, f_applied_n=np.zeros(len(run.t_s))) for run in runs]


@pytest.mark.parametrize("noise_m", [0.0, 5e-6])
@pytest.mark.parametrize("unlike", [False, True])
def test_bristles_of_another_form_are_described_in_motion(noise_m, unlike):
    runs = bristle_triangles.campaign(noise_m, seed=3, unlike=unlike)
    assert in_motion(runs, bristle_triangles.MASS_KG).misfit_in_motion.share < 0.01


def test_a_force_that_the_law_does_not_contain_is_a_misfit_in_motion():
    def spring(motion):
        return 15.0 * np.sign(motion.x_m - driven_axis.CENTRE_M) * np.tanh(motion.v_m_s / 2e-3)

    law = in_motion(axis_runs(spring), driven_axis.MASS_KG + 30)
    assert not law.misfit_in_motion.describes


def test_the_search_without_steady_runs_starts_at_the_size_of_the_friction():
    """Friction of 35 N: a start at hundreds of newtons ended in another minimum."""
    law = in_motion(axis_runs(driven_axis.no_effect), driven_axis.MASS_KG)
    value = {name: parameter.value for name, parameter in law.fit.parameters.items()}
    v = np.array([0.01, 0.03, 0.1, 0.2])
    truth = driven_axis.COULOMB_N * (1 + 0.6 / (1 + (v / 0.04) ** 2))
    truth += driven_axis.VISCOUS * v**0.9
    dry = value["f_stiction_n"] - value["f_coulomb_n"]
    fitted = value["f_coulomb_n"] + dry * np.exp(-v / value["v_stribeck_m_s"])
    fitted += value["b_viscous_n_s_m"] * v
    assert fitted == pytest.approx(truth, rel=0.06)


def test_bristles_that_do_not_deflect_need_no_sensor():
    """A soft layer that shears gave a static friction of zero, which noise was divided by."""
    fit = Fit("lugre", {}, 1.0, True, "")
    run = bristle_triangles.campaign(5e-6, seed=3)[0]
    motions = [logged_motion(run, bristle_triangles.MASS_KG)]
    assert with_position_noise(fit, motions, 0.0) is fit
