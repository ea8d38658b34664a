"""The shipped files are good; a bad one is refused with file, key, value and limit."""

import copy
import re
from pathlib import Path

import pytest

from hbench.config.bench import Plant, parse_bench, parse_plant
from hbench.config.conformity.certificate import parse_certificate
from hbench.config.conformity.limits import parse_limits
from hbench.config.files.loading import read_yaml
from hbench.config.files.yaml_text import parse_yaml
from hbench.config.fitting import parse_fitting
from hbench.config.import_map import parse_import_map
from hbench.config.schedule import parse_schedule
from hbench.errors import ConfigError, ExitCode
from hbench.records import KINDS

CONFIGS = Path(__file__).parents[2] / "configs"
BENCH = read_yaml(CONFIGS / "bench-aau.yaml")
SCHEDULE = read_yaml(CONFIGS / "stribeck.yaml")
SCHEDULE["experiments"] = SCHEDULE["experiments"][1:-1]  # without its zero checks


def changed(data: dict, key: str, value: object) -> dict:
    data = copy.deepcopy(data)
    *path, last = key.split(".")
    place = data
    for part in path:
        place = place[int(part)] if isinstance(place, list) else place[part]
    place[last] = value
    return data


def test_the_bench_of_the_source_has_its_printed_values_in_si():
    bench = parse_bench(BENCH, "bench-aau.yaml")
    assert bench.test_cylinder.area_piston_m2 == pytest.approx(1.25664e-3, rel=1e-5)
    assert bench.test_cylinder.area_rod_m2 == pytest.approx(7.65763e-4, rel=1e-5)
    assert (bench.supply.pressure, bench.supply.tank) == (1.5e7, 2e5)
    assert bench.valve.gain == 7.43e-7
    assert bench.controllers.piston_pressure.gain == 6.5e-5
    assert bench.controllers.feedforward.piston == 34.0682
    assert bench.instruments.force.tolerance == pytest.approx(0.01)


@pytest.mark.parametrize("name", ["stribeck.yaml", "demo.yaml", "adaptive.yaml"])
def test_the_shipped_schedules_are_good(name):
    parse_schedule(read_yaml(CONFIGS / name), name)


def test_the_shipped_import_map_is_good():
    parse_import_map(read_yaml(CONFIGS / "tudelft.yaml"), "tudelft.yaml")


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("oil.density", 870, ["oil.density", "870", "no unit", "kg/m^3"]),
        ("oil.density", "870 bar", ["oil.density", "wrong unit"]),
        ("oil.density", "8700 kg/m^3", ["oil.density", "8700 kg/m^3", "2000 kg/m^3"]),
        ("supply.pressure", "-1 bar", ["supply.pressure", "-1 bar", "0 bar"]),
        ("supply.pressure", "0 bar", ["supply.pressure", "0 bar", "greater than"]),
        ("instruments.force.full_scale", "0 kN", ["instruments.force.full_scale", "greater than"]),
        ("sensors.pressure.span", "0 bar", ["sensors.pressure.span", "0 bar", "greater than"]),
        ("sensors.adc.reference", "1e-300 V", ["sensors.adc.reference", "1e-300 V", "1e-06 V"]),
        (
            "friction.test.stribeck_exponent",
            1000,
            ["friction.test.stribeck_exponent", "1000", "at most 20"],
        ),
        ("sensors.adc.oversampling", True, ["sensors.adc.oversampling", "True", "number"]),
        ("sensors.load_cell.poisson", False, ["sensors.load_cell.poisson", "False", "number"]),
        ("valve.gian", "1 V", ["'valve.gian'"]),
        (
            "test_cylinder.rod_diameter",
            "41 mm",
            ["test_cylinder", "rod_diameter", "piston_diameter"],
        ),
        (
            "limits.travel_max",
            "500 mm",
            ["limits.travel_max = 500 mm", "test_cylinder.stroke = 400 mm"],
        ),
        (
            "limits.travel_min",
            "376 mm",
            ["limits.travel_min = 376 mm", "limits.travel_max = 375 mm"],
        ),
        ("limits.travel_max", "390 mm", ["limits.travel_max = 390 mm", "380 mm"]),
        ("test_cylinder.stroke", "400,5 mm", ["decimal comma"]),
        ("supply.pressure", "150 Bar", ["supply.pressure", "'Bar'", "'bar'"]),
        ("supply.pressure", "150 at", ["supply.pressure", "'at'", "psi"]),
        ("controllers.log_rate", "300 Hz", ["controllers.rate", "controllers.log_rate", "65535"]),
        ("sensors.adc.bits", 40, ["sensors.adc.bits"]),
    ],
)
def test_a_fault_in_a_bench_file_is_named(key, value, words):
    with pytest.raises(ConfigError) as error:
        parse_bench(changed(BENCH, key, value), "my-bench.yaml")
    assert error.value.exit_code == ExitCode.USAGE
    for word in ["my-bench.yaml", *words]:
        assert word in str(error.value)


