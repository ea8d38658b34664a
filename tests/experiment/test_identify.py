"""Friction laws from a campaign of the rig on another plant, verified, written, read and run."""

import copy
import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from hbench import workflow
from hbench.analysis.identification.verification import model_errors
from hbench.cli.main import app
from hbench.config.bench import merge, parse_plant
from hbench.config.files.loading import read_yaml
from hbench.config.friction import parse_friction
from hbench.errors import DataError
from hbench.experiment.closed_loop import record_plans
from hbench.report.campaign.fit_tables import law_words
from hbench.report.identification.terminal import identification_text
from hbench.report.identification.text import (
    identification_json,
    identification_tables,
    parameter_words,
)
from hbench.report.render.document import BANNERS
from hbench.report.render.terminal_table import table_lines
from hbench.report.render.terminal_text import plain
from hbench.units import from_si
from hbench.workflow.results import derive
from tests.support.analysis.other_plant import OTHER_PLANT, STEADY

CONFIGS = Path(__file__).parents[2] / "configs"
LAWS = ("tustin", "marton_lantos", "pressure_based", "lugre", "leuven")
TRUTH = {
    "sigma0_n_m": 2.6e5,
    "f_coulomb_n": 310.0,
    "f_stiction_n": 480.0,
    "v_stribeck_m_s": 0.055,
    "b_viscous_n_s_m": 2350.0,
    "k_piston_n_pa": 1e-5,
    "k_rod_n_pa": 0.5e-5,
}
TRAVEL = {"start": "150 mm", "end": "250 mm"}


def of_kind(kind, **changes):
    experiments = read_yaml(CONFIGS / "dynamics.yaml")["experiments"]
    return [e | changes for e in experiments if e["kind"] == kind]


def reversals():
    return [e for e in of_kind("triangle") if e["label"] == "reversals 150 mm/s"]


def small():
    """All kinds, few of each: 24 steady runs, 6 with reversals, 2 ramps, 2 verification runs."""
    steady = [e | {"trials": 1} for e in STEADY]
    ramps = [e | {"accelerations": ["0.1 m/s^2"]} for e in of_kind("ramp", trials=1)]
    for ramp, load in zip(ramps, ("1000 N", "-1000 N"), strict=True):
        ramp["loads"] = [load]
    return [*steady, *reversals(), *ramps, *of_kind("verification", loads=["500 N"], trials=2)]


def campaign(folder, on_the_rig, experiments, seed=3, **test_friction):
    """Make experiments on a plant whose test cylinder alone differs from the bench file."""
    bench = read_yaml(CONFIGS / "bench-aau.yaml")
    shipped = bench["friction"]["test"]
    bench = merge(bench, copy.deepcopy(OTHER_PLANT))
    bench["friction"]["test"] = shipped
    own = OTHER_PLANT["friction"]["test"] | test_friction
    schedule = {"name": "other plant", "bench": "bench.yaml", "experiments": experiments}
    for name, data in (
        ("bench", bench),
        ("plant", {"friction": {"test": own}}),
        ("schedule", schedule),
    ):
        (folder / f"{name}.yaml").write_text(yaml.safe_dump(data))
    return on_the_rig(
        folder / "schedule.yaml", folder / "campaign", plant=folder / "plant.yaml", seed=seed
    )


@pytest.fixture(scope="module")
def measured(tmp_path_factory, on_the_rig):
    return campaign(tmp_path_factory.mktemp("identify"), on_the_rig, small())


@pytest.fixture(scope="module")
def found(measured):
    return workflow.identify(measured.folder, lambda progress: None)


@pytest.fixture(scope="module")
def written(tmp_path_factory, found):
    folder = tmp_path_factory.mktemp("laws")
    workflow.write_identification(folder, found)
    return folder


def law(found, name):
    return next(one for one in found.laws if one.law == name)


def value(found, name, parameter):
    return law(found, name).fit.parameters[parameter].value


