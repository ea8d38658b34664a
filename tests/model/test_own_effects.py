"""A user's own effects, in a file that the environment names."""

import os
import re
import shutil
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import pytest

import hbench
from hbench.config.bench import parse_plant
from hbench.config.files.loading import read_yaml
from hbench.errors import ConfigError
from hbench.model.build import plant_parameters
from hbench.model.effects import rows
from hbench.model.effects.catalogue import EFFECTS, Coefficient, Effect
from hbench.model.effects.couplings import OilProperties
from hbench.model.effects.rows import check_neutral
from tests.support import ROOT

HOSE = Path(__file__).parent / "soft_hose.py"
DEMO = ROOT / "configs" / "demo.yaml"

# The slope of Tr's pressure in a plant with the hose, over that in one without.
RATIO = """
import numpy as np
from hbench.config.bench import parse_plant
from hbench.config.files.loading import read_yaml
from hbench.model.compiled import compiled
from hbench.model.effects.applied import oil
from hbench.model.build import plant_parameters
from hbench.model.plant import initial_state, n_states
from pathlib import Path

data = read_yaml(Path(r"{bench}"))
over = {{"effects": {{"soft_hose": {{"soft": "1e-3 1/bar"}}}}}}
par = plant_parameters(parse_plant(data, over, "plant"))
state = initial_state(par, 0.2, 15e5, 20e5)


@compiled
def oil_of(state, par, rates):
    return oil(state, par, par.effects, rates)


fluid = oil_of(state, par, np.zeros(n_states(par)))
print(fluid.beta_tr / par.bulk_modulus_pa, fluid.beta_tp / par.bulk_modulus_pa)
"""


def python(*arguments, effects=None):
    environment = {key: text for key, text in os.environ.items() if key != "HBENCH_EFFECTS"}
    path = os.pathsep.join([str(Path(hbench.__file__).parents[1]), *sys.path])
    environment |= {"PYTHONPATH": path} | ({"HBENCH_EFFECTS": str(effects)} if effects else {})
    return subprocess.run(
        [sys.executable, *map(str, arguments)], capture_output=True, text=True, env=environment
    )


def test_an_own_effect_changes_the_plant_and_an_edit_of_its_file_is_compiled(tmp_path):
    own, script = tmp_path / "my_effects.py", tmp_path / "ratio.py"
    shutil.copy(HOSE, own)
    script.write_text(RATIO.format(bench=ROOT / "configs" / "bench-aau.yaml"))
    for law, share in (("+ c[0]", 1e-3), ("+ 2.0 * c[0]", 2e-3)):
        own.write_text(HOSE.read_text().replace("+ c[0]", law))
        made = python(script, effects=own)
        assert made.returncode == 0, made.stderr
        soft, stiff = map(float, made.stdout.split())
        assert soft == pytest.approx(1 / (1 + 700 * share), rel=1e-12)
        assert stiff == 1.0


@pytest.fixture
def command(tmp_path):
    """A campaign on a plant with the hose, which is refused before anything moves."""
    plant = tmp_path / "plant.yaml"
    plant.write_text("effects:\n  soft_hose: {soft: 1e-3 1/bar}\n")
    return "-m", "hbench", "run", DEMO, "-o", tmp_path / "campaign", "--plant", plant


def test_without_its_file_a_plant_with_an_own_effect_is_refused(command):
    ended = python(*command)
    assert ended.returncode == 2 and "effects.soft_hose: " in ended.stderr


BAD = {
    "not Python": ("", "def", "SyntaxError"),
    "an import that fails": ("", "import no_such_module", "ModuleNotFoundError"),
    "no table": (HOSE.read_text(), "del EFFECTS", " EFFECTS"),
    "a name that exists": (
        HOSE.read_text().replace("soft_hose", "valve_lag"),
        "",
        "valve_lag: the",
    ),
    "no row": ("", 'EFFECTS = {"a": 1}', "a: .*int"),
    "no coefficient": (
        re.sub(r"Coeff.*0\.1\)", "1", HOSE.read_text()),
        "",
        "soft_hose: its coefficients",
    ),
    "no unit": (
        HOSE.read_text().replace("1/bar", "hose"),
        "",
        "soft_hose: soft: .*'hose'",
    ),
    "no size": (HOSE.read_text().replace("1e-4", "1.0"), "", "soft_hose: soft: typical = 1 "),
    "no balance": (HOSE.read_text().replace("flow_tr", "flow"), "", "soft_hose: its balances"),
    "no text": (
        HOSE.read_text().replace('{"oil": cavity}', '{"oil": cavity}, repair=1'),
        "",
        "soft_hose: repair = 1; must be a string",
    ),
    "no look-alike": (
        HOSE.read_text().replace('{"oil": cavity}', '{"oil": cavity}, confused_with={"a": "b"}'),
        "",
        "soft_hose: its confused_with",
    ),
    "no place": (HOSE.read_text().replace('"oil"', '"hose"'), "", "soft_hose: hose: "),
    "a decorated law": (
        HOSE.read_text().replace("def cavity", "import numba\n\n\n@numba.njit\ndef cavity"),
        "",
        "soft_hose: oil: ",
    ),
    "too few arguments": (
        HOSE.read_text().replace("rates, par)", "rates)"),
        "",
        r"soft_hose: oil: .*\(terms, c, state, at, rates, par\)",
    ),
    "another place's law": (
        HOSE.read_text().replace('"oil":', '"sensors":'),
        "",
        r"soft_hose: sensors: .*\(parameters, c\)",
    ),
    "an unknown name": (
        HOSE.read_text().replace("c[0]", "stiffness"),
        "",
        "soft_hose: oil: NameError: name 'stiffness'",
    ),
    "parameters that it can't change": (
        HOSE.read_text().replace('"oil": cavity', '"sensors": lambda one, c: one.hose'),
        "",
        "soft_hose: AttributeError: 'SensorParameters'",
    ),
    "the plant itself": ("from hbench.model.plant import step", "", "ImportError"),
}


