"""Variance components against published examples, and on data that its model does not hold for."""

import math

import numpy as np
import pytest
from scipy import optimize, stats

from hbench.analysis.fleet.precision import plan_of, precision_of
from hbench.analysis.fleet.variance_components import (
    PlanData,
    VarianceComponents,
    anova,
    numbered,
    separated,
)
from hbench.records import CYLINDER, QUANTITIES

CROSSED = "cylinder × operator"

# AIAG, Measurement Systems Analysis, 4th edition, 2010, table III-B 1: trials of ten parts by the
# appraisers A, B, C.
AIAG = """
 0.29 -0.56 1.34 0.47 -0.80  0.02 0.59 -0.31 2.26 -1.36
 0.41 -0.68 1.17 0.50 -0.92 -0.11 0.75 -0.20 1.99 -1.25
 0.64 -0.58 1.27 0.64 -0.84 -0.21 0.66 -0.17 2.01 -1.31
 0.08 -0.47 1.19 0.01 -0.56 -0.20 0.47 -0.63 1.80 -1.68
 0.25 -1.22 0.94 1.03 -1.20  0.22 0.55  0.08 2.12 -1.62
 0.07 -0.68 1.34 0.20 -1.28  0.06 0.83 -0.34 2.19 -1.50
 0.04 -1.38 0.88 0.14 -1.46 -0.29 0.02 -0.46 1.77 -1.49
-0.11 -1.13 1.09 0.20 -1.07 -0.67 0.01 -0.56 1.45 -1.77
-0.15 -0.96 0.67 0.11 -1.45 -0.49 0.21 -0.49 1.87 -2.16
"""
# Montgomery, Design and Analysis of Experiments, 8th edition, 2013, table 13.1: two trials of 20
# parts by each of three operators.
MONTGOMERY = """
21 20 20 20 19 21   24 23 24 24 23 24   20 21 19 21 20 22   27 27 28 26 27 28   19 18 19 18 18 21
23 21 24 21 23 22   22 21 22 24 22 20   19 17 18 20 19 18   24 23 25 23 24 24   25 23 26 25 24 25
21 20 20 20 21 20   18 19 17 19 18 19   23 25 25 25 25 25   24 24 23 25 24 25   29 30 30 28 31 30
26 26 25 26 25 27   20 20 19 20 20 20   19 21 19 19 21 23   25 26 25 24 25 25   19 19 18 17 19 17
"""
# Davies and Goldsmith, Statistical Methods in Research and Production, 1972, tables 6.1 and 6.5;
# "Dyestuff" and "Pastes" of the R package lme4.
DYESTUFF = """
1545 1440 1440 1520 1580   1540 1555 1490 1560 1495   1595 1550 1605 1510 1560
1445 1440 1595 1465 1545   1595 1630 1515 1635 1625   1520 1455 1450 1480 1445
"""
PASTES = """
62.8 62.6 60.1 62.3 62.7 63.1   60.0 61.4 57.5 56.9 61.1 58.9   58.7 57.5 63.9 63.1 65.4 63.7
57.1 56.4 56.9 58.6 64.7 64.5   55.1 55.1 54.7 54.2 58.8 57.5   63.4 64.9 59.3 58.1 60.5 60.0
62.5 62.6 61.0 58.7 56.9 57.7   59.2 59.4 65.2 66.0 64.8 64.1   54.8 54.8 64.0 64.0 57.7 56.8
58.3 59.3 59.2 59.2 58.9 56.6
"""
# ISO 5725-2:1994, annex B.1, sulfur content of coal, level 1: eight laboratories, unbalanced.
COAL = (
    (0.71, 0.71, 0.70, 0.71), (0.69, 0.67, 0.68), (0.66, 0.65, 0.69), (0.67, 0.65, 0.66),
    (0.70, 0.69, 0.66, 0.71, 0.69), (0.73, 0.74, 0.73), (0.71, 0.71, 0.69), (0.70, 0.65, 0.68),
)  # fmt: skip


def read(text, *shape):
    return np.array(text.split(), dtype=float).reshape(shape)


def plan_data(trials, levels):
    """The data of single trials, one sequence for each campaign."""
    arrays = [np.asarray(each, dtype=float) for each in trials]
    return PlanData(
        means=np.array([each.mean() for each in arrays]),
        trials=np.array([float(len(each)) for each in arrays]),
        scatter=float(sum(((each - each.mean()) ** 2).sum() for each in arrays)),
        dof=float(sum(len(each) - 1 for each in arrays)),
        levels={name: numbered(each) for name, each in levels.items()},
    )


