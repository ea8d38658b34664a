"""Hypotheses and their columns' products, against plain algebra and a plant file's reading."""

import numpy as np
import pytest

from hbench.config.bench import parse_plant
from hbench.model.build import plant_parameters
from hbench.model.effects.catalogue import EFFECTS, read_effects
from hbench.reconcile.gaps.columns import column_difference, mean_column
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.hypothesis import (
    Hypothesis,
    effect_coefficients,
    shape_coefficients,
    typical_size,
)
from hbench.reconcile.linearised import (
    MOTIONS,
    LinearisedModel,
    _products,
    _scatter_at,
    hypothesis_at,
    window_motions,
)
from hbench.reconcile.measured.balances import WindowedRun
from hbench.reconcile.nuisance import nuisances
from hbench.reconcile.signatures import disjoint_groups, signature
from hbench.records import RunPlan, Specimen
from tests.support.reconcile.rounds import plant_of

NAMES = ("flow_tp", "flow_tr", "supply")
LEAK = ("internal_leakage", "test")
DROOP = ("supply_droop", "slope")


def a_map(rng, lengths=(7, 5, 9), v_m_s=None):
    w = sum(lengths)
    difference = rng.standard_normal((w, 3))
    difference[rng.random((w, 3)) < 0.2] = np.nan
    at = np.zeros(w)
    return GapMap(
        names=NAMES,
        difference=difference,
        scatter=rng.uniform(0.5, 2, (w, 3)),
        noise=rng.uniform(0.1, 0.3, (w, 3)),
        t_s=at,
        x_m=at,
        v_m_s=rng.choice([0.0, 0.1], w) if v_m_s is None else np.asarray(v_m_s),
        load_n=at,
        point=np.repeat(np.arange(len(lengths)), lengths),
        points=tuple("abcdef"[: len(lengths)]),
    )


def linear(hypothesis=None, lacking=None):
    return LinearisedModel(hypothesis or Hypothesis(), (), lacking, None, None)


# ---- columns


def test_products_are_those_of_the_windows_that_are_compared():
    """By hand, a window at a time; a column may be shorter than its point, or not there."""
    rng = np.random.default_rng(1)
    found = a_map(rng)
    found.noise[3, :2] = np.nan  # where the other simulation has no window
    columns = {
        "one": {
            point: rng.standard_normal((n, 3)) for point, n in zip("abc", (7, 4, 12), strict=True)
        },
        "two": {"b": rng.standard_normal((5, 3))},
    }
    data = _products(found, (found.scatter, found.noise), columns)
    motion, starts = window_motions(found), (0, 7, 12)
    expected = np.zeros((3, 9, 3, 3))
    noise, windows = np.zeros((3, 9)), np.zeros((3, 9))
    for w in range(21):
        p = int(found.point[w])
        for c in range(3):
            if not np.isfinite(found.difference[w, c] + found.noise[w, c]):
                continue
            row = [found.difference[w, c]]
            for column in columns.values():
                own = column.get("abc"[p], np.zeros((0, 3)))
                k = w - starts[p]
                row.append(own[k, c] if k < len(own) else 0.0)
            row = np.array(row) / found.scatter[w, c]
            group = c * len(MOTIONS) + motion[w]
            expected[p, group] += np.outer(row, row)
            noise[p, group] += found.noise[w, c] / found.scatter[w, c] ** 2
            windows[p, group] += 1
    assert data.squares == pytest.approx(expected[:, :, 0, 0])
    assert data.mixed == pytest.approx(expected[:, :, 0, 1:])
    assert data.columns == pytest.approx(expected[:, :, 1:, 1:])
    assert data.noise == pytest.approx(noise)
    assert np.array_equal(data.windows, windows)
    assert data.names == ("one", "two")
    assert data.groups[4] == ("flow_tr", MOTIONS[1])


def test_windows_are_at_rest_steady_or_unsteady():
    """By the change from the window before to the one after; edges are like their neighbours."""
    v = [0, 0, 0, 0.05, 0.1, 0.1, 0.1, 0.1] + [-0.1] * 4 + [0.1, 0.1, 0.05, 0.0, 0.0, 0.0]
    found = window_motions(a_map(np.random.default_rng(2), (8, 4, 6), v))
    assert "".join(MOTIONS[k][0] for k in found) == "rruuusssssssuuuurr"


def test_a_single_window_moves_as_fast_as_it_is_whatever_its_neighbours_do():
    rng = np.random.default_rng(3)
    assert len(window_motions(a_map(rng, ()))) == 0
    found = window_motions(a_map(rng, (1, 3, 1), [0.1, 0.0, 0.05, 0.1, 0.0]))
    assert [MOTIONS[k] for k in found] == ["steady", *["unsteady"] * 3, "rest"]


def test_scatters_of_another_map_stand_at_the_windows_of_the_same_point():
    """Where there are fewer, the last of the point goes on; points may come in another order."""
    rng = np.random.default_rng(4)
    unit = a_map(rng, (4, 3))
    other = GapMap(**{**a_map(rng, (2, 6)).__dict__, "points": ("b", "a")})
    scatter, noise = _scatter_at(unit, other)
    rows = [4, 5, 0, 1, 2, 3, 3, 3]
    assert np.array_equal(scatter, unit.scatter[rows])
    assert np.array_equal(noise, unit.noise[rows])


def trial(speed, values, names=NAMES):
    plan = RunPlan("0001", "steady", 1, speed, Specimen(1e-3, 8e-4))
    at = np.arange(len(values), dtype=float)
    return WindowedRun(plan, names, np.asarray(values, float), at, at, at, at, np.zeros(len(names)))


