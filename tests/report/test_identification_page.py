"""The page of identified laws: the best ones, and what the data does not determine."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from hbench.records import (
    Fit,
    FitParameter,
    Followed,
    Identification,
    IdentifiedLaw,
    LackOfFit,
    LawsAlongCurve,
    ModelErrors,
    Provenance,
    Trace,
)
from hbench.records.identification import PARTS, SteadyParts
from hbench.report.campaign.fit_tables import verdict_words
from hbench.report.identification.page import identification_page
from hbench.report.identification.plant_file import overlay_yaml
from hbench.report.identification.terminal import identification_text
from hbench.report.identification.text import (
    ERRORS,
    SUMMARY,
    identification_json,
    identification_tables,
)
from tests.support.report.spaces import ordinary_spaces

NO_RAMPS = "no ramps"
SCATTER = dict.fromkeys(PARTS, ModelErrors(27.0, 0.0, 0.0, 0.0, 100))


def law(name, error_n, parameters=None):
    errors = dict.fromkeys(PARTS, ModelErrors(error_n, 1e-4, 1e4, 1e4, 100))
    fit = Fit(name, parameters or {}, 4.0, True, "")
    return IdentifiedLaw(name, fit, section={"law": name}, runs=("1",), errors=errors)


def identified(*laws):
    about = Provenance("made", "simulated", "bench", "sim", "2026-01-01T00:00:00", "")
    return Identification(about, laws, (), NO_RAMPS, ("2",), SCATTER, "", (), (), ())


def verdict(found):
    page = ordinary_spaces(identification_page(found, ()))
    text = re.sub(r"</?sub>", "", re.search(r'class="verdict">(.*?)</p>', page)[1])
    return re.sub(r"</?span[^>]*>", "", text)  # all but the first sentence is less emphasised


@pytest.mark.parametrize(
    ("other_n", "others"),
    [
        (10.4, " Leuven (10.4 N) is as good."),
        (10.6, ""),
    ],
)
def test_laws_within_5_percent_of_the_smallest_error_are_equally_good(other_n, others):
    found = identified(law("tustin", 150.0), law("lugre", 10.0), law("leuven", other_n))
    error = "LuGre: it predicts friction in motion with an RMS error of 10.0 N"
    simulated = f"On this simulated cylinder, use {error}. The trials scatter by 27.0 N.{others}"
    assert verdict(found) == f"{simulated} A real cylinder may need another law."
    measured = replace(found, provenance=replace(found.provenance, source="measured"), scatter={})
    assert verdict(measured) == f"Use {error}.{others}"


def test_errors_at_rest_do_not_decide_which_law_is_the_best_and_are_stated_beside_it():
    """Speed determines no friction at rest: 3 N there and 60 N in motion are worse than 20 N."""
    holding = law("leuven", 60.0)
    holding.errors["rest"] = replace(holding.errors["rest"], friction_n=3.0)
    moving = law("tustin", 20.0)
    moving.errors["rest"] = replace(moving.errors["rest"], friction_n=450.0)
    found = identified(holding, moving)
    words = "use Tustin: it predicts friction in motion with an RMS error of 20.0 N"
    assert words in verdict(found)
    (table,) = (each for each in identification_tables(found) if each.title == SUMMARY)
    assert table.head[1:4] == ("RMS error in motion (N)", "At constant speed (N)", "At rest (N)")
    assert [(row[0], row[1], row[3]) for row in table.rows] == [
        ("tustin", "20.0", "450.0"), ("leuven", "60.0", "3.0")
    ]  # fmt: skip
    scatter = "27.0 N in motion, 27.0 N at constant speed, 27.0 N at rest"
    assert scatter in ordinary_spaces(identification_page(found, ()))


def test_of_equally_good_laws_the_one_is_advised_that_the_runs_determine_with_its_reserve():
    bound = FitParameter(0.0, None, None, "lower", "N s/m")
    unknown = FitParameter(37.0, None, None, None, "N")
    lugre = law("lugre", 10.0, {"sigma1_n_s_m": bound})
    leuven = law("leuven", 9.9, {"theta_1_n": unknown, "theta_2_n": unknown})
    found = identified(leuven, lugre)
    assert (
        "These runs do not determine its bristle damping σ1 (at its lower bound): do not rely on "
        "motions that depend on it."
    ) in verdict(found)
    more = "Leuven (9.9 N) is as good, but has 2 undetermined parameters."
    assert more in verdict(found)
    page = identification_page(found, ())
    folded = page.index("Parameters of the other laws (1)")
    assert page.index("LuGre: identified parameters") < folded
    assert folded < page.index("Leuven: identified parameters")
    trace = Trace(np.array([0.0, 0.01]), np.array([0.05, -0.1234]), np.zeros(2))
    runs = [Followed(str(load), load, None, trace, {}) for load in (-5000.0, 500.0)]
    words = verdict(replace(found, followed=tuple(runs)))
    range_words = "The law is verified for speeds up to 123 mm/s and loads of +500 and −5000 N."
    assert range_words in words
    determined = replace(identified(law("lugre", 10.0)), followed=tuple(runs))
    assert range_words in verdict(determined), "the range does not depend on what is undetermined"


def test_the_error_of_the_best_law_is_beside_the_measured_friction_and_the_instruments(small):
    """The friction of both directions counts: 300 N and −400 N are 354 N RMS."""
    trace = Trace(np.array([0.0, 0.01, 0.02]), np.ones(3), np.array([300.0, -400.0, np.nan]))
    followed = (Followed("0001", 500.0, None, trace, {}),)
    found = replace(identified(law("lugre", 10.0)), followed=followed)
    friction = "an RMS error of 10.0 N at a measured friction of 354 N (RMS, both directions)"
    assert friction in verdict(found)
    late = replace(followed[0], compared_from_s=0.01)
    assert "measured friction of 400 N" in verdict(replace(found, followed=(late,)))
    assert "instruments" not in verdict(found)
    point = replace(small.curves[0].points[0], sigma_instruments_n=50.0)
    along = LawsAlongCurve(replace(small.curves[0], points=(point,)), np.array([0.01]), {})
    common = "Errors of the instruments, common to all runs, may shift friction by up to ±98 N (95"
    assert common in verdict(replace(found, steady=(along,)))


def test_the_errors_of_dynamic_and_static_laws_are_explained_beside_the_table():
    found = identified(law("lugre", 10.0), law("tustin", 110.0), law("marton_lantos", 116.0))
    page = ordinary_spaces(identification_page(found, ()))
    assert "Dynamic laws (LuGre)" in page and "static laws (Tustin, Marton and Lantos)" in page
    assert "RMS errors while the speed changes: 10.0 N against 110.0–116.0 N." in page
    assert "At constant speed</dt>" not in page  # no simulation oscillates
    static = identified(law("tustin", 110.0), law("marton_lantos", 116.0))
    assert "Kinds of laws" not in identification_page(static, ())


def test_errors_at_speeds_where_a_simulation_oscillates_are_apart_from_the_others():
    """23 N at constant speeds are 2 N where the simulation is smooth and 40 N elsewhere."""
    smooth, rough = (ModelErrors(n, 1e-4, 1e4, 1e4, 100) for n in (2.0, 40.0))
    parts = SteadyParts(smooth, rough, 30, (0.03, 0.06, 0.03))
    static = replace(law("pressure_based", 23.0), steady=parts)
    assert "oscillates, in 3 of 30 parts" in ordinary_spaces(
        identification_page(identified(static), ())
    )
    found = identified(law("lugre", 3.0), static)
    page = ordinary_spaces(identification_page(found, ()))
    assert "oscillates, in 3 of 30 parts, at 30–60 mm/s: Pressure-based." in page
    assert "In brackets: without the parts" in " ".join(identification_text(found).split())
    (summary,) = (table for table in identification_tables(found) if table.title == SUMMARY)
    assert [row[2] for row in summary.rows[:2]] == ["3.0", "23.0 (2.0)"]
    (errors,) = (table for table in identification_tables(found) if table.title == ERRORS)
    rows = {row[1]: row[2] for row in errors.rows if row[0] == "pressure_based"}
    assert rows["steady, smooth"] == "2.0" and rows["steady, oscillating"] == "40.0"


def test_the_terminal_has_the_parameters_of_the_law_to_use_and_the_errors_of_all():
    best, other = (
        law(name, error, {key: FitParameter(86.0, 6.0, (73.0, 99.0), None, "N")})
        for name, error, key in (("lugre", 3.0, "f_coulomb_n"), ("tustin", 50.0, "f_stiction_n"))
    )
    text = identification_text(identified(other, best))
    assert "Coulomb force F_C" in text and "Static friction F_s" not in text
    assert [line.split()[:2] for line in text.splitlines() if line.startswith("Tustin")] == [
        ["Tustin", "50.0"]
    ]
    unverified = replace(identified(other, best), not_verified="no runs verify the laws")
    laws = tuple(replace(each, errors={}) for each in (other, best))
    text = identification_text(replace(unverified, laws=laws))
    assert "Coulomb force F_C" in text and "Static friction F_s" in text


def test_laws_are_listed_by_their_error_with_what_is_not_determined():
    wide = FitParameter(2188.0, 1009.0, (-30.0, 4406.0), None, "N s/m", wide=True)
    lines = law("marton_lantos", 160.0, {"extend_high_slope_n_s_m": wide})
    elements = {
        "theta_1_n": FitParameter(0.0, None, None, "lower", "N"),
        "theta_2_n": FitParameter(37.0, None, None, None, "N"),
        "f_coulomb_n": FitParameter(86.0, 6.0, (73.0, 99.0), None, "N"),
    }
    found = identified(lines, law("leuven", 10.0, elements), IdentifiedLaw("lugre", None, "no"))
    tables = {table.title: table for table in identification_tables(found)}
    assert [row[0] for row in tables[SUMMARY].rows] == ["leuven", "marton_lantos", "lugre"]
    not_determined = [row[4] for row in tables[SUMMARY].rows[:2]]
    assert not_determined == ["θ_1, θ_2", "b_2 extending"]
    remarks = {row[1]: row[-1] for row in tables["Identified parameters"].rows}
    assert remarks["Slope above v_SW b_2, extending"] == "not determined"
    assert remarks["Force of element 1 θ_1"] == "at lower bound"
    assert remarks["Force of element 2 θ_2"] == "not determined"
    assert remarks["Coulomb force F_C"] == ""
    assert "(-30 to 4406, not determined)" in overlay_yaml(found, lines, lines.fit)


def test_a_parameter_whose_interval_contains_0_or_exceeds_half_of_it_is_hardly_determined():
    intervals = {
        "f_coulomb_n": (-5.0, 25.0),
        "f_stiction_n": (40.0, 130.0),
        "b_viscous_n_s_m": (90.0, 110.0),
    }
    parameters = {
        name: FitParameter((low + high) / 2, 1.0, (low, high), None, "N")
        for name, (low, high) in intervals.items()
    }
    tustin = law("tustin", 10.0, parameters)
    found = identified(tustin)
    (summary,) = (table for table in identification_tables(found) if table.title == SUMMARY)
    assert summary.rows[0][summary.head.index("Hardly determined")] == "F_C, F_s"
    assert summary.rows[0][summary.head.index("Not determined")] == "none"
    words = "The runs hardly determine its Coulomb force FC and static friction Fs."
    assert words in verdict(found)
    assert "(40 to 130, hardly determined)" in overlay_yaml(found, tustin, tustin.fit)
    assert verdict_words(tustin.fit) == "F_C, F_s hardly determined"


def test_the_remarks_on_a_law_of_each_direction_are_read_for_themselves():
    message = "extend: a_1 has no interval; few points; retract: the fit is at a bound"
    lines = law("marton_lantos", 160.0)
    page = identification_page(
        identified(replace(lines, fit=replace(lines.fit, message=message))), ()
    )
    assert (
        ">Marton and Lantos, extending</dt><dd>A<sub>1</sub> has no interval. Few points.<" in page
    )
    assert ">Marton and Lantos, retracting</dt><dd>The fit is at a bound.<" in page


def test_the_verdict_names_the_loads_that_verified_a_law_and_those_that_did_not(small):
    """Two steady curves, one of them at a load of no verification run: not in the friction."""
    curve = small.curves[0]
    high = replace(curve.points[0], friction_n=999.0)
    curves = (replace(curve, f_load_n=500.0), replace(curve, f_load_n=-23000.0, points=(high,)))
    along = tuple(LawsAlongCurve(each, np.array([0.01, 0.2]), {}) for each in curves)
    trace = Trace(np.array([0.0, 0.01]), np.array([0.0, 0.4]), np.zeros(2))
    runs = tuple(Followed(str(load), load, None, trace, {}) for load in (500.0, 5000.0))
    words = verdict(replace(identified(law("lugre", 10.0)), steady=along, followed=runs))
    assert "loads of +500 and +5000 N, not for loads of −23000 N." in words
    assert "999" not in words


def test_runs_of_kinds_that_determine_no_law_are_counted_with_their_reason():
    held = tuple(f"{run} (hold): runs of this kind determine no friction law" for run in (8, 9))
    found = replace(identified(law("lugre", 10.0)), left_out=held)
    page = ordinary_spaces(identification_page(found, ()))
    assert "laws from 1 run, verified on 1 other; 2 not used" in page
    assert "Runs 8, 9 (hold): runs of this kind determine no friction law." in page
    assert "Runs not used: 2\n- runs 8, 9 (hold)" in identification_text(found)


def test_the_intervals_are_said_to_leave_out_the_errors_of_the_instruments(small):
    """95 % of a standard deviation of 50 N are 98 N, on the page and on a terminal."""
    point = replace(small.curves[0].points[0], sigma_instruments_n=50.0)
    curve = replace(small.curves[0], points=(point,))
    along = LawsAlongCurve(curve, np.array([0.01, 0.2]), {})
    parameters = {"f_coulomb_n": FitParameter(86.0, 6.0, (73.0, 99.0), None, "N")}
    found = replace(identified(law("lugre", 10.0, parameters)), steady=(along,))
    page = ordinary_spaces(identification_page(found, ()))
    assert "shifts the parameters of all laws by up to ±98 N of friction (95 %)." in page
    text = " ".join(identification_text(found).split())
    assert "by up to +-98 N of friction (95 %)" in text


def test_errors_with_a_second_value_in_brackets_are_a_column_of_numbers():
    smooth, rough = (ModelErrors(n, 1e-4, 1e4, 1e4, 100) for n in (2.0, 40.0))
    static = replace(law("tustin", 23.0), steady=SteadyParts(smooth, rough, 2, (0.03,)))
    page = identification_page(identified(law("lugre", 3.0), static), ())
    assert re.search(r'<td class="n[^"]*"[^>]*>23\.0 \(2\.0\)<', page)


def test_a_misfit_of_all_laws_is_stated_on_the_page_in_the_terminal_and_in_json():
    poor = LackOfFit(200.0, 42.0, 1.5, 41.0, significant=True, compared=16)
    found = identified(*(replace(law(name, 40.0), misfit=poor) for name in ("tustin", "lugre")))
    said = (
        "No law describes the friction at steady speeds: the closest, Tustin, misses it by 41 N, "
        "20 % of it (RMS), beside a scatter of 1.5 N."
    )
    assert verdict(found).startswith(said)
    assert "use " not in verdict(found).partition("points.")[2]
    assert said in " ".join(identification_text(found).split())
    table = identification_page(found, ()).partition("Misfit of the laws</h2>")[2]
    assert "Misfit (%)" in table and "All forces are root mean squares." in ordinary_spaces(table)
    misfit = json.loads(identification_json(found))["laws"][0]["misfit"]
    assert (misfit["misfit_n"], misfit["share"], misfit["describes"]) == (41.0, 0.205, False)
    fits = replace(law("lugre", 40.0), misfit=replace(poor, misfit_n=4.0))
    assert "No law" not in verdict(identified(found.laws[0], fits))


def test_a_misfit_that_the_scatter_explains_is_none():
    noisy = LackOfFit(200.0, 42.0, 40.0, 13.0, significant=False, compared=16)
    assert "No law" not in verdict(identified(replace(law("tustin", 40.0), misfit=noisy)))


def test_errors_common_to_all_points_are_stated_without_a_verification():
    shifted = LackOfFit(192.0, 55.0, 0.9, 6.8, significant=True, compared=16)
    found = identified(replace(law("tustin", 40.0), misfit=shifted, errors={}))
    found = replace(found, not_verified="no bench file")
    assert verdict(found) == (
        "At steady speeds, Tustin has an RMS error of 55 N at a measured friction of 192 N; an "
        "error of the instruments, such as an offset of the force, would explain all but 6.8 N. "
        "No bench file."
    )
    exactly = replace(found, laws=(replace(found.laws[0], misfit=replace(shifted, misfit_n=0.0)),))
    assert "such as an offset of the force, would explain all of it. No bench" in verdict(exactly)