def test_all_five_laws_are_identified_and_the_plants_own_is_found(found):
    assert [one.law for one in found.laws] == list(LAWS)
    assert all(one.fit for one in found.laws)
    assert value(found, "lugre", "sigma0_n_m") == pytest.approx(TRUTH["sigma0_n_m"], rel=0.02)
    for name in ("f_stiction_n", "k_piston_n_pa"):
        assert value(found, "lugre", name) == pytest.approx(TRUTH[name], rel=0.15), name
    curve = [value(found, "lugre", n) for n in ("f_coulomb_n", "f_stiction_n", "v_stribeck_m_s")]
    v = np.array([0.02, 0.05, 0.1])

    def steady(c, s, v_s, b):
        return c + (s - c) * np.exp(-v / v_s) + b * v

    own = steady(*curve, value(found, "lugre", "b_viscous_n_s_m"))
    truth = steady(*(TRUTH[n] for n in list(TRUTH)[1:5]))
    np.testing.assert_allclose(own, truth, rtol=0.03)


def test_only_laws_with_a_memory_follow_the_verification_profile(found):
    for name in ("lugre", "leuven"):
        for static in ("tustin", "marton_lantos", "pressure_based"):
            ours, theirs = law(found, name).errors, law(found, static).errors
            assert 3 * ours["unsteady"].friction_n < theirs["unsteady"].friction_n
            assert 5 * ours["rest"].friction_n < theirs["rest"].friction_n
        assert law(found, name).errors["steady"].friction_n < 15.0
    assert 0 < found.scatter["steady"].friction_n < 20.0


def test_verification_runs_take_no_part_in_the_identification(found, measured):
    kinds = {plan.run: plan.kind for plan in measured.plans}
    assert {kinds[run] for run in found.verification_runs} == {"verification"}
    used = {name: {kinds[run] for run in law(found, name).runs} for name in LAWS}
    assert used["tustin"] == used["marton_lantos"] == used["pressure_based"] == {"steady"}
    assert used["lugre"] == used["leuven"] == {"triangle", "ramp"}


def test_the_steady_fit_is_worse_on_ramps_than_their_own(found):
    """Section 6.2: a fit is good for its own data and not for the other's."""
    assert len(found.ramps) == 2
    for ramp in found.ramps:
        assert ramp.steady_on_ramp_n > 2 * ramp.ramp_on_ramp_n
        assert ramp.ramp_on_steady_n > 2 * ramp.steady_on_steady_n


@pytest.mark.parametrize("name", LAWS)
def test_a_written_law_holds_every_key_of_its_section_so_that_nothing_below_shows(
    written, measured, name
):
    overlay = read_yaml(written / f"{name}.yaml")
    own = overlay["friction"]["test"]
    assert list(overlay) == ["friction"] and list(overlay["friction"]) == ["test"]
    assert set(own) == set(type(parse_friction(own, name)).model_fields)
    bench = measured.header["bench"]["content"]
    laid = parse_plant(bench, overlay, name)
    assert laid.friction.test == parse_friction(own, name)
    assert laid.friction.load == parse_plant(bench, {}, "bench").friction.load


def test_the_written_file_is_the_model_that_was_verified(written, found, measured):
    """The rig runs with the overlay as it is, and leaves the errors that the table tells."""
    bench = measured.bench()
    runs = [one.run for one in derive(measured).runs if one.run.plan.kind == "verification"]
    quiet = {
        "friction": {"load": {"scatter": "0 %"}},
        "sensors": {"adc": {"noisy": False, "quantised": False}},
    }
    plant = parse_plant(
        measured.header["bench"]["content"], merge(read_yaml(written / "lugre.yaml"), quiet), "x"
    )
    first = min(int(run.plan.run) for run in runs)
    plans = [plan for plan in measured.plans if int(plan.run) >= first - 1]  # and the run before
    modelled = record_plans(bench, plans, plant).runs[1:]
    again = model_errors(runs, modelled, bench.moving_mass.test)
    for part, errors in law(found, "lugre").errors.items():
        assert again[part].friction_n == pytest.approx(errors.friction_n, rel=1e-3), part


