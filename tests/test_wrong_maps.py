"""Maps that are wrong or incomplete where no file contradicts them: the verdict has to."""

import numpy as np
import pytest
import yaml

from hbench import workflow
from hbench.report.campaign.quality.finding import reason
from hbench.report.campaign.quality.verdict import next_step, quality_verdict
from hbench.report.conformity.text import acceptance_text
from hbench.store.campaign.stored_acceptance import stored_checks
from tests.support.strokes import AREA_P, there_and_back

FRICTION_N = 150 + 900 * np.array([0.02, 0.04])  # of the logs
LOADS_N = (200.0, 1500.0)
INSTRUMENTS = {
    "force": {"tolerance": "0.1 %", "of": "full_scale", "full_scale": "5 kN"},
    "pressure": {"tolerance": "0.1 %", "of": "full_scale", "full_scale": "100 bar"},
}


@pytest.fixture
def analysed(tmp_path, clock):
    """Return a function that imports strokes at two speeds and loads by a map, and analyses them.

    ``bore`` [mm], ``force_scale`` and ``offset_n`` of the load cell are those of the map; right are
    40 mm, 1 and 0. The load cell is off by ``trial_n`` times the number of the trial.
    """

    def analysed(
        bore=40.0,
        force_scale=1.0,
        loads_n=LOADS_N,
        cut="reversals",
        named=True,
        offset_n=0.0,
        instruments=None,
        position_scale=1.0,
        trial_n=0.0,
    ):
        (tmp_path / "logs").mkdir(exist_ok=True)
        for load in loads_n:
            for v in (20, 40):
                for trial in (1, 2, 3):
                    run = there_and_back(v / 1e3, load, seed=round(load + v + trial), cycles=1)
                    run["f_applied_n"] = run["f_applied_n"] + trial_n * trial
                    if cut == "none":
                        run = {name: values[run["t_s"] < 4.0] for name, values in run.items()}
                    rows = np.stack(list(run.values()), axis=1)
                    name = f"{v}_{load:g}_{trial}" if named else f"{v}_{trial}"
                    np.savetxt(tmp_path / f"logs/{name}.csv", rows, "%.8g", ",",
                               header=",".join(run), comments="")  # fmt: skip
        channels = ("t_s", "x_m", "p_tp_pa", "p_tr_pa", "f_applied_n")
        rules = {
            "name": "strokes",
            "columns": {name: {"column": name} for name in channels},
            "cut": cut,
            "series": [
                {
                    "label": "A",
                    "files": "{speed}_{load}_{trial}.csv" if named else "{speed}_{trial}.csv",
                    "cylinder": {"piston_diameter": f"{bore} mm", "rod_diameter": "25 mm"},
                }
            ],
        }
        rules["columns"]["x_m"] |= {"scale": position_scale}
        rules["columns"]["f_applied_n"] |= {"scale": force_scale, "offset": f"{offset_n} N"}
        rules |= {"instruments": instruments} if instruments else {}
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
        workflow.import_runs(tmp_path / "logs", tmp_path / "out", tmp_path / "map.yaml", clock)
        return workflow.analyze(tmp_path / "out")

    return analysed


def check_of(results, name):
    found = [check for check in results.quality.checks if check.name == name]
    return found[0] if found else None


def test_a_right_map_gives_the_friction_and_a_balance_over_the_load(analysed):
    results = analysed()
    for curve in results.curves:
        found = [curve.against_motion * point.friction_n for point in curve.points]
        assert found == pytest.approx(FRICTION_N, rel=0.02)
    balance = check_of(results, "load_balance")
    assert balance.grade == "good" and balance.value < 0.5
    assert check_of(results, "load_direction") is None
    assert not any("of the load, as by" in note for note in results.notes)


@pytest.mark.parametrize(
    ("bore", "grade"), [(39.0, "with care"), (41.0, "with care"), (50, "poor")]
)
def test_a_wrong_bore_adds_its_part_of_the_load_to_the_mean_of_both_directions(
    analysed, bore, grade
):
    balance = check_of(results := analysed(bore), "load_balance")
    assert balance.grade == grade
    # F_T' - F_T = (A' - A) (P_p - P_r), with A dP_p / dF = 1
    assert balance.value == pytest.approx(100 * abs((bore / 40) ** 2 - 1), abs=0.5)
    assert "mean friction of both directions changes by" in quality_verdict(results.quality)
    assert "Check the diameters of the cylinder" in next_step(results.quality, "", imported=True)


