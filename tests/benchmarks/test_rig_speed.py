"""Speed of the virtual rig with the firmware in the loop, on one core."""

import time
from pathlib import Path

import pytest

from hbench import workflow
from hbench.experiment.upload import uploads
from hbench.rig.board_settings import board_settings
from hbench.rig.client import BoardClient
from hbench.rig.virtual import VirtualRig

SCHEDULE = Path(__file__).parents[2] / "configs" / "stribeck.yaml"
SIMULATED_S = 5.0
ROUNDS = 20


@pytest.mark.parametrize("bench", ["moving", "stopped"])
def test_the_rig_runs_two_hundred_times_faster_than_the_bench(bench):
    """Simulated seconds per second of CPU time, the best of some rounds.

    Some 400 on one core of 2024 (``pytest -s``); the limit leaves room for a slower or busy one.
    """
    experiment = workflow.load_experiment(SCHEDULE, None)
    rig = VirtualRig(experiment.bench)
    client = BoardClient(rig)
    upload = next(uploads(experiment.plans, client.identify()))
    schedule_crc = client.write_schedule(upload.segments, upload.steps)
    client.start(client.write_settings(board_settings(experiment.bench)), schedule_crc)

    def run():
        end = rig.now() + SIMULATED_S
        while rig.now() < end:
            client.status()
            client.wait(0.25)

    run()
    if bench == "stopped":
        client.stop()
    best_s = float("inf")
    for _ in range(ROUNDS):
        before = time.process_time()
        run()
        best_s = min(best_s, time.process_time() - before)
    assert (client.status()["fault"] == 0) == (bench == "moving")
    print(f"{bench}: {SIMULATED_S / best_s:.0f} simulated seconds per second")
    assert SIMULATED_S / best_s > 200