def crossed(trials):
    """Data of trials (cylinders, operators, n), each cell a campaign."""
    cylinders, operators, n = trials.shape
    of = [(c, o) for c in range(cylinders) for o in range(operators)]
    levels = {
        CYLINDER: [c for c, _ in of],
        "operator": [o for _, o in of],
        CROSSED: of,
    }
    return plan_data(trials.reshape(-1, n), levels)


def sigmas(components):
    return {name: math.sqrt(value) for name, value in components.items()}


def test_gauge_study_of_the_aiag():
    """Its table III-B 7: without the interaction, whose ANOVA estimate is negative."""
    data = crossed(read(AIAG, 3, 3, 10).transpose(2, 0, 1))
    found = VarianceComponents(data)
    assert sigmas(found.variances) == pytest.approx(
        {CYLINDER: 1.042327, "operator": 0.226838, CROSSED: 0.0, "trials": 0.199933}, abs=1e-6
    )
    measurement = ("operator", CROSSED, "trials")
    grr, share = found.component(measurement), found.share(measurement)
    assert math.sqrt(grr.value) == pytest.approx(0.302373, abs=2e-6)
    assert 100 * math.sqrt(share.value) == pytest.approx(27.86, abs=0.005)
    assert anova(data)[CROSSED] < 0
    assert share.low < share.value < share.high < 1 and grr.low < grr.value < grr.high


def test_gauge_study_of_montgomery():
    """His example 13.1: ANOVA with the interaction, and without it."""
    trials = read(MONTGOMERY, 20, 3, 2)
    data = crossed(trials)
    assert anova(data) == pytest.approx(
        {CYLINDER: 10.2798, "operator": 0.0149, CROSSED: -0.1399, "trials": 0.9917}, abs=1e-4
    )
    found = VarianceComponents(data).variances
    expected = {CYLINDER: 10.2513, "operator": 0.0106, CROSSED: 0.0, "trials": 0.8832}
    assert found == pytest.approx(expected, abs=1e-4)


def test_lme4s_dyestuff_and_its_profile_interval():
    """Bates, lme4: Mixed-effects modeling with R, 2010, sections 1.3 and 1.5."""
    data = plan_data(read(DYESTUFF, 6, 5), {"batch": range(6)})
    fit = VarianceComponents(data)
    assert fit.variances == pytest.approx({"batch": 1764.05, "trials": 2451.25}, abs=0.01)
    assert anova(data) == pytest.approx(fit.variances, rel=1e-6)
    trials = fit.component(["trials"])
    ends = math.sqrt(trials.low), math.sqrt(trials.high)
    assert ends == pytest.approx((38.22998, 67.65770), rel=1e-3)


def test_lme4s_nested_pastes():
    """The vignette of lme4, model fm3: standard deviations 2.9041, 1.2874 and 0.8234."""
    samples = {"batch": np.repeat(range(10), 3), "sample": range(30)}
    data = plan_data(read(PASTES, 30, 2), samples)
    fit = VarianceComponents(data)
    assert sigmas(fit.variances) == pytest.approx(
        {"batch": 1.2874, "sample": 2.9041, "trials": 0.8234}, abs=1e-4
    )
    assert anova(data) == pytest.approx(fit.variances, rel=1e-5)
    assert fit.component(["batch"]).low == 0.0


def test_coal_of_iso_5725():
    """Unbalanced, by ANOVA as in the standard, which prints s_r = 0.015 and s_R = 0.026."""
    found = anova(plan_data(COAL, {"laboratory": range(8)}))
    assert math.sqrt(found["trials"]) == pytest.approx(0.015, abs=5e-4)
    assert math.sqrt(sum(found.values())) == pytest.approx(0.026, abs=5e-4)


def minus_twice_log(trials, levels, variances):
    """-2 log of the restricted likelihood of all single trials, by scipy's normal distribution."""
    y = np.concatenate(trials)
    rows = np.repeat(np.arange(len(trials)), [len(each) for each in trials])
    v = variances[-1] * np.eye(len(y))
    for variance, each in zip(variances, levels, strict=False):
        at = np.asarray(each)[rows]
        v = v + variance * (at[:, None] == at)
    contrasts = np.linalg.svd(np.ones((1, len(y))))[2][1:]
    normal = stats.multivariate_normal(cov=contrasts @ v @ contrasts.T)
    return -2 * normal.logpdf(contrasts @ y)