def test_a_missing_key_is_named():
    data = copy.deepcopy(BENCH)
    del data["oil"]["density"]
    with pytest.raises(ConfigError, match="b.yaml: .*'oil.density'"):
        parse_bench(data, "b.yaml")


@pytest.mark.parametrize(("right", "wrong"), [("oil.density", "densty"), ("oil", "oli")])
def test_a_misspelt_key_is_told_once_with_the_one_that_is_meant(right, wrong):
    data = copy.deepcopy(BENCH)
    *above, key = right.split(".")
    section = data[above[0]] if above else data
    section[wrong] = section.pop(key)
    with pytest.raises(ConfigError) as error:
        parse_bench(data, "b.yaml")
    told = ".".join([*above, wrong])
    assert re.fullmatch(rf"b.yaml: .*'{told}'.*'{key}'.?", error.value.message)


def test_a_file_of_another_kind_is_told_in_one_line():
    files = ("tudelft.yaml", "fit.yaml", "limits.yaml")
    columns, laws, limits = (read_yaml(CONFIGS / name) for name in files)
    for parse, data, types in (
        (parse_schedule, BENCH, ["bench file", "schedule"]),
        (parse_bench, SCHEDULE, ["schedule", "bench file"]),
        (parse_bench, columns, ["import map", "bench file"]),
        (parse_import_map, BENCH, ["bench file", "import map"]),
        (parse_fitting, SCHEDULE, ["schedule"]),
        (parse_schedule, laws, ["file of fits", "schedule"]),
        (parse_schedule, {"product": "A", "weight": 2}, ["schedule", "product, weight"]),
        (parse_limits, laws, ["file of fits", "file of limits"]),
        (parse_limits, BENCH, ["bench file", "file of limits"]),
        (parse_bench, limits, ["file of limits", "bench file"]),
        (parse_certificate, limits, ["file of limits", "certificate's file"]),
    ):
        with pytest.raises(ConfigError) as error:
            parse(data, "x.yaml")
        assert re.match("x.yaml: .*" + ".*".join(types), error.value.message)
        assert "\n" not in error.value.message


