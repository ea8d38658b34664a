"""The section ``effects`` of a bench or plant file."""

import pytest

from hbench.config.bench import parse_bench, parse_plant
from hbench.config.effects import Coefficient, parse_effects
from hbench.config.files.loading import read_yaml
from hbench.errors import ConfigError
from hbench.model.effects.catalogue import EFFECTS, lookalikes, read_effects
from hbench.model.effects.guide import guide
from hbench.model.effects.rows import Effect
from hbench.reconcile.measured.balances import BALANCES
from hbench.records import KINDS
from tests.support import ROOT

BENCH = read_yaml(ROOT / "configs" / "bench-aau.yaml")


def test_coefficients_come_in_si_with_defaults_for_those_not_given():
    values = read_effects({"supply_droop": {"slope": "0.6 bar min/l"}})
    assert values == {"supply_droop": {"slope": pytest.approx(3.6e9), "lag": 0.02, "exponent": 1.0}}


def test_the_description_of_an_error_of_either_sign_states_no_sign():
    both = [each for each in EFFECTS.values() if each.of_sensor and _may_be_negative(each)]
    assert len(both) == 4
    for effect in both:
        assert "too much" not in effect.description and "too little" not in effect.description


def _may_be_negative(effect):
    return any(coefficient.low < 0 for coefficient in effect.coefficients.values())


@pytest.mark.parametrize(
    ("section", "says"),
    [
        ({"leakage": {"test": "1 l/min/bar"}}, " added_mass, direction_asymmetry"),
        ({"valve_lag": {"tau": "1 ms"}}, "effects.valve_lag.tau: "),
        ({"valve_lag": {"time": "1 V"}}, "effects.valve_lag.time = '1 V': "),
        ({"valve_lag": {"time": "0.2 s"}}, "effects.valve_lag.time = '0.2 s': "),
        ({"internal_leakage": {"test": "-1 l/min/bar"}}, " 0 and 1 l/min/bar"),
        (
            {"oil_warming": {}},
            "so it changes nothing; 'rise: 10 K/kW' is a clear effect",
        ),
    ],
)
def test_a_name_a_unit_or_a_size_that_is_wrong_is_refused(section, says):
    with pytest.raises(ConfigError, match="effects") as caught:
        read_effects(section)
    assert says in caught.value.message


def test_all_faults_are_told_at_once():
    with pytest.raises(ConfigError) as caught:
        read_effects({"a": {}, "valve_lag": {"time": "x", "b": "1 V"}})
    assert len(caught.value.message.splitlines()) == 3


def test_the_limits_themselves_are_allowed_whatever_the_unit_rounds_to():
    known = {"e": {"c": Coefficient("l/min/bar", 0.1, 0.3, 0.7)}}
    for size in ("0.3 l/min/bar", "0.7 l/min/bar"):
        assert parse_effects({"e": {"c": size}}, known)


def test_a_plant_file_lays_its_effects_over_those_of_the_bench():
    bench = BENCH | {"effects": {"valve_lag": {"time": "2 ms"}, "added_mass": {"test": "1 kg"}}}
    over = {"effects": {"added_mass": {"load": "2 kg"}, "load_cell_gain": {"error": "1 %"}}}
    assert read_effects(parse_plant(bench, over, "plant").effects) == {
        "valve_lag": {"time": 0.002, "second": 0.0},
        "added_mass": {"test": 1.0, "load": 2.0, "lag": 0.003},
        "load_cell_gain": {"error": pytest.approx(0.01)},
    }
    assert parse_plant(BENCH, {}, "plant").effects == parse_bench(BENCH, "bench").effects == {}


@pytest.mark.parametrize("section", [["valve_lag"], {"valve_lag": "2 ms"}, {"valve_lag": None}])
def test_an_effect_is_a_mapping_of_coefficients(section):
    with pytest.raises(ConfigError, match="effects"):
        parse_bench(BENCH | {"effects": section}, "bench")


