"""Nuisance parameters: paths of factors on a plant, and tolerances of coefficients."""

from math import sqrt
from types import SimpleNamespace

import numpy as np
import pytest

from hbench.config.bench import Bench, Plant
from hbench.config.friction import PressureBased
from hbench.config.scaling import replaced, scaled, value_paths
from hbench.config.sensors import ForceInstrument, Instruments, PressureInstrument
from hbench.config.stroke_model import parse_strokes
from hbench.errors import ConfigError
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile import nuisance
from hbench.reconcile.hypothesis import effect_coefficients, typical_size
from hbench.reconcile.nuisance import (
    BACKGROUND,
    BOUND,
    FACTORS,
    nuisance_value,
    nuisances,
    standard_deviation,
    tolerances,
    zero_tolerances,
    zero_values,
)
from tests.support.reconcile.rounds import plant_of

PLANT = SimpleNamespace(effects={})


def test_every_path_is_one_of_a_plant_file(bench):
    paths = set(FACTORS)
    assert paths <= value_paths(Plant) < value_paths(Bench)
    of_plant = nuisances(plant_of(bench))
    assert paths - set(of_plant) == {f"friction.{side}.stribeck_force" for side in ("test", "load")}


@pytest.mark.parametrize(
    "path", ["valve.gian", "valves.gain", "friction.test.coulomb_force", "friction.coulomb", "oil"]
)
def test_a_mistyped_path_is_an_error_and_no_missing_nuisance(bench, monkeypatch, path):
    with pytest.raises(ConfigError, match=path):
        nuisance_value(bench, path)
    monkeypatch.setattr(nuisance, "FACTORS", {path: 0.1})
    with pytest.raises(ConfigError, match=path):
        nuisances(bench)


def test_the_zero_tolerances_are_offsets_in_bar_and_newtons():
    """1 % of the largest readings, 200 bar and 5 kN, where no instruments are stated."""
    zeros = zero_tolerances(tolerances(PLANT, None, 200e5, 5e3))
    assert zeros.pop("f_applied") == pytest.approx(50.0)
    assert zeros == pytest.approx(dict.fromkeys(("p_tp", "p_tr", "p_lp", "p_lr", "p_s"), 2.0))
    assert zero_tolerances({}) == {}


def test_a_part_of_a_plant_has_the_nuisances_of_its_own_sections_and_law(bench):
    friction = bench.friction.test
    plant = parse_strokes(
        {
            "test_cylinder": {"piston_diameter": "40 mm"},
            "friction": {
                "test": {
                    "law": "tustin",
                    "coulomb": "40 N",
                    "stiction": "40 N",
                    "stribeck_velocity": "1 mm/s",
                }
            },
        },
        "model",
    )
    assert set(nuisances(plant)) == {
        f"friction.test.{key}"
        for key in ("coulomb", "stiction", "stribeck_velocity", "stribeck_exponent")
    }
    assert nuisance_value(bench, "friction.test.viscous") == friction.viscous
    assert nuisance_value(plant, "friction.test.bristle_stiffness") == 0.0
    assert nuisance_value(plant, "valve.gain") == 0.0


def test_a_small_value_has_a_wide_prior_and_one_of_zero_a_value_to_start_from(bench):
    plant = plant_of(bench)
    assert zero_values(plant) == {}
    usual = nuisances(plant)
    assert usual == {path: FACTORS[path] for path in usual}
    paths = ("supply.tank", "test_cylinder.dead_volume_rod", "friction.load.viscous")
    small = nuisances(scaled(plant, dict.fromkeys(paths, 0.01)))
    assert {path for path in usual if small[path] != usual[path]} == set(paths)
    nothing = scaled(plant, dict.fromkeys(paths, 0.0))
    assert not set(nuisances(nothing)) & set(paths)
    starts = zero_values(nothing)
    assert starts == {
        "supply.tank": pytest.approx(0.125e5),
        "test_cylinder.dead_volume_rod": pytest.approx(
            0.025 * plant.test_cylinder.area_rod_m2 * plant.test_cylinder.stroke
        ),
        "friction.load.viscous": pytest.approx(0.25 * plant.friction.load.stiction),
    }
    begun = plant
    for path, value in starts.items():
        begun = replaced(begun, path.split("."), lambda _, value=value: value)
    reach = nuisances(begun)
    for path in paths:
        assert starts[path] * np.exp(BOUND * reach[path]) > nuisance_value(plant, path)


def test_friction_of_zero_has_a_value_to_start_from_where_its_law_has_the_key(bench):
    plant = plant_of(bench)
    paths = [f"friction.test.{key}" for key in ("coulomb", "stiction", "viscous")]
    starts = zero_values(scaled(plant, dict.fromkeys(paths, 0.0)))
    least = 0.002 * plant.supply.pressure * plant.test_cylinder.area_piston_m2
    assert starts == dict.fromkeys(paths, pytest.approx(0.25 * least))
    assert least / 4 * 125 > plant.friction.test.stiction  # within the bounds
    other = PressureBased(
        law="pressure_based", stribeck_force="300 N", stribeck_rate="-20 s/m", viscous="0 N s/m"
    )
    friction = plant.friction.model_copy(update={"test": other})
    starts = zero_values(plant.model_copy(update={"friction": friction}))
    assert list(starts) == ["friction.test.viscous"]


