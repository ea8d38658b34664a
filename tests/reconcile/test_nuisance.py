"""Paths of nuisance parameters: of the given plant, of another law, or of no plant at all."""

import pytest

from hbench.config.bench import Bench, Plant
from hbench.config.scaling import value_paths
from hbench.config.stroke_model import parse_strokes
from hbench.errors import ConfigError
from hbench.reconcile import nuisance
from hbench.reconcile.nuisance import GROUPS, nuisance_value, nuisances
from tests.support.reconcile.rounds import plant_of


def test_every_path_is_one_of_a_plant_file(bench):
    paths = {path for priors in GROUPS.values() for path in priors}
    assert paths <= value_paths(Plant) < value_paths(Bench)
    of_plant = nuisances(plant_of(bench))
    assert paths - set(of_plant) == {f"friction.{side}.stribeck_force" for side in ("test", "load")}


@pytest.mark.parametrize(
    "path", ["valve.gian", "valves.gain", "friction.test.coulomb_force", "friction.coulomb", "oil"]
)
def test_a_mistyped_path_is_an_error_and_no_missing_nuisance(bench, monkeypatch, path):
    with pytest.raises(ConfigError, match=path):
        nuisance_value(bench, path)
    monkeypatch.setattr(nuisance, "GROUPS", {("supply",): {path: 0.1}})
    with pytest.raises(ConfigError, match=path):
        nuisances(bench)


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
        f"friction.test.{key}" for key in ("coulomb", "stiction", "stribeck_velocity")
    }
    assert nuisance_value(bench, "friction.test.viscous") == friction.viscous
    assert nuisance_value(plant, "friction.test.bristle_stiffness") == 0.0
    assert nuisance_value(plant, "valve.gain") == 0.0