def test_the_catalogue_is_complete_and_its_typical_sizes_are_in_range():
    assert set(EFFECTS) == {
        *("internal_leakage", "external_leakage", "supply_droop", "valve_deadband"),
        *("valve_asymmetry", "valve_lag", "entrained_air", "seal_pressure_friction"),
        *("load_friction", "direction_asymmetry", "friction_lag", "presliding"),
        *("position_friction", "oil_warming", "end_cushion", "tank_back_pressure", "added_mass"),
        *("load_cell_gain", "load_cell_offset", "pressure_offset", "velocity_filter_lag"),
        *("valve_trim", "valve_hysteresis", "pressure_gain", "rest_time"),
    }
    for row in EFFECTS.values():
        assert set(row.balances) <= set(BALANCES)
        assert any(one.typical for one in row.coefficients.values())
        for one in row.coefficients.values():
            one.read(f"{one.typical or one.default} {one.unit}")
    assert {name for name, row in EFFECTS.items() if row.of_sensor} == {
        *("load_cell_gain", "load_cell_offset", "pressure_offset", "velocity_filter_lag"),
        "pressure_gain",
    }
    assert {name for name, row in EFFECTS.items() if row.builds_up} == {"oil_warming"}


def test_rows_of_valves_and_transducers_have_a_coefficient_for_each_of_them():
    valves = ("test", "load_1", "load_2")
    assert set(EFFECTS["valve_trim"].coefficients) == {
        *(f"gain_{valve}" for valve in valves),
        *(f"null_{valve}" for valve in valves),
        *("curvature", "small", "exponent", "ports", "inlets", "hose", "leak", "null_leak"),
    }
    transducers = {"p_tp", "p_tr", "p_lp", "p_lr", "p_s"}
    assert set(EFFECTS["pressure_gain"].coefficients) == transducers
    assert set(EFFECTS["pressure_offset"].coefficients) == transducers
    read = read_effects({"valve_trim": {"null_load_1": "-50 mV", "exponent": "0.1 1"}})
    assert read["valve_trim"] == {
        **dict.fromkeys(EFFECTS["valve_trim"].coefficients, 0.0),
        "null_load_1": pytest.approx(-0.05),
        "exponent": 0.1,
    }


# ---- what the catalogue tells its reader


@pytest.mark.parametrize("name", EFFECTS)
def test_a_row_says_what_moves_what_to_inspect_and_repair_and_where_its_law_is_from(name):
    row = EFFECTS[name]
    assert not row.description.endswith(".") and not row.inspect.endswith(".")
    assert row.law and row.source
    for sentence in (row.signals, row.repair):
        assert sentence[0].isupper() and sentence.endswith(".")
    for one in row.coefficients.values():
        assert one.low <= one.typical <= one.high or not one.typical


def test_look_alikes_are_effects_and_are_so_both_ways_with_one_run_for_each_pair():
    pairs = [(name, other) for name, row in EFFECTS.items() for other in row.confused_with]
    assert {other for _, other in pairs} <= set(EFFECTS)
    assert len({frozenset(pair) for pair in pairs}) == len(pairs)
    for name, other in pairs:
        assert name != other
        assert lookalikes(name)[other] == lookalikes(other)[name]
        assert lookalikes(name)[other].kind in KINDS
        assert lookalikes(name)[other].why
    assert all(lookalikes(name) for name, row in EFFECTS.items() if row.balances)


def test_the_committed_page_of_the_catalogue_is_the_generated_one():
    page = ROOT / "hbench" / "model" / "effects" / "README.md"
    assert page.read_text() == guide(EFFECTS), "run python -m hbench.model.effects.guide"


def test_every_name_unit_bound_and_text_is_on_the_page():
    page = guide(EFFECTS)
    for name, row in EFFECTS.items():
        part = page.partition(f"\n## {name}\n")[2].partition("\n## ")[0]
        texts = (row.law, row.signals, row.inspect, row.repair, row.source, *row.coefficients)
        assert all(text in part for text in texts), name
        for other, separation in lookalikes(name).items():
            assert f"[{other}](#{other}) | `{separation.kind}` | {separation.why} |" in part
        for one in row.coefficients.values():
            assert f"| {one.unit} | " in part and f" | {one.low:g} | {one.high:g} | " in part


def test_a_users_effect_without_texts_has_a_page_too():
    row = Effect("1 / beta grows", {"soft": Coefficient("1/bar", 1e-4, 0, 0.1)}, (), {})
    page = guide({"soft_hose": row, **EFFECTS})
    assert "## soft_hose" in page and "| soft | 1/bar | 0.0001 | 0 | 0.1 | 0 |" in page
