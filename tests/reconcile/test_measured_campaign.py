"""Residuals and columns along the logs of a campaign: columns are the residuals' derivatives."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.config.bench import parse_plant
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile import measured_campaign
from hbench.reconcile.hypothesis import Hypothesis, effect_coefficients, typical_size
from hbench.reconcile.linearised import hypothesis_at, linearise
from hbench.reconcile.measured.along import ALL_PARTS
from hbench.reconcile.measured.balances import BALANCES, FORCES, balance_model, balance_values
from hbench.reconcile.measured.session import sessions
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.nuisance import nuisances
from hbench.records.reconcile.diagnosis import REST_M_S
from tests.support.reconcile.exact_logs import INSTRUMENTS, logged_points

# What the bench has and the model does not: residuals are not 0, and nothing is symmetric.
HIDDEN = {"effects": {"internal_leakage": {"test": "2e-3 l/min/bar"}}}
MATERIAL = 0.002


@pytest.fixture(scope="module")
def runs(bench_data):
    """Three operating points, two trials each; the second trial differs a little."""
    par = balance_model(None, parse_plant(bench_data, HIDDEN, "")).par
    return logged_points(par, (1.0, 0.7, 1.2))


@pytest.fixture(scope="module")
def campaign(bench, bench_data, runs):
    plant = parse_plant(bench_data, {}, "")
    return MeasuredCampaign(bench, plant, INSTRUMENTS, sessions(runs), MATERIAL)


COLUMNS = [
    "/valve.gain",
    "/valve.bandwidth",
    "/oil.bulk_modulus",
    "/test_cylinder.dead_volume_rod",
    "/moving_mass.load",
    "/friction.test.coulomb",
    "/friction.load.viscous",
    "valve_lag.time",
    "valve_deadband.test",
    "valve_trim.gain_test",
    "valve_trim.null_load_1",
    "valve_trim.exponent",
    "tank_back_pressure.resistance",
    "supply_droop.slope",
    "internal_leakage.test",
    "external_leakage.lr",
    "entrained_air.fraction",
    "seal_pressure_friction.test_rod",
    "friction_lag.time",
    "presliding.force",
    "oil_warming.pump",
    "added_mass.test",
    "load_cell_gain.error",
    "load_cell_offset.force",
    "pressure_offset.p_lp",
    "pressure_gain.p_tp",
    "velocity_filter_lag.time",
]


@pytest.mark.parametrize("name", COLUMNS)
def test_a_column_is_what_a_step_takes_off_the_residuals(campaign, name):
    """A step of a tenth: residuals - step * column, within 10 % of the change; signs included."""
    columns = campaign.columns(Hypothesis(), [name])
    model = linearise(campaign, Hypothesis(), columns)
    step = 0.1
    stepped = hypothesis_at(model, campaign.plant, [0], np.array([step]))
    scale = model.gap_map.scatter
    before, after = (
        np.nan_to_num(campaign.gap_map(each).difference / scale) for each in (Hypothesis(), stepped)
    )
    taken = step * np.nan_to_num(columns[name] / scale)
    assert np.linalg.norm(taken) > 0
    for i, balance in enumerate(BALANCES):
        change = before[:, i] - after[:, i]
        wrong = np.linalg.norm(change - taken[:, i])
        assert wrong <= 0.1 * np.linalg.norm(change) + 1e-6 * np.linalg.norm(taken), balance


@pytest.mark.parametrize("acting", [(), ("supply_droop", "presliding"), ("oil_warming",)])
def test_a_column_by_the_laws_that_it_changes_is_the_one_by_all_laws(campaign, monkeypatch, acting):
    """States of effects that act belong to flows, to friction, or to both, which they connect."""
    at = campaign.start.with_coefficients(
        {which: typical_size(which) for name in acting for which in effect_coefficients(name)}
    )
    names = [*campaign.nuisance_columns, *COLUMNS]
    own = campaign.columns(at, names)
    monkeypatch.setattr(measured_campaign, "parts_of", lambda name: ALL_PARTS)
    for name, column in campaign.columns(at, names).items():
        size = np.nan_to_num(np.abs(column)).max(axis=0)
        assert np.array_equal(np.isnan(own[name]), np.isnan(column))
        assert (np.nan_to_num(np.abs(own[name] - column)) <= 1e-6 * size).all(), name


def test_the_hidden_effects_column_fits_the_residuals_of_the_plant_that_has_it(campaign):
    """2e-3 of a typical 3e-3 l/min/bar: a factor of 2/3, and hardly anything is left."""
    column = campaign.columns(Hypothesis(), ["internal_leakage.test"])["internal_leakage.test"]
    d = campaign.gap_map(Hypothesis()).difference
    flows = [BALANCES.index("flow_tp"), BALANCES.index("flow_tr")]
    c, d = column[:, flows].ravel(), d[:, flows].ravel()
    factor = c @ d / (c @ c)
    assert factor == pytest.approx(2 / 3, rel=0.02)
    assert np.linalg.norm(d - factor * c) < 0.1 * np.linalg.norm(d)


def test_columns_about_a_hypothesis_are_those_at_its_coefficients(campaign):
    """A leak with a root's exponent: its derivative there, not at the default."""
    which = ("internal_leakage", "test")
    at = Hypothesis().with_coefficients({which: 5e-13, ("internal_leakage", "exponent"): 0.5})
    name = "internal_leakage.test"
    here, there = (campaign.columns(each, [name])[name] for each in (at, Hypothesis()))
    p_tp, p_tr = (
        campaign.logs[0].mean(campaign.logs[0].channels[f]) for f in ("p_tp_pa", "p_tr_pa")
    )
    drop = p_tp - p_tr
    expected = np.sign(drop) * np.sqrt(np.abs(drop) * 50e5) / drop  # the same at 50 bar
    middle = np.abs(drop) > 3e5
    ratio = here[middle, 0] / there[middle, 0]
    assert ratio == pytest.approx(expected[middle], rel=0.06)


