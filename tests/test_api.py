"""``import hbench``: at once, and the same numbers as the command line's."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import hbench
from hbench import workflow
from hbench.config.bench import parse_bench
from hbench.config.files.loading import read_yaml
from hbench.errors import ConfigError, DataError
from hbench.model.build import plant_parameters

ROOT = Path(__file__).parents[1]
BENCH = ROOT / "configs" / "bench-aau.yaml"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A copy of a sample campaign, as ``demo``."""
    base = tmp_path_factory.mktemp("api")
    shutil.copytree(ROOT / "data_samples" / "stribeck-small", base / "demo")
    shutil.copytree(ROOT / "configs", base / "configs")
    return base / "demo"


@pytest.fixture(scope="module")
def demo(folder):
    return hbench.load(folder)


def test_import_loads_nothing_heavy():
    code = "import sys; import hbench; print(*sys.modules); hbench.load"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"numpy", "pandas", "scipy", "numba", "typer"} & set(done.stdout.split())


def test_the_names_are_those_that_are_told():
    assert set(hbench.__all__) <= set(dir(hbench))
    assert all(getattr(hbench, name).__doc__ for name in hbench.__all__)
    with pytest.raises(AttributeError, match="nothing"):
        hbench.nothing  # noqa: B018


def test_a_campaign_is_what_analyze_writes_and_load_writes_nothing(demo, folder):
    assert not (folder / "results").exists()
    workflow.analyze(folder)
    written = json.loads((folder / "results" / "results.json").read_text())
    shutil.rmtree(folder / "results")
    assert demo.results == written
    assert demo.runs.run.tolist() == [run["run"] for run in written["runs"]]
    assert len(demo.curves) == sum(len(curve["points"]) for curve in written["curves"])
    curve = written["curves"][1]
    wanted = f"direction == '{curve['direction']}' and f_load_n == {curve['f_load_n']}"
    (row,) = demo.fits.query(f"{wanted} and parameter == 'f_stiction_n'").to_dict("records")
    assert row["value"] == curve["fits"][0]["parameters"]["f_stiction_n"]["value"]
    assert set(demo.efficiency) >= {"direction", "v_m_s", "efficiency", "sigma"}
    series = written["headline"]["series"]
    assert demo.headline.friction_n.tolist() == [one["friction_n"]["value"] for one in series]
    assert demo.headline.breakaway_n_basis.tolist() == [
        one["breakaway_n"]["basis"] for one in series
    ]
    assert demo.drift == written["drift"] and demo.drift["trials"] == 72
    assert demo.quality.grade.tolist() == [one["grade"] for one in written["quality"]["checks"]]


def test_the_samples_of_a_run_give_its_mean_friction(demo, folder):
    run = demo.runs.iloc[0]
    log = demo.samples(run.run).query(f"{run.t_start_s} <= t_s <= {run.t_stop_s}")
    area = demo.results["curves"][0]["specimen"]
    f_test = log.p_tp_pa * area["area_piston_m2"] - log.p_tr_pa * area["area_rod_m2"]
    assert (f_test - log.f_applied_n).mean() == pytest.approx(run.friction_n, rel=1e-3)
    with pytest.raises(DataError, match="'9999'"):
        demo.samples("9999")


def test_a_run_that_is_not_there_is_told_with_those_that_are_and_the_hint_in_the_traceback(demo):
    with pytest.raises(DataError, match=r"'1'") as error:
        demo.samples("1")
    last = demo.runs.run.iloc[-1]
    (note,) = error.value.__notes__
    assert note == f"hint: {error.value.hint}"
    assert "'0001'" in note and f"'{last}'" in note


def test_how_to_fit_is_given_as_in_a_fit_file(folder, tmp_path):
    given = {"laws": ["tustin"], "bounds": {"f_coulomb_n": ["0 N", "1 N"]}}
    fits = hbench.load(folder, given).fits
    assert set(fits.law) == {"tustin"}
    assert fits.query("parameter == 'f_coulomb_n'").value.max() <= 1.0
    with pytest.raises(ConfigError, match="laws"):
        hbench.load(folder, {"laws": ["newton"]})


@pytest.mark.parametrize("way", [1, -1])
def test_a_fit_to_points_finds_the_law_that_they_come_from(way):
    v = way * np.linspace(0.01, 0.2, 12)
    friction = way * (250 + 250 * np.exp(-abs(v) / 0.07) + 1500 * abs(v))
    found = hbench.fit(v, friction)
    values = [parameter.value for parameter in found.parameters.values()]
    assert found.converged and values == pytest.approx([250, 500, 0.07, 1500], rel=1e-6)
    assert set(hbench.fit(v, friction, law="marton_lantos").parameters) != set(found.parameters)


@pytest.mark.parametrize(
    ("v", "friction", "law", "words"),
    [
        ([0.1, -0.1], [1, -1], "tustin", "sign"),
        ([0.1, 0.2], [1], "tustin", "length"),
        ([0.1, np.nan], [1, 1], "tustin", "finite"),
        ([0.1, 0.2], [1, 2], "newton", "newton"),
        ([5, 50, 200], [3, 1, 2], "tustin", "200 m/s"),
        ([0, 0, 0], [3, 1, 2], "tustin", "3 of 3 velocities are 0"),
        ([0, 0.1, 0.2], [3, 1, 2], "tustin", "1 of 3 velocities are 0"),
        ([], [], "tustin", "no points"),
    ],
)
def test_points_that_can_not_be_fitted_are_refused(v, friction, law, words):
    with pytest.raises(ConfigError, match=words):
        hbench.fit(v, friction, law)


def test_a_simulated_piston_takes_the_oil_that_its_valve_passes():
    found = hbench.simulate(np.tile([0.7, 0.3, -1.4], (5000, 1)), BENCH)
    assert len(found) == 5001 and found.t_s.iloc[-1] == pytest.approx(0.5)
    assert found.x_m.iloc[0] == pytest.approx(0.2) and found.v_m_s.iloc[-1] > 0.03
    par = plant_parameters(parse_bench(read_yaml(BENCH), "bench"))
    before, end = found.iloc[-101], found.iloc[-1]  # 10 ms
    volume = par.test.dead_volume_piston_m3 + par.test.area_piston_m2 * end.x_m
    rise = (end.p_tp_pa - before.p_tp_pa) / 0.01
    taken = par.test.area_piston_m2 * end.v_m_s + volume / par.bulk_modulus_pa * rise
    passed = par.valve.flow_gain * 0.7 * np.sqrt(par.supply.pressure_pa - end.p_tp_pa)
    assert taken == pytest.approx(passed, rel=0.01)
    with pytest.raises(ConfigError, match="three"):
        hbench.simulate([[1.0, 2.0]], BENCH)


def test_the_readmes_example_runs(folder):
    text = (ROOT / "README.md").read_text()
    (code,) = re.findall(r"<!-- python -->\n```python\n(.*?)```", text, re.S)
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=folder.parent
    )
    assert done.returncode == 0, done.stderr
    assert "extend" in done.stdout and "f_coulomb_n" in done.stdout
