"""Linearised models: products, priors and hypotheses, against plain algebra."""

from dataclasses import dataclass, field, replace
from math import sqrt

import numpy as np
import pytest

from hbench.config.bench import Plant, parse_plant
from hbench.model.build import plant_parameters
from hbench.model.effects.catalogue import EFFECTS, read_effects
from hbench.reconcile.estimates import ParameterEstimates
from hbench.reconcile.evidence.likelihood import likeliest, maximum_likelihood
from hbench.reconcile.evidence.window_sums import (
    GROUPS,
    MOTIONS,
    _take_out,
    is_change,
    products,
    window_motions,
)
from hbench.reconcile.gaps.gap_map import GapMap, RunLevel
from hbench.reconcile.gaps.log_map import Windows, log_map
from hbench.reconcile.hypothesis import (
    Hypothesis,
    effect_coefficients,
    shape_coefficients,
    typical_size,
)
from hbench.reconcile.linearised import hypothesis_at, linearise, linearise_residuals
from hbench.reconcile.nuisance import BOUND, nuisances
from tests.support.reconcile.products import all_products
from tests.support.reconcile.rounds import plant_of

NAMES = ("flow_tp", "flow_tr", "supply")
LEAK = ("internal_leakage", "test")
DROOP = ("supply_droop", "slope")
NULL = ("valve_trim", "null_test")


def a_map(rng, lengths=(7, 5, 9), v_m_s=None):
    """Runs of these lengths, each at an operating point of its own."""
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
        point=(point := np.repeat(np.arange(len(lengths)), lengths)),
        points=tuple("abcdef"[: len(lengths)]),
        run=point,
    )


@dataclass(frozen=True)
class Made:
    """Measurement of a map that is the same for every hypothesis."""

    plant: Plant
    map: GapMap
    tolerances: dict
    start: Hypothesis = field(default_factory=Hypothesis)

    def gap_map(self, hypothesis, reference=None):
        return self.map if reference is None else self.map.in_units_of(reference)

    def columns(self, hypothesis, names):
        return {name: np.ones_like(self.map.difference) for name in names}


@pytest.fixture
def measured(bench):
    """Tolerance of the test valve's null: 0.2 V, which is four typical sizes."""
    return Made(plant_of(bench), a_map(np.random.default_rng(9)), {NULL: 0.2})


def model_of(measured, names, hypothesis=None):
    hypothesis = hypothesis or Hypothesis()
    return linearise(measured, hypothesis, measured.columns(hypothesis, names))


# ---- products


def test_products_are_those_of_the_windows_that_are_compared():
    """By hand, a window at a time; a column without a number is a column without a change."""
    rng = np.random.default_rng(1)
    found = a_map(rng)
    found.noise[3, :2] = np.nan
    columns = {name: rng.standard_normal((21, 3)) for name in ("one", "two")}
    columns["one"][11] = np.nan
    data = products(found, columns)
    motion = window_motions(found)
    groups = 3 * len(GROUPS)
    expected = np.zeros((3, groups, 3, 3))
    noise, windows = np.zeros((3, groups)), np.zeros((3, groups))
    for w in range(21):
        p = int(found.point[w])
        for c in range(3):
            if not np.isfinite(found.difference[w, c] + found.noise[w, c]):
                continue
            row = [found.difference[w, c]]
            row += [np.nan_to_num(column[w, c]) for column in columns.values()]
            row = np.array(row) / found.scatter[w, c]
            group = c * len(GROUPS) + motion[w]
            expected[p, group] += np.outer(row, row)
            noise[p, group] += found.noise[w, c] / found.scatter[w, c] ** 2
            windows[p, group] += 1
    assert data.squares == pytest.approx(expected[:, :, 0, 0])
    assert data.mixed == pytest.approx(expected[:, :, 0, 1:])
    assert all_products(data.columns) == pytest.approx(expected[:, :, 1:, 1:])
    assert data.noise == pytest.approx(noise)
    assert np.array_equal(data.windows, windows)
    assert data.names == ("one", "two")
    assert data.groups[len(GROUPS) + 1] == ("flow_tr", MOTIONS[1])


