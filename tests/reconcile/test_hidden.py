"""The generator of blind campaigns: what it takes, what it lists."""

import ast
import os
import subprocess
import sys
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from hbench.analysis.screening.calibrate import calibrate
from hbench.model.build import plant_parameters
from hbench.model.effects.catalogue import EFFECTS
from hbench.model.effects.couplings import ChamberFlows, FrictionTerms, OilProperties, Openings
from hbench.model.sensors import FRACTION, sensor_parameters
from hbench.model.states import P_LP, P_LR, P_S, P_TP, P_TR, V, X
from hbench.protocol.dictionary import RECORD
from hbench.reconcile.nuisance import BACKGROUND
from hbench.records import RUN_FLAGS
from hbench.store.campaign.folder import load_campaign
from hbench.store.exporting.runs import channels
from hbench.store.importing.importer import import_folder
from hbench.workflow import load_experiment
from tests.support import ROOT
from tests.support.hidden.background import PRESSURES, SIDES, VALVES, wandering
from tests.support.hidden.cases import Case, cases, small_sample, truth
from tests.support.hidden.draws import drawn
from tests.support.hidden.foreign import write_index, write_mapped
from tests.support.hidden.instruments import astray, rewritten
from tests.support.hidden.laws.table import EFFECTS as HIDDEN
from tests.support.hidden.measure import plant_of
from tests.support.hidden.sizes import KNOWN, OUTSIDE

BENCH = ROOT / "configs" / "bench-aau.yaml"
FOLDER = ROOT / "tests" / "support" / "hidden"
CATALOGUE = {f"hbench.model.effects.{name}" for name in ("flows", "friction", "instruments")}
CATALOGUE |= {"hbench.model.effects.catalogue.EFFECTS", "hbench.reconcile"}