def test_a_change_with_the_load_that_is_small_for_the_load_alone_is_noted(analysed):
    """2 % of 1500 N are 30 N of a friction of 180 N, and the interval of the trials is 1 N."""
    results = analysed(force_scale=0.98)
    assert check_of(results, "load_balance").grade == "good"
    (note,) = [note for note in results.notes if "changes by" in note]
    assert "changes by 2 +- 0" in note and "error of this size in an area" in note


def test_a_load_cell_in_another_unit_is_out_of_balance(analysed):
    balance = check_of(analysed(force_scale=1 / 9.81), "load_balance")  # N taken as kgf
    assert balance.grade == "poor"


def test_a_bore_of_twice_the_size_is_named_where_one_direction_was_measured(analysed):
    """Friction opposes the motion at all points, and grows by three times the load."""
    results = analysed(bore=80.0, cut="none")
    check = check_of(results, "load_share")
    assert check.grade == results.quality.grade == "poor"
    assert "Friction over load" in quality_verdict(results.quality)
    assert not results.quality.implausible and 270 < check.value < 330


def test_friction_of_one_direction_by_a_right_map_has_no_such_check(analysed):
    assert check_of(analysed(cut="none"), "load_share") is None


@pytest.mark.parametrize("named", [True, False])
def test_a_load_that_opposes_the_only_direction_has_no_check_of_its_sign(analysed, named):
    results = analysed(loads_n=(1500.0,), cut="none", named=named)
    assert check_of(results, "load_direction") is None


def test_the_share_of_a_load_of_the_wrong_sign_is_stated(analysed):
    results = analysed(force_scale=-1.0, loads_n=(1500.0,), cut="none", named=False)
    (curve,) = results.curves
    stated = [point.friction_n for point in curve.points]
    assert stated == pytest.approx(FRICTION_N + 2 * 1500, rel=0.01)
    check = check_of(results, "load_direction")
    assert check.grade == "with care"
    assert check.value == pytest.approx(np.median(100 * 1500 / (FRICTION_N + 3000)), abs=0.5)
    verdict = quality_verdict(results.quality)
    assert "at all 2 points the load helps the motion and supplies friction" in verdict
    assert "correct the sign of the load cell" in next_step(results.quality, "", imported=True)


def test_a_load_that_opposes_one_direction_has_no_such_check(analysed):
    """The other direction shows a wrong sign as friction that drives."""
    results = analysed(force_scale=-1.0, loads_n=(1500.0,))
    assert check_of(results, "load_direction") is None
    assert check_of(results, "plausible_signs").grade == "poor"


def test_a_position_from_the_other_end_is_named_where_all_friction_drives(analysed):
    results = analysed(position_scale=-1.0)
    check = check_of(results, "plausible_signs")
    assert check.grade == "poor" and check.count == check.of
    assert "a sign, the instruments" in quality_verdict(results.quality)
    assert "If the position falls while the cylinder extends" in next_step(results.quality, "")


def test_a_weight_that_no_load_cell_measures_makes_the_directions_differ(analysed):
    results = analysed(loads_n=(0.0,), offset_n=-100.0)  # 100 N act besides
    extend, retract = results.curves
    assert extend.points[0].friction_n == pytest.approx(268, abs=5)
    assert retract.points[0].friction_n == pytest.approx(-68, abs=5)
    check = check_of(results, "equal_directions")
    assert (check.grade, check.count, check.of) == ("with care", 2, 2)
    assert check.value == pytest.approx(100 * 100 / 168, abs=2)
    assert "one direction has more than twice the friction" in quality_verdict(results.quality)
    assert "Look for a force that is not measured" in next_step(results.quality, "", imported=True)


def test_directions_that_differ_by_less_are_no_reason_for_care(analysed):
    """Of 168 N in both directions, 40 N make 208 and 128 N."""
    assert check_of(analysed(loads_n=(0.0,), offset_n=-40.0), "equal_directions") is None


def test_a_force_that_is_the_same_at_all_speeds_and_loads_is_named(analysed):
    """The weight of an upright piston and rod, 40 N, adds to the friction of one direction."""
    results = analysed(offset_n=-40.0)
    (note,) = [n for n in results.notes if n.startswith("directions")]
    assert "the mean friction of both directions is 40" in note
    assert "at all speeds and loads, as by a constant force that is not measured" in note
    assert "half the difference of both, 177 N, is free of it" in note
    assert "Seals with more friction in one direction" in note  # which is no fault of the map
    check = check_of(results, "constant_force")
    assert (check.grade, check.value) == ("with care", pytest.approx(100 * 40 / 177, abs=0.5))
    assert "of friction, as by a constant force that is not measured" in quality_verdict(
        results.quality
    )
    assert "the weight of an upright piston" in next_step(results.quality, "", imported=True)


