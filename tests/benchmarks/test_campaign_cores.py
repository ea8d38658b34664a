"""Campaigns of several seeds: how much sooner two cores have made them than one."""

import os
import time
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import pytest

from hbench import workflow
from hbench.parallel import process_pool

SCHEDULE = Path(__file__).parents[2] / "configs" / "stribeck.yaml"
CAMPAIGNS = 6


@pytest.mark.slow
def test_two_cores_make_campaigns_1_8_times_as_fast(tmp_path, monkeypatch):
    """Wall time with all that it takes to start, so on a machine that has nothing else to do."""
    if process_pool.usable_cores() < 2 or os.getloadavg()[0] > 0.5:
        pytest.skip("needs two idle cores")
    experiment = workflow.load_experiment(SCHEDULE, None)
    wall, cpu = {}, {}
    for count in (1, 2):
        monkeypatch.setattr(process_pool, "usable_cores", lambda count=count: count)
        before, used = time.perf_counter(), _cpu_s()
        workflow.measure_seeds(
            experiment,
            tmp_path / str(count),
            workflow.Line(seed=0),
            CAMPAIGNS,
            resume=False,
            clock=partial(datetime.fromtimestamp, 0, UTC),
            report=lambda done: None,
        )
        wall[count], cpu[count] = time.perf_counter() - before, _cpu_s() - used
        print(f"{count} at a time: {wall[count]:.1f} s, {cpu[count]:.1f} s of CPU time")
    assert wall[1] > 1.8 * wall[2]


def _cpu_s() -> float:
    """Of this process and of the children that have ended."""
    return sum(os.times()[:4])