def test_a_plungers_rod_side_has_no_volume_to_start_from(bench):
    plant = plant_of(bench)
    plunger = plant.test_cylinder.model_copy(
        update={"rod_diameter": plant.test_cylinder.piston_diameter, "dead_volume_rod": 0.0}
    )
    assert zero_values(plant.model_copy(update={"test_cylinder": plunger})) == {}


# ---- tolerances


def instruments(of_force, of_pressure) -> Instruments:
    """1 % with a full scale of 20 kN, and 0.5 % with one of 250 bar."""
    return Instruments(
        force=ForceInstrument.model_construct(tolerance=0.01, of=of_force, full_scale=2e4),
        pressure=PressureInstrument.model_construct(
            tolerance=0.005, of=of_pressure, full_scale=250e5
        ),
    )


PRESSURES = ("p_tp", "p_tr", "p_lp", "p_lr", "p_s")


@pytest.mark.parametrize(
    ("of", "pressure", "force"),
    [("full_scale", 1.25e5, 200.0), ("reading", 0.005 * 120e5, 0.01 * 4e3)],
)
def test_an_offset_is_as_large_as_the_tolerance_at_full_scale_or_at_the_largest_reading(
    of, pressure, force
):
    """120 bar and 4 kN are the largest readings; a gain is off by the tolerance in both cases."""
    found = tolerances(PLANT, instruments(of, of), 120e5, 4e3)
    for name in PRESSURES:
        assert found["pressure_offset", name] == pytest.approx(pressure)
        assert found["pressure_gain", name] == pytest.approx(0.005)
    assert found["load_cell_offset", "force"] == pytest.approx(force)
    assert found["load_cell_gain", "error"] == pytest.approx(0.01)


def test_force_and_pressure_may_be_specified_differently():
    found = tolerances(PLANT, instruments("reading", "full_scale"), 120e5, 4e3)
    assert found["load_cell_offset", "force"] == pytest.approx(40.0)
    assert found["pressure_offset", "p_s"] == pytest.approx(1.25e5)


def test_without_instruments_one_per_cent_of_the_largest_reading_is_assumed():
    found = tolerances(PLANT, None, 120e5, 4e3)
    assert found.keys() == tolerances(PLANT, instruments("reading", "reading"), 1.0, 1.0).keys()
    assert found["pressure_offset", "p_s"] == pytest.approx(1.2e5)
    assert found["load_cell_offset", "force"] == pytest.approx(40.0)
    assert found["pressure_gain", "p_tp"] == found["load_cell_gain", "error"] == 0.01
    for valve in ("test", "load_1", "load_2"):
        assert found["valve_trim", f"gain_{valve}"] == pytest.approx(0.1)
        assert found["valve_trim", f"null_{valve}"] == pytest.approx(0.2)
    assert found["valve_trim", "curvature"] * 3 == pytest.approx(0.03)  # 3 % at 3 V
    assert 0.5 + found["valve_trim", "exponent"] == pytest.approx(0.6)


def test_the_tolerances_of_a_valve_are_shares_of_its_size():
    """Load valves 150 % larger than the test valve: 10 % of their gain, 2 % of their stroke."""
    stated = SimpleNamespace(effects={"valve_trim": {"gain_load_1": 1.5, "gain_load_2": 1.5}})
    found = tolerances(stated, None, 120e5, 4e3)
    for valve, size in {"test": 1.0, "load_1": 2.5, "load_2": 2.5}.items():
        assert found["valve_trim", f"gain_{valve}"] == pytest.approx(0.1 * size)
        assert found["valve_trim", f"null_{valve}"] == pytest.approx(0.2 * size)


def test_a_tolerance_is_of_every_coefficient_that_an_effect_of_it_switches_on():
    """A key that no row has would never be fitted; a half of one would be an effect."""
    found = tolerances(PLANT, instruments("reading", "full_scale"), 120e5, 4e3)
    for name in {effect for effect, _ in found}:
        assert {which for which in found if which[0] == name} == set(effect_coefficients(name))
    assert BACKGROUND <= {effect for effect, _ in found} <= set(EFFECTS)
    for (name, key), limit in found.items():
        row = EFFECTS[name].coefficients[key]
        one_sided = row.low == row.default  # a leak is not negative
        assert one_sided or row.to_si(row.low) <= -limit
        assert limit <= row.to_si(row.high)
        assert 0.1 < limit / typical_size((name, key)) < 20


def test_a_tolerance_is_a_uniform_distribution():
    drawn = np.random.default_rng(0).uniform(-0.7, 0.7, 100_000)
    assert standard_deviation(0.7) == pytest.approx(drawn.std(), rel=0.01)
    assert standard_deviation(0.7) == pytest.approx(0.7 / sqrt(3))