def test_hbench_run_takes_the_written_file_as_plant(written, tmp_path, quick_schedule, on_the_rig):
    made = on_the_rig(quick_schedule(), tmp_path / "c", plant=written / "leuven.yaml")
    assert {raw.outcome for raw in made.raw_runs()} == {"done"}


@pytest.mark.usefixtures("wide_terminal")
def test_json_and_table_tell_the_same(found):
    document, tables = json.loads(identification_json(found)), identification_tables(found)
    assert document["schema"] == "hbench.identification/1"
    rows = [plain(line).split() for table in tables for line in table_lines(table)]
    for one in document["laws"]:
        of_law = [["law", *row[1:]] for row in rows if row[:1] == [one["law"]]]
        own = {row[1]: row for row in of_law if len(row) == 7}
        for part, errors in one["errors"].items():
            assert float(own[part][2]) == pytest.approx(errors["friction_n"], abs=0.06)
            assert float(own[part][3]) == pytest.approx(1e3 * errors["v_m_s"], abs=0.006)
            assert int(own[part][6]) == errors["samples"]
        for name, p in one["parameters"].items():
            words, unit = parameter_words(name, p["unit"])
            start = ["law", *plain(words).split()]
            (row,) = (row for row in of_law if row[: len(start)] == start)
            shown, value = float(row[len(start)]), from_si(p["value"], unit)
            half = 0.0 if p["ci95"] is None else from_si(np.ptp(p["ci95"]) / 2, unit)
            assert shown == pytest.approx(value, rel=5e-3, abs=0.06 * half)
            assert " ".join(plain(unit).split()) in " ".join(row)
            assert set(p) >= {"value", "se", "ci95", "at_bound", "unit"}


def test_page_and_figures_say_that_the_data_is_simulated(written):
    page = (written / "identification.html").read_text()
    assert BANNERS["simulated"] in page and len(page) > 100_000
    assert 'class="verdict"' in page
    for number, name in ((1, "Error of friction (N)"), (2, "Error of velocity (mm/s)")):
        assert re.search(rf"\b{number} of 2: {re.escape(name)} [^.]*\. Tustin: ", page)
    drawn = {path.stem for path in (written / "figures").glob("*.svg")}
    curves = {name for name in drawn if name.startswith("steady-")}
    assert len(curves) == 4  # two loads in both directions, with the laws over the points
    assert len(drawn - curves) == 1 + len(LAWS) and page.count("<figure ") == len(drawn)


@pytest.fixture(scope="module")
def lacking(tmp_path_factory, on_the_rig):
    """Steady runs of one direction, and steps."""
    experiments = [STEADY[0] | {"trials": 1}, *of_kind("steps", loads=["500 N"])]
    return campaign(tmp_path_factory.mktemp("lacking"), on_the_rig, experiments)


def test_what_a_campaign_lacks_is_told_with_what_to_add(lacking, tmp_path, undrawn):
    found = workflow.identify(lacking.folder, lambda progress: None)
    text = identification_text(found)
    assert law(found, "tustin").fit and law(found, "pressure_based").fit
    reasons = {one.law: one.reason for one in found.laws if one.fit is None}
    assert set(reasons) == {"marton_lantos", "lugre", "leuven"}
    assert "retracting" in reasons["marton_lantos"] and "'triangle'" in reasons["lugre"]
    together = " ".join(text.split())
    assert all(f"{law_words(name)} is not" in together for name in reasons)
    assert all(plain(reason) in together for reason in reasons.values())
    assert "not verified" in text and "configs/dynamics.yaml" in text
    assert "(steps): " in text and "ramps" in text
    workflow.write_identification(tmp_path / "out", found)
    page = (tmp_path / "out" / "identification.html").read_text()
    assert "not verified" in page and "<figure>" not in page
    assert {path.name for path in (tmp_path / "out").glob("*.yaml")} == {
        "tustin.yaml",
        "pressure_based.yaml",
    }
    assert json.loads(identification_json(found))["verification"]["not_verified"]