def test_an_unbalanced_plan_has_the_likelihood_of_its_single_trials():
    """Estimate and both ends of the interval: another search, over the whole covariance."""
    trials, levels = [1e3 * np.array(each) for each in COAL], [range(8)]

    def of_logs(logs):
        return minus_twice_log(trials, levels, np.exp(logs))

    best = optimize.minimize(of_logs, [6.0, 6.0], method="Nelder-Mead", options={"xatol": 1e-7})
    fit = VarianceComponents(plan_data(trials, {"laboratory": levels[0]}))
    assert list(fit.variances.values()) == pytest.approx(np.exp(best.x), rel=1e-4)
    for end in fit.component(["laboratory"])[1:]:
        profile = optimize.minimize_scalar(
            lambda log, end=end: of_logs([math.log(end), log]), bounds=(3, 9), method="bounded"
        )
        assert profile.fun - best.fun == pytest.approx(3.841, abs=0.02)
    whole = fit.component(["laboratory", "trials"])
    for end in whole[1:]:
        profile = optimize.minimize_scalar(
            lambda part, end=end: of_logs([math.log(end * (1 - part)), math.log(end * part)]),
            bounds=(0.001, 0.999), method="bounded",
        )  # fmt: skip
        assert profile.fun - best.fun == pytest.approx(3.841, abs=0.02)


def test_factors_that_change_together_are_not_separated():
    rng = np.random.default_rng(0)
    cylinder = [0, 0, 0, 0, 1, 1, 1, 1]
    levels = {
        CYLINDER: cylinder,
        "operator": ["A", "A", "B", "B"] * 2,
        "day": [1, 1, 2, 2] * 2,  # each operator had a day of his own
        "shift": [0] * 8,
        CROSSED: [0, 0, 1, 1, 2, 2, 3, 3],
        "campaign": range(8),
    }
    found = separated(plan_data(rng.normal(size=(8, 3)), levels))
    assert list(found.levels) == [CYLINDER, "operator", CROSSED, "campaign"]
    assert found.merged == (("day", "operator"),) and found.dependent == ()
    alone = separated(plan_data(rng.normal(size=(8, 1)), levels))
    assert ("campaign", "trials") in alone.merged and "campaign" not in alone.levels


FRICTION = next(q for q in QUANTITIES if q.name == "friction_n")


def drawn_study(seed, *, heavy):
    """Two mountings of eight cylinders by three operators, a fifth of them lost, three trials.

    ``heavy`` effects and trials are Laplace's and Student's with four degrees of freedom, and the
    trials scatter in proportion to the level.
    """
    rng = np.random.default_rng(seed)

    def effects(sigma, *shape):
        if heavy:
            return sigma / math.sqrt(2) * rng.laplace(size=shape)
        return rng.normal(0, sigma, size=shape)

    of_cylinder, of_operator = effects(20.0, 8), effects(8.0, 4)
    of = [(c, o, m) for c in range(8) for o in range(4) for m in range(2) if rng.random() > 0.2]
    trials = []
    for c, o, _ in of:
        mean = 400 + of_cylinder[c] + of_operator[o] + float(effects(5.0))
        noise = rng.standard_t(4, 3) / math.sqrt(2) * mean / 400 if heavy else rng.normal(size=3)
        trials.append(mean + 4.0 * noise)
    texts = [(f"C{c}", "ABCD"[o], f"{o}{m}") for c, o, m in of]
    names = (CYLINDER, "operator", "mounting")
    identities = {name: [t[i] for t in texts] for i, name in enumerate(names)}
    plan = plan_of(np.arange(len(of)), identities | {"day": [""] * len(of)})
    columns = np.array([[np.mean(t), np.std(t, ddof=1) / math.sqrt(3), 3.0, 2.0] for t in trials]).T
    found, notes = precision_of(FRICTION, "extend", plan, columns, 200.0)
    assert notes == () and plan.notes == ("Not stated: day (test.date).",)
    return found


TRUTH = {
    "repeatability": 4.0,
    "reproducibility": math.sqrt(4.0**2 + 5.0**2 + 8.0**2),
    "share_of_total": math.sqrt((4.0**2 + 5.0**2 + 8.0**2) / (4.0**2 + 5.0**2 + 8.0**2 + 20.0**2)),
}


def coverage(studies, name):
    held = [
        getattr(each, name).low <= TRUTH[name] <= (getattr(each, name).high or math.inf)
        for each in studies
    ]
    return sum(held) / len(held)