def test_every_fault_of_a_file_is_told_at_once():
    data = changed(changed(BENCH, "oil.density", "1 m"), "supply.tank", "2")
    with pytest.raises(ConfigError) as error:
        parse_bench(data, "b.yaml")
    assert "oil.density" in str(error.value) and "supply.tank" in str(error.value)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("experiments.0.kind", "stedy",
         ["experiments.0.kind = 'stedy'", *KINDS]),
        ("experiments.0.trials", "three", ["experiments.0.trials = 'three'"]),
        ("experiments.0.trials", True, ["experiments.0.trials = True", "number", "yes"]),
        ("experiments.0.direction", "out",
         ["experiments.0.direction = 'out'", "'extend'", "'retract'"]),
        ("experiments.0.loads", "500 N", ["experiments.0.loads = '500 N'", "[500 N]"]),
        ("experiments.0.velocities", {"first": "50 mm/s", "last": "200 mm/s", "count": 15},
         ["experiments.0.velocities", "0.75 m/s"]),
        ("experiments.0.travel", {"start": "300 mm", "end": "20 mm"},
         ["experiments.0.travel", "'start'", "'end'"]),
        ("experiments.0.loads", [], ["experiments.0.loads"]),
        ("experiments.0.loads", "500 N, 1 kN", ["experiments.0.loads", "[500 N, 1 kN]"]),
        ("experiments.0.loads", [500], ["experiments.0.loads.0 = 500"]),
        ("experiments.0.loads", ["500 N; 5 kN"], ["experiments.0.loads.0 = '500 N; 5 kN'"]),
        ("experiments.0.trial", 3, ["'experiments.0.trial'", "'trials'"]),
        ("experiments.0.trials", 0, ["experiments.0.trials = 0", "1"]),
        ("speed", "1 m/s", ["'speed'"]),
    ],
)  # fmt: skip
def test_a_fault_in_a_schedule_is_named(key, value, words):
    with pytest.raises(ConfigError) as error:
        parse_schedule(changed(SCHEDULE, key, value), "my.yaml")
    assert str(error.value).count("my.yaml") == 1  # nothing follows from it
    for word in ["my.yaml", *words]:
        assert word in str(error.value)


def test_a_list_of_decimal_commas_is_told_what_a_comma_means_in_a_list():
    data = changed(SCHEDULE, "experiments.0.loads", [0, "5 kN"])  # of [0,5 kN]
    with pytest.raises(ConfigError) as error:
        parse_schedule(data, "my.yaml")
    assert "[0.5 kN, 5 kN]" in error.value.hint
    with pytest.raises(ConfigError, match="must be at most") as error:
        parse_schedule(changed(SCHEDULE, "experiments.0.loads", ["1e9 kN"]), "schedule.yaml")
    assert not error.value.hint


ENDS = {"first": "5 mm/s", "last": "200 mm/s"}
ADAPTIVE = {**ENDS, "strategy": "adaptive", "min_step": "3 mm/s", "max_step": "40 mm/s",
            "tolerance": "2 N"}  # fmt: skip
STRATEGIES = ["polynomial", "linear", "slope_adjusted", "adaptive"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"velocities": {**ENDS, "strategy": "cubic", "count": 9}}, ["velocities", *STRATEGIES]),
        ({"velocities": "fast"}, ["velocities = 'fast'", *STRATEGIES]),
        ({"velocities": []}, ["experiments.0.velocities = []"]),
        ({"velocities": ["5 mm/s", "6 bar"]}, ["experiments.0.velocities.1 = '6 bar'"]),
        ({"velocities": {**ENDS, "strategy": "linear"}},
         ["'experiments.0.velocities.count'"]),
        ({"velocities": {**ENDS, "strategy": "slope_adjusted", "count": 9}},
         ["'experiments.0.velocities.transition'"]),
        ({"velocities": {**ENDS, "strategy": "slope_adjusted", "transition": "3 mm/s", "count": 9}},
         ["experiments.0.velocities: ", "'first', 'transition'", "'last'"]),
        ({"velocities": {**ADAPTIVE, "count": 9}},
         ["'experiments.0.velocities.count'"]),
        ({"velocities": {**ADAPTIVE, "tolerance": "2 mm"}},
         ["experiments.0.velocities.tolerance = '2 mm'", "N"]),
        ({"velocities": {**ADAPTIVE, "max_step": "5 mm/s"}},
         ["experiments.0.velocities: 'max_step'", "'min_step'"]),
        ({"velocities": ADAPTIVE, "order": "passes"}, ["experiments.0: order", "adaptive"]),
        ({"velocities": ADAPTIVE, "trials": 1}, ["experiments.0: adaptive", "trials: 2"]),
    ],
)  # fmt: skip
def test_a_fault_in_velocities_is_one_line_with_the_key_as_it_stands_in_the_file(change, words):
    data = copy.deepcopy(SCHEDULE)
    data["experiments"][0] |= change
    with pytest.raises(ConfigError) as error:
        parse_schedule(data, "my.yaml")
    assert str(error.value).count("my.yaml") == 1 and str(error.value).count("\n") == 0
    for word in ["my.yaml", *words]:
        assert word in str(error.value)