def test_known_products_of_columns_serve_other_residuals():
    """Of a map with levels and changes: as if all were computed again, also over some points."""
    found = unsteady_map(np.random.default_rng(20))
    rng = np.random.default_rng(21)
    columns = {name: rng.standard_normal(found.difference.shape) for name in ("one", "two")}
    change = rng.standard_normal(12)
    found = replace(found, levels=(RunLevel(slice(0, 12), 0, change, 1.0),))
    other = replace(found, difference=found.difference + 0.3 * columns["one"])
    known = products(found, columns)
    part = known.part(np.array([0, 2]))
    known.summed_columns(part)
    again, anew = products(other, columns, known), products(other, columns)
    for name in ("mixed", "squares", "noise", "windows"):
        np.testing.assert_allclose(getattr(again, name), getattr(anew, name), atol=1e-12)
    np.testing.assert_allclose(all_products(again.columns), all_products(anew.columns))
    beta = np.array([[[0.3, -2.0]]])
    sums = [each.summed_columns(part).squares(beta) for each in (again, anew)]
    np.testing.assert_allclose(*sums)
    assert not np.allclose(known.mixed, again.mixed)


def test_windows_are_at_rest_steady_unsteady_or_reversing():
    """By the change from the window before to the one after; edges are like their neighbours."""
    v = [0, 0, 0, 0.05, 0.1, 0.1, 0.1, 0.1] + [-0.1] * 4 + [0.1, 0.1, 0.05, 0.0, 0.0, 0.0]
    found = window_motions(a_map(np.random.default_rng(2), (8, 4, 6), v))
    assert "".join(MOTIONS[k][0] for k in found) == "rruuusssssssuuuurr"
    v = [0.1, 0.1, 0.1, -0.1, -0.1, -0.1]
    found = window_motions(a_map(np.random.default_rng(2), (6,), v))
    assert [MOTIONS[k] for k in found[1:5]] == ["steady", "reversing", "reversing", "steady"]


def test_a_single_window_moves_as_fast_as_it_is_whatever_its_neighbours_do():
    rng = np.random.default_rng(3)
    assert len(window_motions(a_map(rng, ()))) == 0
    found = window_motions(a_map(rng, (1, 3, 1), [0.1, 0.0, 0.05, 0.1, 0.0]))
    assert [MOTIONS[k] for k in found] == ["steady", *["unsteady"] * 3, "rest"]
    found = window_motions(a_map(rng, (3, 1, 3), [0.1] * 4 + [0.0] * 3))
    assert [MOTIONS[k] for k in found] == ["steady"] * 4 + ["rest"] * 3


# ---- runs measured window by window


SIGMA, BETWEEN, RUNS, PER_RUN = 2.0, 0.0, 60, 40


