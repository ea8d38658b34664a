"""The table of friction laws against all that lists laws, their formulas, parameters or keys."""

import ast
import inspect
import subprocess
import sys
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

import hbench
from hbench.analysis.fitting.fit import CURVE_LAWS, JOINT_LAWS
from hbench.analysis.identification.friction_section import friction_section
from hbench.analysis.identification.leuven import _SHAPES
from hbench.analysis.identification.lugre import UNKNOWNS
from hbench.config.friction import Friction, Lines, parse_friction
from hbench.model.build import friction_parameters
from hbench.model.friction import formulas
from hbench.model.friction.laws import LAWS, steady_friction
from hbench.model.parameters import FrictionParameters
from hbench.records import Fit, FitParameter
from hbench.records.friction_laws import DIRECTIONS, FRICTION_LAWS, PARAMETERS, parameter_named
from hbench.units import parse_unit

ROOT = Path(hbench.__file__).parent
OF_FILES = {
    get_args(kind.model_fields["law"].annotation)[0]: kind
    for kind in get_args(get_args(Friction)[0])
}
P_P, P_R = 50e5, 10e5
LAW = pytest.mark.parametrize("law", FRICTION_LAWS.values(), ids=lambda law: law.name)
VALUES = {
    "f_coulomb_n": 300.0,
    "f_stiction_n": 500.0,
    "v_stribeck_m_s": 0.06,
    "b_viscous_n_s_m": 1500.0,
    "low_force_n": 500.0,
    "low_slope_n_s_m": -3000.0,
    "high_force_n": 250.0,
    "high_slope_n_s_m": 2000.0,
    "v_switch_m_s": 0.05,
    "k1_n": 200.0,
    "k2_s_m": -16.0,
    "k3_n_pa": 1.2e-5,
    "k4_n_pa": 0.8e-5,
    "k5_n_s_m": 1500.0,
    "sigma0_n_m": 3e5,
    "sigma1_n_s_m": 100.0,
    "k_piston_n_pa": 1.2e-5,
    "k_rod_n_pa": 0.8e-5,
    "theta_1_n": 600.0,
    "delta_max_m": 1e-3,
    "n": 1.5,
}


def fit_of(law):
    """A fit that has every parameter of a law."""
    names = [parameter.name.replace("_i_", "_1_") for parameter in law.parameters]
    before = [f"{direction}_" for direction in DIRECTIONS] if law.by_direction else [""]
    parameters = {
        prefix + name: FitParameter(VALUES[name], None, None, None, parameter_named(name).unit)
        for prefix in before
        for name in names
    }
    return Fit(law.name, parameters, 0.0, True, "")


def test_the_files_and_the_plant_have_the_laws_of_the_table():
    assert set(OF_FILES) == set(LAWS) == set(FRICTION_LAWS)
    assert {*CURVE_LAWS, *JOINT_LAWS} == {
        n for n, x in FRICTION_LAWS.items() if x.data != "motions"
    }


@LAW
def test_the_keys_of_the_files_are_those_of_the_table(law):
    fields = set(OF_FILES[law.name].model_fields) - {"law"}
    if law.by_direction:
        assert set(DIRECTIONS) <= fields
        fields = (fields - set(DIRECTIONS)) | set(Lines.model_fields)
    assert fields == law.keys | set(law.neutral)


@LAW
def test_a_fit_of_every_parameter_makes_a_section_with_its_values(law):
    """Keys, units on pages and in files, and the plant's fields, through the file's reader."""
    section = friction_section(fit_of(law))
    par = friction_parameters(parse_friction(section, law.name))
    for name, fitted in fit_of(law).parameters.items():
        parameter = parameter_named(name)
        direction = name.partition("_")[0]
        prefix = f"{direction}_" if direction in DIRECTIONS else ""
        if parameter.key:
            found = getattr(par, prefix + parameter.key)
            assert found == pytest.approx((fitted.value,) if parameter.of_several else fitted.value)