@pytest.mark.parametrize("order", ["passes", "random"])
@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"order": "row"}, ["experiments.0.order"]),
        ({"order": "passes"}, ["experiments.0.order"]),
        ({"velocities": ADAPTIVE}, ["experiments.0.velocities", "adaptive"]),
    ],
)
def test_passes_over_the_whole_plan_go_with_no_other_order_and_no_adaptive_speeds(
    change, words, order
):
    data = copy.deepcopy(SCHEDULE) | {"order": order}
    data["experiments"][0].pop("order", None)
    assert parse_schedule(data, "my.yaml").order == order
    data["experiments"][0] |= change
    with pytest.raises(ConfigError) as error:
        parse_schedule(data, "my.yaml")
    for word in ["my.yaml", f"order: {order}", *words]:
        assert word in str(error.value)


def test_a_seed_without_a_random_order_is_refused():
    with pytest.raises(ConfigError, match="my.yaml: seed: applies to order: random only"):
        parse_schedule(copy.deepcopy(SCHEDULE) | {"order": "passes", "seed": 2}, "my.yaml")


def test_a_plant_file_replaces_single_keys_of_the_bench():
    over = {"friction": {"test": {"viscous": "3000 N s/m"}}, "oil": {"bulk_modulus": "900 bar"}}
    plant = parse_plant(BENCH, over, "plant.yaml")
    assert plant.friction.test.viscous == 3000
    assert plant.friction.load.viscous == parse_bench(BENCH, "b").friction.load.viscous
    assert plant.oil.bulk_modulus == 9e7
    assert plant.oil.density == 870


def test_a_rod_of_0_mm_makes_the_areas_equal_as_a_rod_on_both_sides_does():
    bench = read_yaml(CONFIGS / "bench-aau.yaml")
    bench["test_cylinder"]["rod_diameter"] = "0 mm"
    cylinder = parse_bench(bench, "bench").test_cylinder
    assert cylinder.area_rod_m2 == cylinder.area_piston_m2


def test_a_whole_bench_file_as_a_plant_file_is_its_physics_alone():
    other = changed(BENCH, "oil.bulk_modulus", "900 bar") | {"name": "another bench"}
    with_effects = BENCH | {"effects": {"valve_lag": {"time": "2 ms"}}}
    plant = parse_plant(with_effects, other, "other.yaml")
    assert (plant.oil.bulk_modulus, plant.effects) == (9e7, {})
    with pytest.raises(ConfigError, match="other.yaml: .*'controllers'"):
        parse_plant(BENCH, {k: v for k, v in other.items() if k != "controllers"}, "other.yaml")


def test_the_model_of_the_shipped_bench_is_its_physics():
    """Every section of it but the sensors, which are the campaign's; so no number differs."""
    model = read_yaml(CONFIGS / "model-aau.yaml")
    assert set(model) == set(Plant.model_fields) - {"sensors", "effects", "learned"}
    only_sensors = {"sensors": BENCH["sensors"]}
    assert parse_plant(only_sensors, model, "model") == parse_plant(BENCH, {}, "bench")


def test_a_plant_file_may_not_touch_what_is_not_physics():
    with pytest.raises(ConfigError, match="plant.yaml: .*'controllers'"):
        parse_plant(BENCH, {"controllers": {}}, "plant.yaml")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a: 1\na: 2\n", ["line 2", "'a'"]),
        ("a: [1\n", ["line 2", "not valid|,"]),
        ("- 1\n", ["key"]),
        ("a: !!python/object/apply:os.system ['true']\n", ["python/object"]),
        ("\x00", [":"]),
    ],
)
def test_a_file_that_is_no_yaml_mapping_is_refused_with_its_line(tmp_path, text, words):
    path = tmp_path / "x.yaml"
    path.write_text(text)
    with pytest.raises(ConfigError, match="x.yaml") as error:
        read_yaml(path)
    for word in words:
        assert any(part in str(error.value) + error.value.hint for part in word.split("|"))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ConfigError, match=r"nothing\.yaml"):
        read_yaml(tmp_path / "nothing.yaml")