def test_friction_without_such_a_force_has_no_such_note(analysed):
    results = analysed()
    assert not [n for n in results.notes if n.startswith("directions")]
    assert check_of(results, "constant_force") is None


def test_a_campaign_of_one_direction_states_what_no_check_shows(analysed):
    results = analysed(loads_n=(1500.0,), cut="none")
    (note,) = [n for n in results.notes if n.startswith("directions")]
    assert note.startswith("directions: only extending runs. A wrong diameter")


def test_a_force_within_the_tolerance_of_the_instruments_is_not_named(analysed):
    results = analysed(offset_n=-10.0, instruments=INSTRUMENTS)
    assert not [n for n in results.notes if n.startswith("directions")]


@pytest.mark.parametrize(
    ("trial_n", "cut", "noted"),
    [(4, "reversals", True), (0, "reversals", False), (4, "none", False)],
)
def test_a_zero_that_drifts_over_the_campaign_is_noted(analysed, trial_n, cut, noted):
    """It raises friction in one direction as much as it lowers it in the other.

    Files have no dates here, and trials follow each other by name: the size is not known.
    """
    results = analysed(trial_n=trial_n, cut=cut)
    notes = [n for n in results.notes if n.startswith("drift:")]
    assert len(notes) == noted
    assert all("changes over the campaign in both directions alike" in n for n in notes)
    assert all("U does not contain the change" in n for n in notes)
    check = check_of(results, "force_drift")
    assert (check is not None) == noted
    assert not noted or (check.grade, check.value) == ("with care", None)
    assert not noted or reason(check).endswith("by how much is not known")


@pytest.mark.parametrize("known", [True, False])
def test_u_is_stated_to_be_without_the_instruments_where_their_tolerances_are_not_known(
    analysed, tmp_path, undrawn, known
):
    analysed(loads_n=(0.0,), instruments=INSTRUMENTS if known else None)
    workflow.report(tmp_path / "out", form="md")
    page = (tmp_path / "out/results/report.md").read_text()
    assert ("with expanded uncertainty U" in page) == known
    assert ("of trials and instruments together" in page) == known
    assert ("does not contain the errors of the instruments" in page) != known
    (tmp_path / "limits.yaml").write_text("limits: [{quantity: friction, max: 1 kN}]")
    acceptance = workflow.accept(tmp_path / "out", tmp_path / "limits.yaml")
    words = "U of friction: without the errors of the instruments"
    assert (words in acceptance_text(acceptance)) != known
    stored = stored_checks(tmp_path / "out")
    assert [check.measurement.without_instruments for check in stored] == [not known] * 2


def test_a_star_over_what_differs_makes_no_trials_of_two_conditions(tmp_path, clock):
    """Friction differs by 120 N between 2 x 3 trials; it would not between their three means."""
    (tmp_path / "logs").mkdir()
    for temperature, more_n in ((20, 60.0), (60, -60.0)):
        for trial in (1, 2, 3):
            run = there_and_back(0.02, 1500.0, seed=temperature + trial, cycles=1)
            run["p_tp_pa"] += more_n * np.sign(np.gradient(run["x_m"])) / AREA_P
            run = {name: values[run["t_s"] < 4.0] for name, values in run.items()}
            rows = np.stack(list(run.values()), axis=1)
            np.savetxt(tmp_path / f"logs/20_{temperature}C_{trial}.csv", rows, "%.8g", ",",
                       header=",".join(run), comments="")  # fmt: skip
    size = {"piston_diameter": "40 mm", "rod_diameter": "25 mm"}
    series = {"label": "A", "files": "{speed}_*_{trial}.csv", "cylinder": size}
    channels = ("t_s", "x_m", "p_tp_pa", "p_tr_pa", "f_applied_n")
    rules = {"name": "stars", "columns": {name: {"column": name} for name in channels}}

    def imported(series, folder):
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules | {"series": [series]}))
        summary = workflow.import_runs(
            tmp_path / "logs", tmp_path / folder, tmp_path / "map.yaml", clock
        )
        notes = [note for note in summary.notes if "counted as a further trial" in note]
        return notes, workflow.analyze(tmp_path / folder)

    (note,), results = imported(series, "stars")
    assert note.startswith("3 files (20_60C_1.csv") and "{temperature}" in note
    (point,) = [point for curve in results.curves for point in curve.points]
    assert sorted(point.trials) == [1, 2, 3, 4, 5, 6] and point.ci95_n > 50
    assert results.quality.grade == "poor"
    series |= {"files": "{speed}_{temperature}C_{trial}.csv", "factors": {"temperature": "degC"}}
    notes, results = imported(series, "factors")
    assert not notes and [curve.points[0].trials for curve in results.curves] == 2 * [(1, 2, 3)]
