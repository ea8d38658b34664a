"""Ripple of dry friction along the bores: a nuisance, and no effect within its size."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.config.bench import merge, parse_bench, parse_plant
from hbench.config.files.loading import read_yaml
from hbench.experiment.closed_loop import record
from hbench.model.build import plant_parameters
from hbench.reconcile import measured_campaign
from hbench.reconcile.column_names import ripple_name
from hbench.reconcile.gaps.gap_map import point_of
from hbench.reconcile.measured.balances import BALANCES
from hbench.reconcile.measured.disturbances import CYLINDERS
from hbench.reconcile.search.campaign_search import CampaignSearch
from tests.support import ROOT
from tests.support.reconcile.rounds import campaign_of, schedule

PERIOD_M, SHARE = 0.4, 0.02
POSITIONS_M = np.linspace(0.0, 0.4, 21)
SPEEDS = "20 mm/s", "40 mm/s", "60 mm/s", "90 mm/s", "120 mm/s"


def rippled(share):
    """A short campaign with a ripple of the test cylinder; every deviation matters."""
    tight = {"friction": {"test": {"coulomb": "500 N", "stiction": "600 N"}}}
    data = merge(read_yaml(ROOT / "configs" / "bench-aau.yaml"), tight)
    bench = parse_bench(data, "bench")
    dry = plant_parameters(parse_plant(data, {}, "plant")).test.friction.coulomb
    wave = share * dry * np.cos(2 * np.pi * (POSITIONS_M - 0.195) / PERIOD_M)
    law = {
        "adds_to": "friction_test",
        "over": {"position": [f"{x:.3f} m" for x in POSITIONS_M]},
        "values": [f"{value:.6f} N" for value in wave],
    }
    hidden = parse_plant(data, merge({}, {"learned": [law]}), "hidden")
    made = record(bench, schedule(trials=2, speeds=SPEEDS), hidden, seed=3)
    assert not made.stopped
    return replace(campaign_of(made.runs, bench), material=0.0)


@pytest.fixture(scope="module")
def smooth():
    return rippled(0.0)


@pytest.mark.parametrize("cylinder", CYLINDERS)
def test_columns_are_the_changes_of_the_residuals(smooth, cylinder):
    """Dry friction turns with the velocity and bristles, a column has the friction of the log."""
    names = [ripple_name(cylinder, mode) for mode in (0, 4)]
    columns = smooth.columns(smooth.start, names)
    before = smooth.gap_map(smooth.start)
    at = BALANCES.index(f"force_{cylinder}")
    for name, column in columns.items():
        stepped = replace(smooth.start, disturbances={name: 1.0})
        change = before.difference - smooth.gap_map(stepped, before).difference
        size, off = np.nanmean(change[:, at] ** 2), np.nanmean((change - column)[:, at] ** 2)
        assert off < 0.05**2 * size
        others = np.arange(len(BALANCES)) != at
        assert not np.nan_to_num(change[:, others]).any() and not column[:, others].any()


def first_score(campaign):
    points = np.arange(len({point_of(run.plan) for log in campaign.logs for run in log.runs}))
    found = CampaignSearch(campaign, points, ("position_friction",)).run()
    (best,) = found.steps[0].evaluated
    return found, best.candidate.score


def test_a_ripple_of_two_percent_is_no_friction_over_position(monkeypatch):
    """Over the stroke of these runs its wave looks like a bow."""
    found, score = first_score(rippled(SHARE))
    assert not found.names
    monkeypatch.setattr(measured_campaign, "_RIPPLE", 1e-9)
    _, without = first_score(rippled(SHARE))
    print(score, without)
    assert score < 5 < without