@LAW
def test_the_fits_take_names_and_units_from_the_table(law):
    fitted = {**CURVE_LAWS, **JOINT_LAWS}.get(law.name)
    if fitted is not None:
        assert fitted.units.items() <= law.units.items()


def test_parameters_have_one_symbol_and_a_unit_of_their_name():
    for law in FRICTION_LAWS.values():
        assert [PARAMETERS[p.name] for p in law.parameters] == list(law.parameters)
    for name, parameter in PARAMETERS.items():
        unit, shown = parse_unit(parameter.unit or "1"), parse_unit(parameter.shown)
        assert unit.factor == 1.0 and unit.dimension == shown.dimension
        in_name = "_".join(parameter.unit.replace("/", " ").lower().split())
        assert name.endswith(in_name)
    for law in FRICTION_LAWS.values():
        symbols = [parameter.symbol for parameter in law.parameters]
        assert len(set(symbols)) == len(symbols)
    assert {*UNKNOWNS, *_SHAPES} <= set(PARAMETERS)


@LAW
def test_the_keys_of_the_table_are_numbers_of_the_plant(law):
    prefixes = [f"{direction}_" for direction in DIRECTIONS] if law.by_direction else [""]
    wanted = {prefix + key for prefix in prefixes for key in law.keys} | set(law.neutral)
    assert wanted <= set(FrictionParameters._fields)


@LAW
@pytest.mark.parametrize("v", [-0.2, -0.06, -0.004, 0.004, 0.06, 0.2])
def test_numpy_and_the_compiled_plant_agree_on_the_formula(law, v):
    par = friction_parameters(parse_friction(friction_section(fit_of(law)), law.name))
    speed = np.array([abs(v)])
    seal = formulas.seal_force(P_P, P_R, par.piston_seal, par.rod_seal)
    if law.name == "pressure_based":
        dry = formulas.pressure_curve(speed, seal, par.stribeck_force, par.stribeck_rate)
    elif law.name == "marton_lantos":
        dry = formulas.two_lines(
            speed,
            par.extend_low_force,
            par.extend_low_slope,
            par.extend_high_force,
            par.extend_high_slope,
        )
    else:
        dry = formulas.stribeck_curve(
            speed, seal, par.coulomb, par.stiction, par.stribeck_velocity, par.stribeck_exponent
        )
    expected = np.copysign(dry[0], v) + par.viscous * v
    assert steady_friction(v, P_P, P_R, par) == pytest.approx(expected, rel=1e-14)


def test_joined_lines_are_the_two_lines_with_the_switch_velocity_as_a_parameter():
    a_1, b_1, b_2, v_switch = 500.0, -3000.0, 2000.0, 0.05
    speeds = np.linspace(0.0, 0.2, 41)
    np.testing.assert_allclose(
        formulas.joined_lines(speeds, a_1, b_1, b_2, v_switch),
        formulas.two_lines(speeds, a_1, b_1, a_1 + (b_1 - b_2) * v_switch, b_2),
        rtol=1e-14,
    )


def test_formulas_do_not_call_each_other():
    """A compiled formula could not call one that is not."""
    own = {name for name, value in vars(formulas).items() if inspect.isfunction(value)}
    calls = {
        node.func.id
        for node in ast.walk(ast.parse(Path(formulas.__file__).read_text()))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }
    assert not own & calls


def test_fits_and_pages_load_without_numba():
    code = (
        "import sys, hbench.workflow.results, hbench.report.campaign.page, "
        "hbench.model.friction.formulas; sys.exit('numba' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_one_module_chooses_between_laws():
    """Others compare no law's code; they call ``model/friction/laws.py``."""
    for path in ROOT.rglob("*.py"):
        if path == ROOT / "model" / "friction" / "laws.py":
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Compare):
                for side in (node.left, *node.comparators):
                    assert not (
                        isinstance(side, ast.Attribute)
                        and side.attr == "law"
                        and isinstance(side.value, ast.Name | ast.Attribute)
                        and ast.unparse(side.value).split(".")[-1] in ("par", "friction", "known")
                    ), f"{path}:{node.lineno}"