def test_a_folder_is_not_taken_for_a_file(tmp_path):
    with pytest.raises(ConfigError, match="folder"):
        read_yaml(tmp_path)


def test_a_decimal_comma_in_braces_is_named():
    limits = parse_yaml("limits: [{quantity: efficiency, min: 80,5 %}]")
    with pytest.raises(ConfigError, match=r"unknown key 'limits\.0\.5 %'.*write a decimal point"):
        parse_limits(limits, "limits.yaml")


def test_an_empty_list_states_how_many_entries_it_needs():
    with pytest.raises(ConfigError, match=r"limits = \[\]: has 0 entries; limit at least 1$"):
        parse_limits({"limits": []}, "limits.yaml")


def test_the_number_of_a_column_from_0_has_one_message():
    data = read_yaml(CONFIGS / "import-csv.yaml")
    with pytest.raises(ConfigError) as caught:
        parse_import_map(changed(data, "columns.x_m.column", 0), "map.yaml")
    assert caught.value.message == "map.yaml: columns.x_m.column = 0: must be at least 1"


def test_a_map_in_utf_16_has_a_hint(tmp_path):
    (tmp_path / "map.yaml").write_text("name: Prüfstand", encoding="utf-16")
    with pytest.raises(ConfigError, match="not a text file in UTF-8") as caught:
        read_yaml(tmp_path / "map.yaml")
    assert "Save it as UTF-8" in caught.value.hint


@pytest.mark.parametrize("key", ["columns.x_m.scale", "columns.x_m.column", "format.preamble"])
def test_a_truth_value_is_no_number_of_an_import_map(key):
    """YAML reads yes as true, which would be 1."""
    rules = read_yaml(CONFIGS / "import-csv.yaml")
    with pytest.raises(ConfigError, match=rf"{key} = True: must be a number"):
        parse_import_map(changed(rules, key, True), "map.yaml")


@pytest.mark.parametrize("value", ["900", "0,9 kN", "0.9 kn"])
def test_a_limit_that_cannot_be_read_is_named_with_its_value(value):
    limits = {"limits": [{"quantity": "friction", "max": value}]}
    with pytest.raises(ConfigError, match=rf"limits\.0: max = '{value}': "):
        parse_limits(limits, "limits.yaml")


def test_a_limit_without_a_unit_has_no_hint_on_lists():
    with pytest.raises(ConfigError, match="write for example '350 N'") as caught:
        parse_limits({"limits": [{"quantity": "friction", "max": 350}]}, "limits.yaml")
    assert "list" not in caught.value.hint


def test_keys_in_place_of_a_limit_are_named():
    limits = {"limits": [{"quantity": "friction", "max": {"extend": "3 N", "retract": "4 N"}}]}
    with pytest.raises(ConfigError, match=r"max: must be one value; it has the keys 'extend, ret"):
        parse_limits(limits, "limits.yaml")


def test_a_serial_that_yaml_reads_as_a_truth_value_is_no_number():
    data = read_yaml(CONFIGS / "import-csv.yaml")
    with pytest.raises(ConfigError, match=r"specimen\.serial = False: yes and no") as caught:
        parse_import_map(changed(data, "specimen", {"serial": False}), "map.yaml")
    assert "number" not in caught.value.message


@pytest.mark.parametrize("text", ["31.01.2026", "2026-01-31 10:00:00", "20260131", "2026", "yes"])
def test_a_day_in_another_notation_is_refused_with_the_right_one(text):
    certificate = read_yaml(CONFIGS / "certificate.yaml")
    certificate |= parse_yaml(f"issued: {text}\nreceived: '{text}'")
    with pytest.raises(ConfigError) as error:
        parse_certificate(certificate, "certificate.yaml")
    assert (
        len(re.findall(r"\b(issued|received) = .*: must be a date\b.*2026-01-31", str(error.value)))
        == 2
    )
