"""No verdict of a search turns with a last digit: inputs shaken by 1e-13 of themselves.

See ``tests/analysis/test_rounding.py``. Here: degrees of freedom that are whole numbers, trials
that are equal, windows that are at one place, candidates that explain alike, a constant pressure.
"""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from hbench.analysis.rounding import ranked
from hbench.reconcile.acceptance import TIE
from hbench.reconcile.estimates import whole_dof
from hbench.reconcile.evidence.cross_validation import Comparison
from hbench.reconcile.evidence.likelihood import Fit, Priors, spread
from hbench.reconcile.evidence.products import Products
from hbench.reconcile.gaps.gap_map import gaps
from hbench.reconcile.gaps.regions import regions
from hbench.reconcile.measured.balances import WindowedRun
from hbench.reconcile.strokes.load_cell import Stroke
from hbench.reconcile.strokes.pairs import StrokePair
from hbench.reconcile.strokes.series import MeasuredStrokes
from hbench.records import RunPlan, Specimen
from tests.support.analysis.shaking import shaken
from tests.support.reconcile.products import column_products

seeds = st.integers(0, 2**32 - 1)
shaking = settings(max_examples=30, deadline=None)
PLAN = RunPlan("0001", "steady", 1, 0.05, Specimen(1e-3, 8e-4))


def products(d, columns):
    p, g, w, q = columns.shape
    return Products(
        names=tuple(f"c{j}" for j in range(q)),
        columns=column_products(np.einsum("pgwj,pgwk->pgjk", columns, columns)),
        mixed=np.einsum("pgw,pgwj->pgj", d, columns),
        squares=np.sum(d**2, axis=2),
        noise=np.full((p, g), 1e-3 * w),
        windows=np.full((p, g), w),
        groups=tuple((f"balance {i}", "steady") for i in range(g)),
    )


FREE = Priors(np.zeros(3), np.full(3, 10.0), np.full(3, -50.0), np.full(3, 50.0))


@shaking
@given(points=st.integers(4, 30), groups=st.integers(1, 6), seed=seeds)
def test_degrees_of_freedom_are_those_of_the_operating_points(points, groups, seed):
    rng = np.random.default_rng(seed)
    columns, d = (
        rng.standard_normal((points, groups, 5, 3)),
        rng.standard_normal((points, groups, 5)),
    )
    for shake in (np.asarray, lambda values: shaken(values, seed)):
        data = products(shake(d), shake(columns))
        _, _, dof = spread(data, FREE, [0, 1, 2], np.zeros(3), np.arange(points))
        assert [whole_dof(float(one)) for one in dof] == [points - 1] * 3


@shaking
@given(seed=seeds)
def test_candidates_that_explain_alike_keep_the_catalogues_order(seed):
    """Three columns are one and the same, in other units."""
    rng = np.random.default_rng(seed)
    one = rng.standard_normal((20, 2, 5, 1))
    d = 3 * one[..., 0] + rng.standard_normal((20, 2, 5))
    same = shaken(np.concatenate([one, one, one], axis=3), seed)
    data = products(d, same)
    points = np.arange(20)
    scores = [
        float(Comparison(data, Fit([], FREE), Fit([i], FREE), [i], points).score()[0])
        for i in range(3)
    ]
    assert ranked(range(3), lambda i: scores[i], TIE) == [0, 1, 2]


@shaking
@given(equal=st.sampled_from([(), (0,), (0, 1)]), seed=seeds)
def test_windows_whose_trials_are_equal_say_nothing(equal, seed):
    """Their scatter is rounding: which balances lack something does not depend on it."""

    def drawn(rng, shake):
        runs = []
        for point in range(10):
            for trial in range(3):
                values = 100.0 + rng.standard_normal((8, 2))
                values[list(equal)] = 100.0
                at = np.arange(8.0)
                plan = replace(PLAN, trial=trial, v_ref_m_s=0.01 * point)
                shape = (plan, ("first", "second"), shake(values), at, at, at, 0 * at, np.zeros(2))
                runs.append(WindowedRun(*shape))
        return runs

    def found(shake):
        rng = np.random.default_rng(seed)
        listed, whole = gaps(drawn(rng, shake), drawn(rng, shake))
        return [(one.name, one.p_value, one.windows) for one in listed], np.isfinite(whole.excess)

    draw = np.random.default_rng(seed + 1)
    one, two = found(np.asarray), found(lambda values: shaken(values, draw.integers(9**9)))
    assert one[0] == two[0] and np.array_equal(*(each[1] for each in (one, two)))


@shaking
@given(seed=seeds)
def test_windows_at_one_place_are_in_one_region(seed):
    def drawn(shake):
        rng, runs = np.random.default_rng(seed), []
        for point in range(8):
            for trial in range(2):
                t = 0.1 * np.arange(1, 9)
                plan = replace(PLAN, trial=trial, v_ref_m_s=0.01 * point)
                load = np.full(8, [500.0, 2000.0][point % 2])
                values = rng.standard_normal((8, 1))
                where = (shake(t), shake(0.3 * t), shake(0 * t + 0.05), shake(load))
                runs.append(WindowedRun(plan, ("only",), values, *where, np.zeros(1)))
        return runs

    def parts(shake):
        _, found = gaps(drawn(shake), drawn(shake))
        return [(one.axis, one.label, one.windows) for one in regions(found)]

    draw = np.random.default_rng(seed + 1)
    assert parts(lambda values: shaken(values, draw.integers(9**9))) == parts(np.asarray)


@shaking
@given(p_tr=st.floats(0.0, 2e7), seed=seeds)
def test_a_constant_pressure_is_no_channel(p_tr, seed):
    pressures = shaken(np.full(6, p_tr), seed)
    strokes = [Stroke(0.0, 0.05, 1e6, float(p), 100.0) for p in pressures]
    pairs = tuple(
        StrokePair(PLAN, 0.05, *both) for both in zip(strokes[::2], strokes[1::2], strict=True)
    )
    assert not MeasuredStrokes(None, pairs)._rod_side_measured
    other = replace(pairs[0], extend=replace(strokes[0], p_tr_pa=1.01 * p_tr + 1e3))
    assert MeasuredStrokes(None, (other, *pairs[1:]))._rod_side_measured