def test_columns_are_means_of_trials_and_differ_where_both_have_windows():
    rng = np.random.default_rng(5)
    first, second, other = rng.standard_normal((6, 3)), rng.standard_normal((4, 3)), np.ones((2, 3))
    slow, fast = (
        mean_column([trial(0.1, first), trial(0.1, second), trial(0.2, other)]),
        mean_column([trial(0.1, np.ones((9, 3)))]),
    )
    (point,) = fast
    assert slow[point] == pytest.approx((first[:4] + second) / 2)
    assert column_difference(slow, fast).keys() == {point}
    assert column_difference(slow, fast)[point] == pytest.approx((first[:4] + second) / 2 - 1)


# ---- signatures


def test_packed_effects_share_no_balance_and_none_is_lost():
    wanted = [one for name in EFFECTS for one in effect_coefficients(name)]
    groups = disjoint_groups(wanted)
    assert sorted(one for group in groups for one in group) == sorted(wanted)
    assert len(groups) < 0.75 * len(wanted)
    for group in groups:
        touched = [balance for name, _ in group for balance in EFFECTS[name].balances]
        assert len(set(touched)) == len(touched)


def test_a_signature_is_the_change_in_the_effects_own_balances_where_it_is_seen():
    """supply_droop touches supply alone; internal_leakage the flows, if noise does not hide it."""
    rng = np.random.default_rng(6)
    base = [trial(0.1, 0.01 * rng.standard_normal((40, 3))) for _ in range(3)]
    change = np.array([0.5, 0.0, -2.0])
    made = [trial(0.1, change + 0.01 * rng.standard_normal((40, 3)))]
    (droop,) = signature("supply_droop", made, base).values()
    (leak,) = signature("internal_leakage", made, base).values()
    assert droop[:, 2] == pytest.approx(-2.0, abs=0.1) and not droop[:, :2].any()
    assert leak[:, 0] == pytest.approx(0.5, abs=0.1) and not leak[:, 1:].any()


# ---- hypotheses


def test_coefficients_switch_effects_on_and_shapes_do_not(bench):
    """Over all rows: an effect with its shapes alone is no effect at all."""
    plain = plant_parameters(bench)
    for name, row in EFFECTS.items():
        switches, forms = effect_coefficients(name), shape_coefficients(name)
        assert {key for _, key in (*switches, *forms)} == set(row.coefficients)
        assert switches and not set(switches) & set(forms)
        assert all(typical_size(one) > 0 for one in (*switches, *forms))
    only = Hypothesis().with_coefficients({("internal_leakage", "exponent"): 0.5})
    par = plant_parameters(only.plant(plant_of(bench)))
    assert par._replace(effects=None) == plain
    assert typical_size(LEAK) == pytest.approx(3e-3 * 1e-3 / 60 / 1e5)
    assert typical_size(("internal_leakage", "exponent")) == 0.25


def test_a_hypothesis_is_the_plant_that_its_sections_read_as(bench, bench_data):
    """Through a plant file's reading: the same coefficients in SI, the same factors."""
    hypothesis = Hypothesis({"oil.bulk_modulus": 1.1, "friction.test.coulomb": 0.9})
    hypothesis = hypothesis.with_coefficients({LEAK: 7.654321e-13, DROOP: 1.2345678e9})
    plant = hypothesis.plant(plant_of(bench))
    assert plant.oil.bulk_modulus == pytest.approx(1.1 * bench.oil.bulk_modulus)
    read = parse_plant(bench_data, {"effects": hypothesis.section()}, "model.yaml")
    for own in (plant, read):
        assert read_effects(own.effects)["internal_leakage"]["test"] == pytest.approx(
            7.654321e-13, rel=1e-8
        )
        assert read_effects(own.effects)["supply_droop"]["slope"] == pytest.approx(
            1.2345678e9, rel=1e-8
        )
    assert plant_of(bench).effects == {}


def test_every_coefficient_survives_a_plant_files_reading(bench, bench_data):
    for name, row in EFFECTS.items():
        values = {
            (name, key): row.coefficients[key].to_si(row.coefficients[key].high) / 3
            for key in row.coefficients
        }
        section = Hypothesis().with_coefficients(values).section()
        read = read_effects(parse_plant(bench_data, {"effects": section}, "model").effects)
        for (_, key), value in values.items():
            assert read[name][key] == pytest.approx(value, rel=1e-8)


def test_effects_of_the_plant_that_was_given_stay_beside_those_of_the_hypothesis(bench_data):
    given = parse_plant(
        bench_data,
        {"effects": {"load_cell_gain": {"error": "1 %"}, "supply_droop": {"slope": "1 bar min/l"}}},
        "model",
    )
    found = read_effects(Hypothesis().with_coefficients({DROOP: 0.0}).plant(given).effects)
    assert found["load_cell_gain"]["error"] == pytest.approx(0.01)
    assert found["supply_droop"]["slope"] == 0.0


def test_steps_are_taken_in_priors_and_typical_sizes(bench):
    """A factor moves by exp(prior * step), a coefficient by its typical size."""
    plant = plant_of(bench)
    priors = nuisances(plant)
    paths = list(priors)
    start = linear(Hypothesis({paths[0]: 1.2}).with_coefficients({LEAK: 1e-12}))
    beta = np.linspace(-1, 1, len(paths) + 2)
    found = hypothesis_at(start, plant, (LEAK, DROOP), beta)
    for path, step in zip(paths, beta, strict=False):
        before = 1.2 if path == paths[0] else 1.0
        assert found.factors[path] == pytest.approx(before * np.exp(priors[path] * step))
    assert found.coefficient(LEAK) == pytest.approx(1e-12 + beta[-2] * typical_size(LEAK))
    assert found.coefficient(DROOP) == pytest.approx(beta[-1] * typical_size(DROOP))
    assert start.hypothesis.coefficient(LEAK) == 1e-12