def test_the_parts_of_an_unbalanced_plan_are_found():
    """One plan of heavy tails: what the page states follows from its components by definition."""
    found = drawn_study(3, heavy=True)
    by_name = {source.name: source.variance for source in found.sources}
    assert list(by_name) == [CYLINDER, "operator", "mounting", CROSSED, "trials"]
    grr = sum(v.value for name, v in by_name.items() if name != CYLINDER)
    assert found.reproducibility.value == pytest.approx(math.sqrt(grr))
    r, limit = found.limits
    assert r == pytest.approx(2.8 * math.sqrt(by_name["trials"].value))
    between = grr - by_name["trials"].value
    assert found.critical_difference == pytest.approx(
        2.8 * math.sqrt(between + by_name["trials"].value / 3)
    )
    assert found.share_of_tolerance == pytest.approx(6 * math.sqrt(grr) / 200)
    assert r < found.critical_difference < limit


@pytest.mark.slow
@pytest.mark.parametrize(("heavy", "least"), [(False, 0.92), (True, 0.65)])
def test_intervals_hold_the_truth(heavy, least):
    """With normal effects as often as stated; with heavy tails they are too narrow.

    The variance of Student's distribution with four degrees of freedom has no finite scatter.
    """
    studies = [drawn_study(seed, heavy=heavy) for seed in range(150)]
    for name in TRUTH:
        share = coverage(studies, name)
        print(f"{'heavy tails' if heavy else 'normal'}: {name}: {100 * share:.1f} % of 150")
        assert least < share < 0.99


@pytest.mark.parametrize(
    ("cylinders", "reason"),
    [
        (["", "", ""], "do not state which cylinder"),
        (["1", "2", "3", "4"], "Each of the 4 cylinders was measured once"),
        (["1", "1", "2"], "measured twice"),
        (["1"] * 200, "limit 150"),
    ],
)
def test_campaigns_that_form_no_plan_are_refused_with_the_reason(cylinders, reason):
    n = len(cylinders)
    empty = dict.fromkeys(("operator", "mounting", "day"), [""] * n)
    plan = plan_of(np.arange(n), {CYLINDER: cylinders} | empty)
    assert not len(plan.rows) and reason in plan.notes[0]


def test_a_plan_names_what_it_does_not_vary_and_what_only_some_campaigns_state():
    identities = {
        CYLINDER: ["1", "1", "2", "2", ""],
        "operator": ["A"] * 5,
        "mounting": ["1", "2", "1", "2", "1"],
        "day": ["2026-03-02", "", "", "", ""],
    }
    plan = plan_of(np.arange(10, 15), identities)
    assert plan.rows.tolist() == [10, 11, 12, 13]
    assert list(plan.levels) == [CYLINDER, "mounting", "campaign"]
    assert len(set(plan.levels["mounting"].tolist())) == 4  # those of two cylinders differ
    words = " ".join(plan.notes)
    assert "Not varied: operator." in words and "1 campaign without" in words
    assert "3 of 4 campaigns do not state test.date" in words


def test_campaigns_without_scatter_have_no_components():
    plan = plan_of(
        np.arange(4),
        {CYLINDER: ["1", "1", "2", "2"], "operator": list("ABAB"), "mounting": [""] * 4,
         "day": [""] * 4},
    )  # fmt: skip
    same = np.array([[400.0] * 4, [0.0] * 4, [3.0] * 4, [2.0] * 4])
    assert precision_of(FRICTION, "extend", plan, same, None) == (None, ())


@pytest.mark.parametrize("seed", range(6))
def test_two_levels_of_a_factor_give_a_wide_interval_that_has_its_ends(seed):
    """Two operators: the likelihood falls so slowly that the search must follow it far."""
    rng = np.random.default_rng(seed)
    of = [(c, o, m) for c in range(4) for o in range(2) for m in range(2)]
    level = 15 * rng.normal(size=4), 8 * rng.normal(size=2)
    trials = [400 + level[0][c] + level[1][o] + rng.normal(0, (3, 2), 2).sum() + rng.normal(0, 2, 3)
              for c, o, _ in of]  # fmt: skip
    levels = {CYLINDER: [c for c, _, _ in of], "operator": [o for _, o, _ in of], "mounting": of}
    fit = VarianceComponents(plan_data(trials, levels))
    for name, value in fit.variances.items():
        found = fit.component([name])
        assert found.low <= found.value == value <= found.high
    operators = fit.component(["operator"])
    assert operators.high > 50 * max(operators.value, 1.0)
    share = fit.share(["operator", "mounting", "trials"])
    assert 0 < share.low <= share.value <= share.high <= 1
