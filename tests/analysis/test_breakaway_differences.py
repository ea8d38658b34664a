"""Breakaway of two campaigns compared: against scipy, by drawn errors, and which rows match."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from hbench.analysis.comparison.breakaway_differences import breakaway_differences
from hbench.analysis.comparison.difference_tests import InstrumentPair
from hbench.analysis.curves.breakaway import breakaways
from hbench.analysis.statistics.holm import holm
from hbench.config.sensors import Instruments
from tests.support.analysis.pushes import LOAD, accepted, push

DWELLS = (1.0, 10.0, 60.0)
CLASS = {"tolerance": "1 %", "of": "reading", "distribution": "standard"}
KNOWN = Instruments.model_validate(
    {"force": {**CLASS, "full_scale": "10 kN"}, "pressure": {**CLASS, "full_scale": "100 bar"}}
)


def campaign(seed, level_n, dwells=DWELLS, sign=1.0, trials=3):
    rng = np.random.default_rng(seed)
    runs = [
        push(level_n + rng.normal(20 * np.log10(dwell), 12), 100 * i + n, n, dwell, sign)
        for i, dwell in enumerate(dwells)
        for n in range(1, trials + 1)
    ]
    return results(accepted(*runs))


def results(runs):
    found = breakaways(runs, KNOWN)
    return SimpleNamespace(runs=runs, motions=SimpleNamespace(breakaways=found))


def compared(a, b, known=(None, None), same=False):
    return breakaway_differences(a, b, InstrumentPair(*known, same))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_differences_are_those_of_scipys_welch_test_and_corrected_for_their_number(sign):
    a, b = campaign(1, 600.0, sign=sign), campaign(2, 520.0, sign=sign)
    found, notes = compared(a, b)
    assert [each.a.dwell_s for each in found] == list(DWELLS) and notes == ()
    peers = [stats.ttest_ind(e.b.trials_n, e.a.trials_n, equal_var=False) for e in found]
    for each, peer in zip(found, peers, strict=True):
        d, interval = each.breakaway_n, peer.confidence_interval()
        assert (d.value - d.ci95, d.value + d.ci95) == pytest.approx(tuple(interval))
        assert d.p_value == pytest.approx(peer.pvalue) and d.u95 is None
        assert d.value == pytest.approx(-80.0, abs=30.0)
    after = [each.breakaway_n.p_holm for each in found]
    assert after == pytest.approx(holm([peer.pvalue for peer in peers]))


def drawn_differences(rng, same, sign):
    """Standard deviation of the difference of two pushes, whose readings have drawn gains."""
    differences = []
    runs = push(600.0, 1, sign=sign), push(500.0, 1, sign=sign)
    for _ in range(400):
        read = []
        gains = 1 + 0.01 * rng.standard_normal((2, 3))
        for run, (p_tp, p_tr, force) in zip(runs, gains[[0, 0]] if same else gains, strict=True):
            shown = replace(
                run,
                p_tp_pa=p_tp * run.p_tp_pa,
                p_tr_pa=p_tr * run.p_tr_pa,
                f_applied_n=force * run.f_applied_n,
            )
            read.append(breakaways(accepted(shown), None)[0].breakaway_n)
        differences.append(read[1] - read[0])
    return np.std(differences)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("same", [True, False])
def test_errors_of_the_same_instruments_cancel_where_their_readings_agree(same, sign):
    a, b = (campaign(n, level, (1.0,), sign, trials=60) for n, level in ((3, 600.0), (4, 500.0)))
    ((one,), _) = compared(a, b, (KNOWN, KNOWN), same)
    d = one.breakaway_n
    of_instruments = np.sqrt((d.u95 / 1.98) ** 2 - d.se**2)  # Student's factor of some 118 trials
    expected = drawn_differences(np.random.default_rng(5), same, sign)
    assert of_instruments == pytest.approx(expected, rel=0.12)
    assert (expected < 2.0) == same, "1 % of the difference, and of forces of 1 to 4 kN"
    assert d.u95_a == pytest.approx(one.a.u95_n) and d.u95_b == pytest.approx(one.b.u95_n)


def test_only_pushes_alike_in_direction_load_rest_and_rate_are_compared():
    a = campaign(1, 600.0, (1.0, 10.0))
    b = campaign(2, 560.0, (10.2, 60.0))
    found, notes = compared(a, b)
    assert [(each.a.dwell_s, each.b.dwell_s) for each in found] == [(10.0, 10.2)]
    assert notes == (
        f"breakaway extending {LOAD:.0f} N after 1 s at 500 N/s: only in A",
        f"breakaway extending {LOAD:.0f} N after 60 s at 500 N/s: only in B",
    )
    assert not compared(a, campaign(2, 560.0, (1.0, 10.0), sign=-1.0))[0]
    for change in ({"rate_n_s": 1000.0}, {"dwell_s": None}):
        others = [replace(each, **change) for each in a.motions.breakaways]
        b = SimpleNamespace(runs=a.runs, motions=SimpleNamespace(breakaways=others))
        found, notes = compared(a, b)
        assert found == () and len(notes) == 4


def test_labels_must_agree_where_a_campaign_has_several():
    def named(labels):
        runs = [
            replace(each.run, plan=replace(each.run.plan, label=label))
            for label in labels
            for each in campaign(1, 600.0, (1.0,)).runs
        ]
        return results(accepted(*runs))

    assert len(compared(named(["NBR"]), named(["PTFE"]))[0]) == 1
    found, notes = compared(named(["NBR", "PTFE"]), named(["PTFE", "FKM"]))
    assert [each.a.series.label for each in found] == ["PTFE"]
    assert [note.split()[0] for note in notes] == ["NBR", "FKM"]


def test_one_trial_gives_a_difference_without_an_interval():
    ((one,), _) = compared(campaign(1, 600.0, (1.0,), trials=1), campaign(2, 560.0, (1.0,)))
    assert one.breakaway_n.ci95 is None and "single trial" in one.breakaway_n.untested
    assert not one.breakaway_n.real
