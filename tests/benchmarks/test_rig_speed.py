"""Speed of the virtual rig with the firmware in the loop, as a ratio to real time."""

from pathlib import Path

from hbench import workflow
from hbench.experiment.upload import uploads
from hbench.rig.client import BoardClient
from hbench.rig.settings import board_settings
from hbench.rig.virtual import VirtualRig

SCHEDULE = Path(__file__).parents[2] / "configs" / "stribeck.yaml"
SIMULATED_S = 20.0


def test_the_rig_runs_a_hundred_times_faster_than_the_bench(benchmark):
    """About 200 to 250 on one quiet core of 2024; the limit leaves room for a busy one."""
    experiment = workflow.load_experiment(SCHEDULE, None)
    rig = VirtualRig(experiment.bench)
    client = BoardClient(rig)
    upload = next(uploads(experiment.plans, client.identify()))
    schedule_crc = client.write_schedule(upload.segments, upload.steps)
    client.start(client.write_settings(board_settings(experiment.bench)), schedule_crc)

    def run():
        end = rig.now() + SIMULATED_S
        while rig.now() < end:
            assert client.status()["fault"] == 0
            client.wait(0.25)

    benchmark.pedantic(run, rounds=5, warmup_rounds=1)
    times_real = SIMULATED_S / benchmark.stats["min"]
    benchmark.extra_info["times real time"] = times_real
    print(f"{times_real:.0f} simulated seconds per second")
    assert times_real > 100