def test_effects_change_the_balances_of_their_rows_alone(campaign):
    """Columns of other balances are set to 0; here the residuals themselves, all effects at once
    at their typical sizes."""
    before = campaign.gap_map(Hypothesis()).difference
    sought = {name: row for name, row in EFFECTS.items() if row.balances}
    for name, row in sought.items():
        values = {
            which: EFFECTS[name]
            .coefficients[which[1]]
            .to_si(EFFECTS[name].coefficients[which[1]].typical)
            for which in effect_coefficients(name)
        }
        after = campaign.gap_map(Hypothesis().with_coefficients(values)).difference
        changed = {
            balance
            for i, balance in enumerate(BALANCES)
            if np.nanmax(np.abs(after - before)[:, i]) > 1e-9 * np.nanmax(np.abs(before[:, i]))
        }
        assert changed <= set(row.balances), name
        assert changed or name == "end_cushion", name  # no stroke comes near an end


def test_columns_of_several_samplings_follow_one_another(campaign, runs, bench):
    """Windows of the second session come after all of the first, as those of the map."""
    slow = tuple(
        replace(
            run,
            **{
                name: value.reshape(-1, 2).mean(axis=1)
                for name, value in vars(run).items()
                if isinstance(value, np.ndarray) and value.shape == run.t_s.shape
            },
        )
        for run in runs[2:4]
    )
    both = MeasuredCampaign(
        bench, campaign.plant, INSTRUMENTS, sessions([*runs[:2], *slow]), MATERIAL
    )
    assert len(both.logs) == 2
    found = both.gap_map(Hypothesis())
    assert np.array_equal(np.unique(found.run), range(4)) and np.all(np.diff(found.run) >= 0)
    assert np.array_equal(found.point, np.repeat((0, 1), np.bincount(found.point)))
    column = both.columns(Hypothesis(), ["/valve.gain"])["/valve.gain"]
    whole = campaign.columns(Hypothesis(), ["/valve.gain"])["/valve.gain"]
    first = len(column) // 2
    assert column[:first] == pytest.approx(whole[:first], nan_ok=True, rel=1e-6, abs=1e-9)
    assert column[first:, 0] == pytest.approx(whole[first : 2 * first, 0], rel=0.1, abs=1e-6)