ENDING = ("not Python", "an unknown name", "parameters that it can't change", "the plant itself")


@pytest.mark.parametrize("fault", [fault for fault in BAD if fault not in ENDING])
def test_a_file_that_cannot_be_used_is_a_configuration_error(tmp_path, monkeypatch, fault):
    text, more, says = BAD[fault]
    own = tmp_path / "my_effects.py"
    own.write_text(f"{text}\n{more}\n")
    monkeypatch.setattr(rows, "OWN_EFFECTS", str(own))
    monkeypatch.setitem(sys.modules, "hbench_own_effects", None)  # put back at the end
    with pytest.raises(ConfigError) as error:
        rows.own_effects(EFFECTS)
    assert str(own) in error.value.message and re.search(says, error.value.message)
    assert error.value.hint


@pytest.mark.parametrize("fault", ENDING)
def test_a_file_that_cannot_be_used_ends_with_exit_code_2_and_its_name(tmp_path, command, fault):
    text, more, says = BAD[fault]
    own = tmp_path / "my_effects.py"
    own.write_text(f"{text}\n{more}\n")
    ended = python(*command, effects=own)
    assert ended.returncode == 2, ended.stderr
    assert str(own) in ended.stderr and re.search(says, ended.stderr) and "hint: " in ended.stderr
    assert "Traceback" not in ended.stderr and not (tmp_path / "campaign").exists()


def other(oil, soft):
    return OilProperties(oil.tank_pa, oil.beta_tp, soft, oil.beta_lp, oil.beta_lr)


LAWS = {
    lambda oil, c, state, at, rates, par: other(oil, oil.beta): "AttributeError",
    lambda oil, c, state, at, rates, par: other(oil, c[3]): "index",
    lambda oil, c, state, at, rates, par: oil.beta_tr: "OilProperties",
    lambda oil, c, state, at, rates, par: other(oil, 0.9 * oil.beta_tr): "changes beta_tr ",
    lambda oil, c, state, at, rates, par: other(oil, oil.beta_tr + c[0]): "",
}


@pytest.mark.parametrize("law", LAWS, ids=LAWS.values())
def test_a_law_that_fails_or_is_not_neutral_is_refused(law):
    given = {"effects": {"valve_lag": {"time": "3 ms"}}}
    bench = read_yaml(ROOT / "configs" / "bench-aau.yaml")
    par = plant_parameters(parse_plant(bench, given, "plant"))
    own = Effect("own", {"soft": Coefficient("1", 1, 0, 2)}, ("flow_tr",), {"oil": law})
    with pytest.raises(ConfigError) if LAWS[law] else nullcontext() as error:
        check_neutral({"own": own}, par)
    if LAWS[law]:
        assert "own: oil: " in error.value.message and LAWS[law] in error.value.message
        assert len(error.value.message) < 200


def test_a_file_that_is_not_there_is_told_and_help_works_without_it(tmp_path, command):
    missing = tmp_path / "my_effects.py"
    ended = python(*command, effects=missing)
    assert ended.returncode == 2 and f"error: {missing}: " in ended.stderr
    assert python("-m", "hbench", "--help", effects=missing).returncode == 0


def test_the_example_in_the_catalogues_docstring_is_this_one():
    from hbench.model.effects import catalogue

    def code(text):
        return [re.sub(r"\s+", "", line) for line in text.splitlines() if line.strip()]

    shown = "".join(code(catalogue.__doc__))
    lines = code(HOSE.read_text().split('"""', 2)[2].replace('"""', "'''"))
    whole = "".join(lines).replace(",),}#fmt:skip", "),}")
    assert whole in shown