def noise_map(rng, between=BETWEEN, shift=0.0, material=None, levels=()):
    """Map of 20 points of three runs: white windows, runs whose means differ by ``between``."""
    run = np.repeat(np.arange(RUNS), PER_RUN)
    values = SIGMA * rng.standard_normal((RUNS * PER_RUN, 1)) + shift
    values += between * rng.standard_normal(RUNS)[run][:, None]
    at, v = np.zeros(len(run)), np.where(run % 2, 0.1, -0.1)
    windows = Windows(run, tuple(i // 3 for i in range(RUNS)), at, at, v, at)
    made = log_map(windows, ("flow_tp",), values, np.zeros(1))
    return replace(made, material=material, levels=levels)


def sums(found):
    """Sums over all windows, in squares of the noise of a window: squares, least variance."""
    data = products(found, {})
    unit = (SIGMA / found.scatter[0, 0]) ** 2 * RUNS * PER_RUN
    values = slice(len(MOTIONS))
    return data.squares[:, values].sum() / unit, data.noise[:, values].sum() / unit


def test_squares_without_noise_are_unbiased():
    """White noise leaves 0 but for a few per cent, its own squares would be 1; a shift stays."""
    for shift in (0.0, 0.5 * SIGMA, 3 * SIGMA):
        left = [sums(noise_map(np.random.default_rng(seed), 0.0, shift))[0] for seed in range(20)]
        assert np.mean(left) == pytest.approx((shift / SIGMA) ** 2, abs=0.1)


def test_the_least_variance_is_the_chance_of_the_noises_own_squares():
    """sqrt(2 / n) of n white windows; their sum of squares scatters by as much."""
    found = [sums(noise_map(np.random.default_rng(seed))) for seed in range(60)]
    chance = sqrt(2 / (RUNS * PER_RUN))
    between = 1 / PER_RUN  # of means of white windows
    assert np.mean([least for _, least in found]) == pytest.approx(chance + between, rel=0.1)
    assert np.std([left for left, _ in found]) < 4 * chance


def test_what_changes_from_run_to_run_is_no_gap():
    found = [sums(noise_map(np.random.default_rng(seed), SIGMA)) for seed in range(20)]
    squares, least = np.mean(found, axis=0)
    assert squares == pytest.approx(1.0, rel=0.1)  # still in d
    assert least == pytest.approx(1.0, rel=0.15)


@pytest.mark.parametrize("material", [0.5, 2.0])
def test_deviations_that_do_not_matter_raise_the_least_variance_by_their_square(material):
    rng = np.random.default_rng(3)
    plain = noise_map(rng)
    raised = replace(plain, material=np.array([material]))
    before, after = (products(each, {}) for each in (plain, raised))
    expected = after.windows * material**2
    expected[:, len(MOTIONS) :] = 0.0  # the same in both windows of a change
    assert after.noise - before.noise == pytest.approx(expected)
    assert after.squares == pytest.approx(before.squares)
    still = replace(raised, v_m_s=0 * plain.v_m_s)
    assert products(still, {}).noise.sum() == pytest.approx(
        products(replace(plain, v_m_s=0 * plain.v_m_s), {}).noise.sum()
    )  # at rest nothing has a direction


# ---- changes between windows


def unsteady_map(rng):
    """White windows of runs whose speed goes up and down by a third all the time."""
    plain = noise_map(rng)
    slower = np.arange(len(plain.v_m_s)) % 4 < 2
    return replace(plain, v_m_s=np.where(slower, 0.07, 0.1))


def changes(found, columns=None):
    """Products, and the index of each group of changes by name."""
    data = products(found, columns or {})
    return {name: k for k, (_, name) in enumerate(data.groups) if is_change(name)}, data


def test_changes_are_those_over_windows_that_share_no_sample():
    """By hand: (r_(i+1) - r_(i-1)) / sqrt 2 within each run, and of the columns likewise."""
    rng = np.random.default_rng(10)
    found = unsteady_map(rng)
    column = rng.standard_normal(found.difference.shape)
    where, data = changes(found, {"one": column})
    r, c = (each[:, 0] / found.scatter[0, 0] for each in (found.difference, column))
    runs = [slice(i * PER_RUN, (i + 1) * PER_RUN) for i in range(RUNS)]
    pairs = [((r[o][2:] - r[o][:-2]), (c[o][2:] - c[o][:-2])) for o in runs]
    change = where["change"]
    assert data.mixed[:, change].sum() == pytest.approx(sum(d @ e for d, e in pairs) / 2)
    assert all_products(data.columns)[:, change].sum() == pytest.approx(
        sum(e @ e for _, e in pairs) / 2
    )
    assert data.windows[:, change].sum() == RUNS * (PER_RUN - 2)


def test_a_slow_error_cancels_in_changes_and_a_moment_does_not():
    """A level of 30 sigma and a ramp; then 8 sigma in one window of a run in three."""
    plain = unsteady_map(np.random.default_rng(11))
    slow = np.tile(np.linspace(-5, 5, PER_RUN), RUNS)[:, None] + 30 * np.ones((RUNS * PER_RUN, 1))
    moment = np.zeros((RUNS * PER_RUN, 1))
    moment[PER_RUN // 2 :: 3 * PER_RUN] = 8.0
    unit = (SIGMA / plain.scatter[0, 0]) ** 2 * RUNS * (PER_RUN - 2)
    left = []
    for error in (slow, moment):
        shifted = replace(plain, difference=plain.difference + SIGMA * error)
        where, data = changes(shifted)
        left.append(data.squares[:, where["change"]].sum() / unit)
    assert left[0] == pytest.approx(2 * (10 / 39) ** 2, abs=0.1)
    assert left[1] == pytest.approx(20 * 8.0**2 / (RUNS * (PER_RUN - 2)), rel=0.2)


def test_steady_motion_a_step_and_a_reversal():
    """Steady windows have no group of changes; the others have one each."""
    v = np.tile([0.1] * 10 + [0.3] * 10 + [-0.3] * 20, RUNS)
    where, data = changes(replace(noise_map(np.random.default_rng(12)), v_m_s=v))
    counted = {name: data.windows[:, k].sum() / RUNS for name, k in where.items()}
    assert counted == {"change": 4, "step": 2, "change at a reversal": 2}


def test_what_is_not_material_changes_its_sign_at_a_reversal():
    """Elsewhere a fifth of it is no evidence."""
    v = np.tile([0.1] * 20 + [-0.1] * 20, RUNS)
    found = replace(noise_map(np.random.default_rng(13)), v_m_s=v, material=np.array([3.0]))
    where, data = changes(found)
    _, without = changes(replace(found, material=None))
    more = (data.noise - without.noise).sum(axis=0)
    windows = data.windows.sum(axis=0)
    turn = where["change at a reversal"]
    assert more[turn] == pytest.approx(windows[turn] * (2 * 3.0) ** 2 / 2)
    assert more[where["change"]] == pytest.approx(windows[where["change"]] * (0.2 * 3.0) ** 2)


# ---- levels of runs


@pytest.mark.parametrize("ridge", [0.2, 1.0, 5.0])
def test_a_level_that_is_not_known_is_a_row_of_its_own(ridge):
    """White with the covariance 1 + c c' / ridge; the windows keep what is orthogonal to it."""
    rng = np.random.default_rng(4)
    for size in (0.01, 1.0, 30.0):
        change = size * rng.standard_normal(12)
        left = np.eye(12)
        row = _take_out(left, RunLevel(slice(0, 12), 0, change, ridge))
        covariance = np.eye(12) + np.outer(change, change) / ridge
        assert row @ covariance @ row == pytest.approx(1.0)
        assert change @ left == pytest.approx(np.zeros(12), abs=1e-9 * size)
        assert np.trace(left @ covariance @ left.T) == pytest.approx(11)


def test_levels_drawn_for_each_run_have_the_variance_of_a_white_row():
    """However many windows a run has, also where its columns are far larger than the noise."""
    rng = np.random.default_rng(5)
    levels, drawn = [], []
    for count in (5, 20, 80, 320):
        change = 3.0 + 0.2 * rng.standard_normal(count)
        level = RunLevel(slice(0, count), 0, change, 1.0)
        raw = rng.standard_normal((count, 500)) + np.outer(change, rng.standard_normal(500))
        levels.append(np.var(_take_out(raw, level)))
        drawn.append(np.var(raw) * count / (count - 1))
    assert levels == pytest.approx(np.ones(4), rel=0.2)
    assert drawn == pytest.approx(np.ones(4), rel=0.1)


def test_columns_of_a_balance_lose_the_level_and_those_of_others_do_not():
    """By hand for one run: residuals and columns lose it, and the group of levels has it."""
    rng = np.random.default_rng(6)
    found = a_map(rng, (8, 6), [0.1] * 14)
    found.difference[:] = rng.standard_normal((14, 3))
    change = rng.standard_normal(8)
    level = RunLevel(slice(0, 8), 1, change, 0.5)
    column = rng.standard_normal((14, 3))
    before, after = (
        products(replace(found, levels=levels), {"one": column}) for levels in ((), (level,))
    )
    square, own = change @ change, slice(0, 8)
    d, c = (each[own, 1] / found.scatter[own, 1] for each in (found.difference, column))
    along = [sqrt(0.5 / (0.5 + square)) * (change @ each) / sqrt(square) for each in (d, c)]
    left = np.eye(8) - np.outer(change, change) / square
    steady = len(GROUPS) + 1  # of flow_tr
    of_levels = len(GROUPS) + GROUPS.index("level")
    for group, (one, other) in ((steady, (left @ d, left @ c)), (of_levels, along)):
        assert after.squares[0, group] == pytest.approx(np.sum(one * one))
        assert after.mixed[0, group, 0] == pytest.approx(np.sum(one * other))
        assert all_products(after.columns)[0, group, 0, 0] == pytest.approx(np.sum(other * other))
    assert before.windows[0, [steady, of_levels]] == pytest.approx([8, 0])
    assert after.windows[0, [steady, of_levels]] == pytest.approx([7, 1])
    others = np.delete(np.arange(3 * len(GROUPS)), [steady, of_levels])
    assert np.array_equal(before.squares[:, others], after.squares[:, others])
    assert np.array_equal(before.squares[1], after.squares[1])


def test_a_level_without_a_change_takes_nothing():
    found = a_map(np.random.default_rng(7), (5,))
    level = RunLevel(slice(0, 5), 0, np.zeros(5), 1.0)
    before, after = (products(replace(found, levels=own), {}) for own in ((), (level,)))
    assert np.array_equal(before.squares, after.squares)
    assert np.array_equal(before.windows, after.windows)


def test_a_run_of_many_windows_shows_its_level_as_well_as_one_of_few():
    """Ten standard deviations of the level, which the mean over 200 windows would dilute."""
    rng = np.random.default_rng(8)
    for count in (10, 200):
        found = a_map(rng, (count, count), [0.1] * 2 * count)
        found.difference[:] = 30.0 * found.scatter
        levels = tuple(
            RunLevel(slice(i * count, (i + 1) * count), 0, np.full(count, 3.0), 1.0) for i in (0, 1)
        )
        data = products(replace(found, levels=levels), {})
        group = GROUPS.index("level")
        mean = data.squares[:, group].sum() / data.windows[:, group].sum()
        assert mean == pytest.approx(100, rel=0.02)


# ---- priors


def test_factors_have_their_priors_about_the_plant_that_was_given(measured):
    """At a factor of two priors: the centre is two priors back, and the bounds with it."""
    width = nuisances(measured.plant)["valve.gain"]
    moved = Hypothesis({"valve.gain": float(np.exp(2 * width))})
    model = model_of(measured, ["/valve.gain"], moved)
    for priors in (model.tight, model.wide, model.priors([])):
        assert priors.centre == pytest.approx([-2.0]) and priors.sigma == pytest.approx([1.0])
        assert priors.low == pytest.approx([-BOUND - 2]) and priors.high == pytest.approx(
            [BOUND - 2]
        )
    assert model.nuisances == (0,)


def test_coefficients_with_a_tolerance_are_nuisances_within_it(measured):
    """0.2 V is four typical sizes; at 0.05 V one of them is used up."""
    at = Hypothesis().with_coefficients({NULL: 0.05})
    model = model_of(measured, ["/valve.gain", "valve_trim.null_test", "internal_leakage.test"], at)
    assert model.nuisances == (0, 1)
    tight = model.priors([]).select([1])
    assert tight.centre == pytest.approx([-1.0])
    assert tight.sigma == pytest.approx([4 / sqrt(3)])
    assert tight.low == pytest.approx([-5.0]) and tight.high == pytest.approx([3.0])
    wide = model.priors(["valve_trim"]).select([1])
    assert wide.sigma == pytest.approx([10.0]) and wide.centre == pytest.approx([-1.0])
    assert wide.low == pytest.approx([-41.0]) and wide.high == pytest.approx([39.0])  # 2 V


def test_the_tolerance_of_a_leak_ends_at_none(measured):
    """0.03 V are six typical sizes; at 0.01 V two of them can be lost."""
    which = ("valve_trim", "leak")
    of_leaks = replace(measured, tolerances={which: 0.03})
    for value, low, high in ((0.0, 0.0, 6.0), (0.01, -2.0, 4.0)):
        at = Hypothesis().with_coefficients({which: value})
        tight = model_of(of_leaks, ["valve_trim.leak"], at).tight
        assert tight.low == pytest.approx([low], abs=1e-9)
        assert tight.high == pytest.approx([high])


def test_effects_take_part_in_a_fit_only_where_they_are_tried(measured):
    names = ["/valve.gain", "valve_trim.null_test", "internal_leakage.test", "supply_droop.slope"]
    model = model_of(measured, names)
    assert model.index([]) == [0, 1]
    assert model.index(["supply_droop"]) == [0, 1, 3]
    assert model.coefficients_of(["internal_leakage", "supply_droop"]) == (LEAK, DROOP)
    assert model.column(DROOP) == 3
    tried = model.priors(["supply_droop"])
    assert np.isfinite(tried.sigma).tolist() == [True, True, False, True]
    assert tried.low[3] == 0.0  # no negative slope


def test_beside_a_slow_valve_the_bandwidth_is_that_of_the_given_model(measured):
    """It was refitted by two priors; with the effect it returns by these two and stays there."""
    names = ["/valve.gain", "/valve.bandwidth", "valve_lag.time"]
    width = nuisances(measured.plant)["valve.bandwidth"]
    model = model_of(measured, names, Hypothesis({"valve.bandwidth": float(np.exp(2 * width))}))
    without, beside = model.priors([]), model.priors(["valve_lag"])
    assert without.sigma[:2] == pytest.approx([1.0, 1.0])
    assert beside.sigma[:2] == pytest.approx([1.0, 0.01])
    for priors in (without, beside):
        assert priors.centre[:2] == pytest.approx([0.0, -2.0])


def test_a_model_about_itself_has_its_tolerances_about_its_coefficients(measured):
    """For data that the model itself makes: 0.05 V is the middle, not 0 V."""
    at = Hypothesis().with_coefficients({NULL: 0.05})
    model = model_of(measured, ["/valve.gain", "valve_trim.null_test"], at)
    found = model.about_itself(["valve_trim"]).tight
    assert found.centre == pytest.approx([0.0, 0.0])
    assert found.low[1] == pytest.approx(-4.0) and found.high[1] == pytest.approx(4.0)
    assert found.sigma == pytest.approx(model.tight.sigma)
    assert model.about_itself([]).tight.centre == pytest.approx(model.tight.centre)


def test_a_reference_gives_the_scatter(measured):
    rng = np.random.default_rng(10)
    other = replace(measured.map, scatter=rng.uniform(1, 3, (21, 3)))
    columns = measured.columns(Hypothesis(), ["/valve.gain"])
    found = linearise(measured, Hypothesis(), columns, other)
    assert found.gap_map.scatter is other.scatter
    assert found.gap_map.difference is measured.map.difference
    assert found.data.squares == pytest.approx(
        products(measured.map.in_units_of(other), columns).squares
    )


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
    assert par._replace(effects=None, learned=None) == plain
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


def test_steps_are_taken_in_priors_and_typical_sizes(measured):
    """A factor moves by exp(prior * step), a coefficient by its typical size; others stay."""
    priors = nuisances(measured.plant)
    paths = list(priors)
    names = [*(f"/{path}" for path in paths), ".".join(LEAK), ".".join(DROOP)]
    start = Hypothesis({paths[0]: 1.2}).with_coefficients({LEAK: 1e-12})
    model = model_of(measured, names, start)
    beta = np.linspace(-1, 1, len(names))
    found = hypothesis_at(model, measured.plant, range(len(names)), beta)
    for path, step in zip(paths, beta, strict=False):
        before = 1.2 if path == paths[0] else 1.0
        assert found.factors[path] == pytest.approx(before * np.exp(priors[path] * step))
    assert found.coefficient(LEAK) == pytest.approx(1e-12 + beta[-2] * typical_size(LEAK))
    assert found.coefficient(DROOP) == pytest.approx(beta[-1] * typical_size(DROOP))
    assert model.hypothesis.coefficient(LEAK) == 1e-12
    some = hypothesis_at(model, measured.plant, [len(paths)], np.array([2.0]))
    assert some.factors == {paths[0]: 1.2} and DROOP[0] not in some.effects
    assert some.coefficient(LEAK) == pytest.approx(1e-12 + 2 * typical_size(LEAK))


def test_of_the_gains_of_two_transducers_the_more_likely_one_leaves_its_tolerance(measured):
    """1 % is the class, and the typical size. A fit of both has the larger value for the other."""
    keys = [("pressure_gain", name) for name in ("p_tp", "p_s")]
    names = list(map(".".join, keys))
    measured = replace(measured, tolerances=dict.fromkeys(keys, 0.01))
    rng, shape = np.random.default_rng(3), measured.map.difference.shape
    first, apart = 1e3 * rng.standard_normal((2, *shape))
    columns = dict(zip(names, (first, 0.5 * first + 0.05 * apart), strict=True))
    difference = 2.0 * columns[names[0]] + 2.2 * columns[names[1]]
    measured = replace(measured, map=replace(measured.map, difference=difference))
    model = linearise(measured, Hypothesis(), columns)
    points = np.arange(len(model.gap_map.points))
    both = maximum_likelihood(model.data, model.priors(["pressure_gain"]), [0, 1], points)
    assert both == pytest.approx([2.0, 2.2], abs=0.1)
    alternatives = model.alternative_priors(["pressure_gain"])
    assert [list(each.high) for each in alternatives] == [[20.0, 1.0], [1.0, 20.0]]
    found = likeliest(model.data, alternatives, [0, 1], points)
    assert found == pytest.approx([2.6, 1.0], abs=0.1)
    alone = hypothesis_at(model, measured.plant, [0, 1], found)
    (priors,) = linearise(measured, alone, columns).alternative_priors(["pressure_gain"])
    assert priors.high == pytest.approx([20.0, 1.0] - found, abs=1e-6)


@pytest.mark.parametrize(
    ("values", "correlation", "may_be_zero"),
    [
        ((1.5, 1.5), 0.0, True),
        ((1.5, 1.5), -0.9, False),  # their sum is known well
        ((1.5, 1.5), 0.9, True),
        ((3.0, 0.0), 0.0, False),
    ],
)
def test_whether_coefficients_together_may_be_0(measured, values, correlation, may_be_zero):
    """Two leaks in standard errors, of which one is already in the model."""
    keys = [("internal_leakage", "test"), ("internal_leakage", "load")]
    shape = ".".join(("internal_leakage", "exponent"))
    at = Hypothesis().with_coefficients({keys[0]: typical_size(keys[0])})
    model = model_of(measured, [*map(".".join, keys), shape], at)
    covariance = np.diag([1.0, 1.0, 1e-4])
    covariance[0, 1] = covariance[1, 0] = correlation
    beta = np.array([values[0] - 1.0, values[1], 5.0])
    none = np.full(3, np.inf)
    estimates = ParameterEstimates(
        measured.plant,
        model,
        (0, 1, 2),
        beta,
        covariance,
        covariance,
        np.full(3, 40.0),
        -none,
        none,
    )
    assert estimates.may_be_zero("internal_leakage") == may_be_zero


@pytest.mark.parametrize(("correlation", "may_be_zero"), [(0.0, True), (-0.95, False)])
def test_an_effect_whose_size_and_shape_are_a_product_is_not_0(measured, correlation, may_be_zero):
    """Its size is 1.5 standard errors from 0, or 4.8 at the fitted shape."""
    keys = ["internal_leakage.test", "internal_leakage.exponent"]
    model = model_of(measured, keys, Hypothesis())
    covariance, none = np.array([[1.0, correlation], [correlation, 1.0]]), np.full(2, np.inf)
    estimates = ParameterEstimates(
        measured.plant,
        model,
        (0, 1),
        np.array([1.5, 0.0]),
        *[covariance] * 2,
        np.full(2, 40.0),
        -none,
        none,
    )
    assert estimates.may_be_zero("internal_leakage") == may_be_zero


@pytest.mark.parametrize(("test", "may_be_zero"), [(6.0, False), (1.5, True)])
def test_a_coefficient_that_changes_nothing_does_not_make_an_effect_0(measured, test, may_be_zero):
    """Without a load cylinder no data determine its leak, with one degree of freedom."""
    keys = ["internal_leakage.test", "internal_leakage.load"]
    model = model_of(measured, keys, Hypothesis())
    columns = {keys[0]: model.columns[keys[0]], keys[1]: 0 * model.columns[keys[1]]}
    model = linearise_residuals(measured, Hypothesis(), model.gap_map, columns)
    beta, none = np.array([test, 0.0]), np.full(2, np.inf)
    estimates = ParameterEstimates(
        measured.plant,
        model,
        (0, 1),
        beta,
        *[np.eye(2)] * 2,
        np.array([40.0, 1.0]),
        -none,
        none,
    )
    assert estimates.may_be_zero("internal_leakage") == may_be_zero


@pytest.mark.parametrize(("step", "ms"), [(0.02, 0.1), (1.0, 3.0), (50.0, 100.0), (0.0, 0.0)])
def test_a_step_ends_at_a_value_that_a_plant_file_may_contain(measured, step, ms):
    """A lag of a valve is 0, or 0.1 to 100 ms; its typical size is 3 ms."""
    model = linearise(measured, Hypothesis(), measured.columns(Hypothesis(), ["valve_lag.time"]))
    found = hypothesis_at(model, measured.plant, [0], np.array([step]))
    assert found.coefficient(("valve_lag", "time")) == pytest.approx(1e-3 * ms)
    read_effects(found.section())