# ---- what the map knows


def test_residuals_of_the_map_are_those_of_the_balances_and_no_forces_at_rest(campaign):
    hypothesis = Hypothesis({"valve.gain": 1.1})
    model = campaign.balance_model(hypothesis)
    values = np.concatenate([balance_values(log, model) for log in campaign.logs])
    found = campaign.gap_map(hypothesis)
    moving = np.abs(found.v_m_s) >= REST_M_S
    assert 0 < moving.sum() < len(moving)
    for i, name in enumerate(BALANCES):
        compared = moving if name in FORCES else np.ones_like(moving)
        own = np.where(compared, values[:, i], np.nan)
        assert np.array_equal(found.difference[:, i], own, equal_nan=True)
    assert model.par.valve.flow_gain == pytest.approx(
        1.1 * campaign.balance_model(Hypothesis()).par.valve.flow_gain
    )


def test_material_deviations_are_a_share_of_what_a_balance_is_made_of(campaign):
    """In scatters: 0.2 % of area times largest speed, of the largest force, and of 150 bar."""
    found = campaign.gap_map(Hypothesis())
    (log,), par = campaign.logs, campaign.balance_model(Hypothesis()).par
    sizes = dict(zip(BALANCES, found.material * found.scatter[0], strict=True))
    speed = np.abs(log.velocity_m_s).max()
    force = np.abs(log.channels["f_applied_n"]).max()
    assert sizes["flow_tp"] == pytest.approx(MATERIAL * par.test.area_piston_m2 * speed)
    assert sizes["flow_lr"] == pytest.approx(MATERIAL * par.load.area_rod_m2 * speed)
    assert sizes["force_load"] == pytest.approx(MATERIAL * force)
    assert sizes["supply"] == pytest.approx(MATERIAL * 150e5)


def test_each_run_has_a_level_of_friction_in_both_force_balances(campaign):
    """A model whose dry friction is 4 % higher: the residual falls by the level's change."""
    found = campaign.gap_map(Hypothesis())
    force = [BALANCES.index(name) for name in ("force_test", "force_load")]
    assert [level.balance for level in found.levels] == [force[0]] * 6 + [force[1]] * 6
    covered = np.zeros((len(found.run), len(BALANCES)))
    for level in found.levels:
        covered[level.windows, level.balance] += 1
        assert len(np.unique(found.run[level.windows])) == 1
    assert np.array_equal(covered.any(axis=0), np.isin(range(len(BALANCES)), force))
    assert np.all(covered[:, force] == 1)
    model = campaign.balance_model(Hypothesis())
    raised = replace(model, levels=(1.04, 1.04))
    change = (
        np.concatenate([balance_values(log, raised) - balance_values(log, model)
                        for log in campaign.logs]) / found.scatter
    )  # fmt: skip
    for level in found.levels:
        compared = np.isfinite(found.difference[level.windows, level.balance])  # not at rest
        own = np.where(compared, change[level.windows, level.balance], 0.0)
        assert np.linalg.norm(level.change - own) < 0.02 * np.linalg.norm(own)
        assert level.ridge == 1.0