def imported(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def test_the_hidden_plants_do_not_import_the_catalogues_laws():
    files = sorted(FOLDER.rglob("*.py"))
    assert len(files) > 8
    for path in files:
        found = set(imported(path))
        assert not found & CATALOGUE, path


def test_what_diagnoses_can_list_the_cases_without_their_laws():
    for name in ("background", "cases", "draws", "sizes"):
        assert not any(m.startswith("hbench") for m in imported(FOLDER / f"{name}.py"))


def test_the_cases_are_those_that_the_benchmark_needs():
    listed = cases()
    assert len({case.name for case in listed}) == len({case.seed for case in listed}) == len(listed)
    groups = {group: [c for c in listed if c.group == group] for group in ("single", "none")}
    sought = {name for name, row in EFFECTS.items() if row.balances}
    assert set(KNOWN) == sought - BACKGROUND
    for name in KNOWN:
        for severity in (0.5, 1.0, 2.0):
            assert [c.effects for c in groups["single"]].count({name: severity}) >= 3
    assert len(groups["single"]) >= 200 and len(groups["none"]) >= 60
    assert sum(c.group == "pair" for c in listed) >= 24
    outside = [c for c in listed if c.group == "outside"]
    assert len(outside) >= 24 and len({name for c in outside for name in c.effects}) >= 6
    assert not set(OUTSIDE) & set(EFFECTS)
    assert {case.group for case in small_sample()} == {"single", "none", "pair", "outside"}
    assert not any(truth(case).leuven for case in small_sample())
    assert 0.2 < np.mean([truth(case).leuven for case in listed]) < 0.4


def test_sizes_follow_the_severity_and_the_seed_alone():
    for case in cases():
        for name, found in truth(case).effects.items():
            size = (KNOWN | OUTSIDE)[name]
            amounts = {key: value for key, value in found.items() if key in size.amounts}
            shares = [v / size.amounts[key] / case.effects[name] for key, v in amounts.items() if v]
            assert shares and all(0.8 <= abs(share) <= 1.2 for share in shares)
            assert size.signed or min(shares) > 0
        assert truth(case) == truth(case)


def test_every_bench_has_small_errors_within_the_class_of_its_valves_and_sensors():
    """Uniform up to a limit, independent of what else is hidden."""
    many = [truth(case).background for case in cases()]
    limits = {
        "valve_gain": (VALVES, 0.05),
        "valve_null_v": (VALVES, 0.05),
        "pressure_offset_pa": (PRESSURES, 0.08e5),
        "pressure_drift_pa": (PRESSURES, 0.05e5),
        "pressure_gain": (PRESSURES, 1e-3),
    }
    for name, (keys, limit) in limits.items():
        drawn_errors = np.array([list(getattr(one, name).values()) for one in many])
        assert all(tuple(getattr(one, name)) == keys for one in many)
        assert np.abs(drawn_errors).max(axis=0) == pytest.approx(limit, rel=0.03)
        assert np.std(drawn_errors, axis=0) == pytest.approx(limit / np.sqrt(3), rel=0.15)
        assert np.abs(np.corrcoef(drawn_errors.T) - np.eye(len(keys))).max() < 0.2
    assert 4.8 < max(abs(one.cell_offset_n) for one in many) < 5.0
    assert 0.0029 < max(abs(one.cell_gain) for one in many) < 0.003
    assert all(0.01 <= one.wander[side] <= 0.03 for one in many for side in SIDES)
    assert drawn({}, 7).background == drawn({"supply_droop": 1.0}, 7).background


def test_a_law_of_the_catalogue_can_be_hidden_beside_the_small_errors(bench):
    own = {"internal_leakage": {"test": "3e-3 l/min/bar"}}
    effects = plant_of(bench, truth(Case("leak-7", {}, 7, "own", own))).effects
    assert effects == own | plant_of(bench, truth(Case("none-7", {}, 7, "none"))).effects
    assert len(effects) > 3


def test_an_error_of_a_sensor_that_is_an_effect_is_larger_than_its_class_allows(bench):
    """At the largest reading of these campaigns, for the mildest severity that is listed."""
    force, pressure = bench.instruments.force, bench.instruments.pressure
    assert force.of == pressure.of == "reading"
    at_5_kn, at_supply = force.tolerance * 5e3, pressure.tolerance * bench.supply.pressure
    least = {name: 0.8 * 0.5 * min(size.amounts.values()) for name, size in KNOWN.items()}
    assert least["load_cell_gain"] * 5e3 > at_5_kn and least["load_cell_offset"] > at_5_kn
    assert least["pressure_offset"] > at_supply
    assert 0.8 * min(OUTSIDE["pressure_drift"].amounts.values()) > at_supply
    assert 0.8 * min(OUTSIDE["cell_crosstalk"].amounts.values()) * 50e5 > at_5_kn


def test_the_level_of_friction_wanders_from_run_to_run():
    """Its standard deviation and correlation, over many runs; the first run is no exception."""
    change = wandering(0.02, 20_000, np.random.default_rng(1))
    assert np.std(change) == pytest.approx(0.02, rel=0.05)
    for lag in (1, 2, 3):
        shifted = np.corrcoef(change[lag:], change[:-lag])[0, 1]
        assert shifted == pytest.approx(0.8**lag, abs=0.04)
    firsts = [wandering(0.02, 2, np.random.default_rng(seed))[0] for seed in range(2000)]
    assert np.std(firsts) == pytest.approx(0.02, rel=0.06)


# ---- laws, called as Python: what they do at the point that sizes.py gives them for


STATE = np.zeros(60)
STATE[[X, V, P_TP, P_TR, P_LP, P_LR, P_S]] = 0.2, 0.1, 80e5, 50e5, 60e5, 30e5, 150e5
OPENED = Openings(0.4, -0.3, 2.0)
AT = 40  # of a law's own states


@pytest.fixture(scope="module")
def par(bench):
    return plant_parameters(bench)


def at_place(place, par):
    beta = par.bulk_modulus_pa
    return {
        "openings": OPENED,
        "oil": OilProperties(2e5, beta, beta, beta, beta),
        "flows": ChamberFlows(1e-4, -5e-5, -6e-5, 3e-5, 1.3e-4, 1.1e-4, 1.0),
        "friction": FrictionTerms(300.0, 250.0, 0.0, 0.0, 0.0, 0.0),
    }[place]


def law(name, par, place=None, state=STATE, **coefficients):
    """Return what a law adds, and its rates."""
    row = HIDDEN[f"hidden_{name}"]
    place = place or next(iter(row.laws))
    rates, before = np.full(60, np.nan), at_place(place, par)
    values = tuple(coefficients.get(key, 0.0) for key in row.coefficients)
    after = row.laws[place](before, values, state, AT, rates, par)
    return np.subtract(after, before), rates[AT : AT + row.states]


@pytest.mark.parametrize("name", HIDDEN)
def test_a_law_with_its_amounts_at_zero_is_neutral_to_the_bit_and_leaves_its_states(par, name):
    for place in HIDDEN[name].laws:
        added, rates = law(name.removeprefix("hidden_"), par, place)
        assert not added.any()
    assert not rates.any()


def test_leaks_are_as_large_as_their_table_says_and_leave_the_higher_pressure(par):
    drop = STATE[P_TP] - STATE[P_TR]
    assert drop == STATE[P_LP] - STATE[P_LR] == 30e5
    added, _ = law("internal_leakage", par, test=1e-6, load=2e-6, exponent=0.6)
    assert added == pytest.approx(np.array([-1, 1, -2, 2, 0, 0, 0]) * 1e-6, rel=0.03)
    added, _ = law("external_leakage", par, tr=1e-6, exponent=1.3)
    assert added == pytest.approx(np.array([0, -1, 0, 0, 0, 0, 0]) * 1e-6, rel=0.03)


def test_valves_lose_their_lap_and_open_further_one_way(par):
    added, _ = law("valve_deadband", par, test=0.02, load=0.02)
    assert added == pytest.approx([-0.02, 0.02, -0.02], abs=1e-3)
    added, _ = law("valve_asymmetry", par, test=0.05, load=0.05, knee=1e-3)
    assert added == pytest.approx([0.02, 0.015, 0.1], rel=1e-3)
    added, _ = law("flow_force", par, share=0.05)
    assert added == pytest.approx([-0.4 * 0.05 * 120 / 150, 0, 0])


def test_each_valve_has_a_gain_and_a_null_of_its_own(par):
    added, _ = law("valve_spread", par, test=0.05, load_1=-0.02, null_load_2=0.03)
    assert added == pytest.approx([0.4 * 0.05, 0.3 * 0.02, 0.03])
    added, _ = law("valve_spread", par, load_2=0.05, null_load_2=0.1)
    assert added == pytest.approx([0, 0, 1.05 * 2.1 - 2.0])


def test_ports_are_laminar_below_a_drop_and_sharp_edged_above(par):
    """At a drop of 70 bar to the supply 0.7 % less, at 1 bar less by a factor of sqrt(2)."""
    added, _ = law("laminar_ports", par, transition=1e5)
    assert added[0] == pytest.approx(1e-4 * (np.sqrt(70 / 71) - 1))
    assert added[1] == pytest.approx(-5e-5 * (np.sqrt(48 / 49) - 1))
    low = STATE.copy()
    low[P_LP] = 3e5
    added, _ = law("laminar_ports", par, state=low, transition=1e5)
    assert added[2] == pytest.approx(-6e-5 * (np.sqrt(0.5) - 1))
    assert added[:4].sum() + added[5] == pytest.approx(added[4])


def test_ripple_and_wandering_levels_are_shares_of_dry_friction(par):
    added, _ = law("bore_ripple", par, share=0.02, period=0.8)  # a quarter wave at 0.2 m
    assert added[2:4] == pytest.approx([0.02 * 300, 0.0], abs=1e-9)
    added, _ = law("friction_level", par, test=0.03, load=-0.01)
    assert added[2:4] == pytest.approx([9.0, -2.5])


def test_lags_follow_and_come_to_rest_where_they_should(par):
    still = STATE.copy()
    still[[AT, AT + 2, AT + 4]] = OPENED
    assert not law("valve_lag", par, state=still, time=3e-3, damping=0.9)[1].any()
    _, rates = law("valve_lag", par, time=3e-3, damping=0.9)
    assert rates[1::2] == pytest.approx(np.multiply((1.8 / 3e-3) ** 2, OPENED))
    _, (rate,) = law("tank_back_pressure", par, "flows", resistance=1e9, lag=0.01)
    assert rate == pytest.approx(1.1e5 / 0.01)


def test_air_makes_the_oil_softer_where_the_pressure_is_lower(par):
    added, _ = law("entrained_air", par, fraction=0.02, dissolved=60e5)
    assert added[0] == 0 and (added[1:] < 0).all()
    assert list(np.argsort(added[1:])) == list(np.argsort(STATE[[P_TP, P_TR, P_LP, P_LR]]))


def test_friction_grows_with_pressure_load_and_speed_in_the_direction_of_its_sign(par):
    more = slice(2, 4)
    high = STATE.copy()
    high[[P_TP, P_LP]] += 20e5
    for name, values in {
        "seal_pressure_friction": {"test": 50.0, "load": 50.0, "exponent": 0.7},
        "load_friction": {"test": 0.03, "load": 0.03, "limit": 8e3},
    }.items():
        low = law(name, par, **values)[0][more]
        assert (law(name, par, state=high, **values)[0][more] > low).all() and (low > 0).all()
    back = STATE.copy()
    back[V] *= -1
    uneven = {"test": 0.1, "load": 0.1, "speed": 0.2}
    out, home = (law("direction_asymmetry", par, state=s, **uneven)[0][more] for s in (STATE, back))
    assert out == pytest.approx([45.0, 37.5], rel=1e-3) and np.array_equal(out, -home)


def test_what_brakes_brakes_and_a_dragged_mass_takes_what_a_rigid_one_does(par):
    end = STATE.copy()
    end[X] = par.test.stroke_m - 0.05
    added, _ = law("end_cushion", par, state=end, damping=1e5, length=0.1)
    assert added[4] == pytest.approx(1e5 * 0.5 * 0.01)
    end[V] *= -1  # away from this end
    assert not law("end_cushion", par, state=end, damping=1e5, length=0.1)[0].any()
    drag = STATE.copy()
    drag[AT] = STATE[V] - 1e-3 * 2.0  # the column lags behind 2 m/s^2
    added, (rate,) = law("added_mass", par, state=drag, test=10.0, load=5.0, time=1e-3)
    assert rate == pytest.approx(2.0) and added[4:] == pytest.approx([20.0, 10.0])


# ---- instruments


def test_instruments_err_as_drawn_and_nothing_else_in_the_log_changes(bench):
    sensors = sensor_parameters(bench.sensors)
    names = [word.name for word in RECORD]
    words = np.full((50, len(names)), 20000, np.uint16)
    words[:, names.index("v")] = np.arange(50) * 100  # 0.2 m/s^2 of 2e-5 m/s
    perfect = replace(
        drawn({}, 1).background,
        **dict.fromkeys(
            ("pressure_offset_pa", "pressure_drift_pa", "pressure_gain"),
            dict.fromkeys(PRESSURES, 0.0),
        ),
        cell_offset_n=0.0,
        cell_gain=0.0,
    )
    hidden = replace(drawn({}, 1), gauge_curvature=0.0, background=perfect)

    def changed(effects, session=0.5):
        return rewritten(words, replace(hidden, effects=effects), sensors, 100.0, session)

    assert np.array_equal(changed({}), words)
    newtons = FRACTION * sensors.per_unit[6]
    force = (20000 / FRACTION - sensors.zero[6]) / sensors.per_unit[6]
    for effects, more in (
        ({"load_cell_offset": {"force": 30.0}}, 30.0),
        ({"load_cell_gain": {"error": 0.02}}, 0.02 * force * (1 + 0.2 * force / 5e3)),
    ):
        difference = changed(effects).astype(float) - words
        assert difference[:, names.index("f_applied")] == pytest.approx(more * newtons, abs=0.51)
        assert not np.delete(difference, names.index("f_applied"), axis=1).any()
    slower = changed({"velocity_filter_lag": {"time": 4e-3}}).astype(float) - words
    assert slower[5:-5, names.index("v")] == pytest.approx(-0.2 * 100, abs=1)
    shown = astray(
        sensors, replace(hidden, effects={"pressure_offset": {"p_tr": 5e4}}), np.zeros(7), 0.5
    )
    counts = shown.per_unit[2] * 50e5 + shown.zero[2]
    assert (counts - sensors.zero[2]) / sensors.per_unit[2] == pytest.approx(50e5 + 5.5e4)
    assert shown.per_unit[3:] == sensors.per_unit[3:] and shown.zero[3:] == sensors.zero[3:]
    small = replace(
        perfect,
        pressure_offset_pa=dict.fromkeys(PRESSURES, 8e3),
        pressure_drift_pa=dict.fromkeys(PRESSURES, -4e3),
        pressure_gain=dict.fromkeys(PRESSURES, 1e-3),
        cell_offset_n=5.0,
        cell_gain=3e-3,
    )
    usual = replace(hidden, background=small)
    for session in (0.0, 0.5, 1.0):
        shown = astray(sensors, usual, np.zeros(7), session)
        for i in range(1, 6):
            counts = shown.per_unit[i] * 50e5 + shown.zero[i]
            value = (counts - sensors.zero[i]) / sensors.per_unit[i]
            assert value == pytest.approx(50e5 + 5e3 + 8e3 - 4e3 * session)
    difference = rewritten(words, usual, sensors, 100.0, 0.5).astype(float) - words
    expected = (5.0 + 3e-3 * force) * newtons
    assert difference[:, names.index("f_applied")] == pytest.approx(expected, abs=0.51)


# ---- plans


def test_the_second_plan_shares_no_operating_point_with_the_first():
    first, second = (
        load_experiment(path, None).plans
        for path in (ROOT / "configs" / "discriminate.yaml", FOLDER / "second.yaml")
    )
    assert {plan.kind for plan in second} == {plan.kind for plan in first}
    assert 100 <= len(second) <= 140

    def values(plans, name):
        return {getattr(plan, name) for plan in plans} - {0.0}

    for name in ("v_ref_m_s", "f_load_n", "p_lr_ref_pa"):
        assert not values(first, name) & values(second, name), name
    starts = [{plan.planned_motion.x_start_m for plan in plans} for plans in (first, second)]
    assert not starts[0] & starts[1]
    for kind in {plan.kind for plan in second}:  # early and late in the campaign
        numbers = [i for i, plan in enumerate(second) if plan.kind == kind]
        assert numbers[0] < len(second) / 3 and numbers[-1] > len(second) * 2 / 3


# ---- campaigns as logs of another bench

STORED = ROOT / "data_samples" / "blind" / "none-5"


def imported_back(source, destination, map_file=None):
    import_folder(source, destination, map_file, {}, datetime(2026, 1, 1, tzinfo=UTC))
    return list(load_campaign(destination).runs())


@pytest.fixture(scope="module")
def stored_runs(bench):
    return [calibrate(raw, bench) for raw in load_campaign(STORED).raw_runs()]


def test_an_index_of_logs_keeps_all_of_a_campaign_but_its_motions(tmp_path, stored_runs):
    write_index(STORED, tmp_path / "logs")
    runs = imported_back(tmp_path / "logs", tmp_path / "campaign")
    for run, source in zip(runs, stored_runs, strict=True):
        assert run.plan == replace(source.plan, motion=None)
        for name, values in channels(source).items():
            assert np.array_equal(getattr(run, name), values), name


def test_logs_with_a_map_keep_kind_speed_load_trial_and_channels(tmp_path, stored_runs):
    """To nine digits, in other units. Each kind is a folder, its runs sorted by file name."""
    write_mapped(STORED, tmp_path / "logs")

    def point(run):
        plan = run.plan
        return plan.kind, plan.v_ref_m_s, plan.f_load_n, plan.trial, len(run.t_s), run.x_m[0]

    sources = sorted(stored_runs, key=point)
    runs = []
    for folder in sorted((tmp_path / "logs").iterdir()):
        runs += imported_back(folder, tmp_path / folder.name, folder / "map.yaml")
    for run, source in zip(sorted(runs, key=point), sources, strict=True):
        assert run.plan.kind == source.plan.kind and run.plan.trial == source.plan.trial
        assert abs(run.plan.v_ref_m_s) == pytest.approx(abs(source.plan.v_ref_m_s))
        if run.plan.kind == "steady":  # of a triangle both directions are as fast
            assert run.plan.v_ref_m_s == pytest.approx(source.plan.v_ref_m_s)
        assert run.plan.f_load_n == pytest.approx(source.plan.f_load_n)
        for name, values in channels(source).items():
            if name not in RUN_FLAGS:
                assert getattr(run, name) == pytest.approx(values, rel=1e-8, abs=1e-9), name


# ---- campaigns, in a process of their own

PLAN = """
name: blind
bench: {bench}
experiments:
  - kind: steady
    direction: extend
    p_lr: 15 bar
    loads: [2000 N]
    velocities: [60 mm/s, 120 mm/s]
    trials: 3
    order: passes
    travel: {{start: 60 mm, end: 330 mm}}
    acceleration: 1 m/s^2
    hold: 0.2 s
    window: 1 s
"""


def written(folder, cases):
    """Return the campaigns of the cases that ``cases`` names, made by the command."""
    plan = folder / "plan.yaml"
    plan.write_text(PLAN.format(bench=BENCH))
    arguments = (folder / "out", "--cases", cases, "--schedule", plan)
    subprocess.run(
        [sys.executable, FOLDER / "generate.py", *map(str, arguments)],
        check=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    made = sorted(path for path in (folder / "out").iterdir() if path.is_dir())
    return {path.name: load_campaign(path) for path in made}


@pytest.mark.slow
def test_the_command_writes_campaigns_that_do_not_tell_what_is_hidden(tmp_path, bench):
    """A droop shows in the supply of no other campaign, and a seed repeats itself."""
    made = written(tmp_path, "small")
    assert set(made) == {case.name for case in small_sample()}
    sag = {}
    for name, campaign in made.items():
        runs = [calibrate(raw, bench) for raw in campaign.raw_runs()]
        assert len(runs) == 6 and all(run.plan.trial in (1, 2, 3) for run in runs)
        assert campaign.bench() == bench and not bench.effects
        text = (tmp_path / "out" / name / "campaign.yaml").read_text()
        assert "hidden" not in text and "droop" not in text
        sag[name] = np.mean([bench.supply.pressure - run.p_s_pa[50:].mean() for run in runs])
    drooping = sag.pop("supply_droop-clear-2")
    assert drooping > 0.5e5 and max(map(abs, sag.values())) < 0.3e5  # of the transducer's class
    again = tmp_path / "again"
    again.mkdir()
    for name, campaign in written(again, "small").items():
        for one, other in zip(campaign.raw_runs(), made[name].raw_runs(), strict=True):
            assert np.array_equal(one.words, other.words)