def test_cut_logs_are_left_out_with_a_reason_and_nothing_left_is_an_error(tmp_path, on_the_rig):
    made = campaign(tmp_path, on_the_rig, reversals()[:1])
    logs = sorted((made.folder / "runs").glob("*.dat"))
    for log in logs:
        log.write_bytes(log.read_bytes()[:20_000])
    with pytest.raises(DataError, match=f"{made.folder}: .*lugre") as caught:
        workflow.identify(made.folder, lambda progress: None)
    assert "dynamics.yaml" in caught.value.hint


@pytest.mark.parametrize(
    ("kind", "message", "hint"),
    [
        ("steady", "mass", "'moving_mass' to the import map, or a bench file bench.yaml"),
        ("breakaway", "from runs of the kind breakaway; that needs steady, ramp", "dynamics.yaml"),
    ],
)
def test_an_imported_campaign_without_mass_or_runs_is_refused_with_a_hint(
    tmp_path, clock, kind, message, hint
):
    source = tmp_path / "logs"
    source.mkdir()
    columns = "run,file,kind,trial,v_ref_m_s,a_ref_m_s2,f_load_n,p_lr_ref_pa"
    (source / "runs.csv").write_text(f"{columns}\n1,1.csv,{kind},1,0.05,,1000,1500000\n")
    rows = "".join(f"{0.01 * i},{5e-4 * i},4e6,2e6,1e3\n" for i in range(200))
    (source / "1.csv").write_text(f"t_s,x_m,p_tp_pa,p_tr_pa,f_applied_n\n{rows}")
    workflow.import_runs(source, tmp_path / "c", None, clock)
    with pytest.raises(DataError, match=message) as caught:
        workflow.identify(tmp_path / "c", lambda progress: None)
    assert hint in caught.value.hint


def test_the_command_prints_one_object_or_the_table(tmp_path, lacking, undrawn):
    def identify(*options):
        arguments = ["identify", str(lacking.folder), "-o", str(tmp_path / "out"), *options]
        done = CliRunner().invoke(app, arguments)
        assert done.exit_code == 0, done.output
        assert "identification.html" in done.stderr
        return done.stdout

    written = tmp_path / "out" / "identification.json"
    assert json.loads(identify("--json")) == json.loads(written.read_text())
    text = identify()
    assert text.startswith("These laws are not verified") and "\nIdentified parameters\n" in text
    assert text.isascii()
    with pytest.raises(DataError, match=r"nowhere.campaign\.yaml"):
        workflow.identify(tmp_path / "nowhere", lambda progress: None)


@pytest.mark.slow
def test_the_shipped_schedule_identifies_all_and_errs_like_the_trials_scatter(tmp_path, on_the_rig):
    """configs/dynamics.yaml on the other plant (LuGre, 1.5 % scatter, noise); tables printed."""
    schedule = read_yaml(CONFIGS / "dynamics.yaml")["experiments"]
    made = campaign(tmp_path, on_the_rig, schedule)
    found = workflow.identify(made.folder, lambda progress: None)
    print("\n" + identification_text(found))
    for name in ("lugre", "leuven"):
        errors = law(found, name).errors
        assert errors["steady"].friction_n < 15 and errors["unsteady"].v_m_s < 0.4e-3
        assert errors["unsteady"].friction_n < 2 * found.scatter["unsteady"].friction_n
        for static in ("tustin", "marton_lantos", "pressure_based"):
            assert (
                3 * errors["unsteady"].friction_n < law(found, static).errors["unsteady"].friction_n
            )
            assert 5 * errors["unsteady"].v_m_s < law(found, static).errors["unsteady"].v_m_s
    assert len(found.ramps) == 12
    for ramp in found.ramps:
        assert ramp.steady_on_ramp_n > 2 * ramp.ramp_on_ramp_n
        assert ramp.ramp_on_steady_n > 2 * ramp.steady_on_steady_n