def test_a_level_of_friction_that_a_run_has_is_hardly_a_gap(bench, bench_data, campaign):
    """Each run has its own dry friction, off by 4 %: without levels most of it would be left."""
    hypothesis = Hypothesis()
    found = campaign.gap_map(hypothesis)
    made = np.zeros_like(found.difference)
    for number, level in enumerate(found.levels):
        sign = (-1) ** (number // 2)
        made[level.windows, level.balance] = (
            sign * level.change * found.scatter[level.windows, level.balance]
        )

    class Shifted:
        plant, tolerances = campaign.plant, campaign.tolerances

        def __init__(self, levels):
            self.levels = levels

        def gap_map(self, hypothesis, reference=None):
            return replace(found, difference=made, levels=self.levels, white=None)

    def squares(levels):
        return linearise(Shifted(levels), hypothesis, {}).data.squares.sum()

    with_levels, without = squares(found.levels), squares(())
    sizes = [level.change @ level.change for level in found.levels]
    assert without == pytest.approx(sum(sizes))
    assert with_levels == pytest.approx(sum(size / (1 + size) for size in sizes))


def test_a_reference_gives_the_scatter_and_the_levels_and_nothing_else(campaign):
    """In its units the residuals of a hypothesis are those that it has for itself."""
    reference = campaign.gap_map(Hypothesis())
    other = Hypothesis(factors={"valve.gain": 1.2})
    found, own = campaign.gap_map(other, reference), campaign.gap_map(other)
    assert np.array_equal(found.difference, own.difference, equal_nan=True)
    assert not np.array_equal(own.scatter, reference.scatter, equal_nan=True)
    for name in ("scatter", "noise", "white", "material", "levels", "run", "point"):
        assert getattr(found, name) is getattr(reference, name)


def test_the_search_starts_with_all_coefficients_that_have_a_tolerance(bench_data, campaign, bench):
    """At their defaults, or at those of the plant file; the others are not there."""
    start = campaign.start
    assert set(start.effects) == {effect for effect, _ in campaign.tolerances}
    assert set(start.effects) == {
        *("valve_trim", "valve_asymmetry", "valve_deadband", "pressure_offset", "pressure_gain"),
        *("load_cell_gain", "load_cell_offset"),
    }
    for effect, values in start.effects.items():
        assert set(values) == set(EFFECTS[effect].coefficients)
        assert not any(values.values())
    given = parse_plant(bench_data, {"effects": {"pressure_offset": {"p_tr": "0.3 bar"}}}, "")
    other = replace(campaign, plant=given).start
    assert other.coefficient(("pressure_offset", "p_tr")) == pytest.approx(0.3e5)
    assert other.coefficient(("pressure_offset", "p_tp")) == 0.0
    plain = campaign.gap_map(Hypothesis()).difference
    assert campaign.gap_map(start).difference == pytest.approx(plain, nan_ok=True)


def test_tolerances_of_readings_are_those_of_the_largest_ones(campaign):
    """Force: of the reading; pressure: of full scale."""
    force = np.abs(campaign.logs[0].channels["f_applied_n"]).max()
    assert campaign.tolerances["load_cell_offset", "force"] == pytest.approx(0.01 * force)
    assert campaign.tolerances["pressure_offset", "p_tp"] == pytest.approx(0.5e5)
    of_reading = INSTRUMENTS.model_copy(
        update={"pressure": INSTRUMENTS.pressure.model_copy(update={"of": "reading"})}
    )
    largest = max(campaign.logs[0].channels["p_s_pa"])
    found = replace(campaign, instruments=of_reading).tolerances
    assert found["pressure_offset", "p_tp"] == pytest.approx(0.002 * largest)


def test_all_factors_of_the_plant_have_a_column(campaign):
    """Each changes some balance; a nuisance without a column could not be refitted."""
    names = [f"/{path}" for path in nuisances(campaign.plant)]
    columns = campaign.columns(Hypothesis(), names)
    assert list(columns) == names
    for name, column in columns.items():
        assert np.nanmax(np.abs(column)) > 0, name


def test_a_tolerance_is_about_the_value_that_the_model_states(bench, bench_data, runs):
    """Load valves of another size: 38 % less gain than that of the test valve."""
    stated = {"effects": {"valve_trim": {"gain_load_1": "-38 %"}}}
    plant = parse_plant(bench_data, stated, "")
    campaign = MeasuredCampaign(bench, plant, INSTRUMENTS, sessions(runs), MATERIAL)
    names = ["valve_trim.gain_load_1", "valve_trim.gain_test"]
    model = linearise(campaign, campaign.start, campaign.columns(campaign.start, names))
    found = hypothesis_at(model, plant, [0, 1], model.tight.low)
    assert found.effects["valve_trim"]["gain_load_1"] == pytest.approx(-0.38 - 0.1 * 0.62)
    assert found.effects["valve_trim"]["gain_test"] == pytest.approx(-0.10)
