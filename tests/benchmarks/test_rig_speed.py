"""Speed of the virtual rig with the firmware in the loop, on one core."""

import pytest

from hbench import workflow
from hbench.experiment.upload import uploads
from hbench.model.compiled import compiled
from hbench.model.sensing import convert
from hbench.model.simulated_bench import new_simulated_bench
from hbench.rig.board_settings import board_settings
from hbench.rig.client import BoardClient
from hbench.rig.virtual import VirtualRig
from tests.support import ROOT
from tests.support.benchmarks import STATES_IN_C, best_seconds, commands

SCHEDULE = ROOT / "configs" / "stribeck.yaml"
TICKS_PER_S = 10_000
SIMULATED_S = 5


@pytest.mark.parametrize("bench", ["moving", "stopped"])
def test_the_rig_takes_at_most_twice_the_time_of_its_plant_in_plain_c(bench, start, plant_in_c):
    """The rest is firmware, noise of the sensors, log and protocol. CPU time; see ``pytest -s``."""
    experiment = workflow.load_experiment(SCHEDULE, None)
    rig = VirtualRig(experiment.bench)
    client = BoardClient(rig)
    upload = next(uploads(experiment.plans[1:-1], client.identify()))  # without its zero checks
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
    u = commands(SIMULATED_S * TICKS_PER_S)
    rig_s, c_s = best_seconds(run, lambda: plant_in_c(start[STATES_IN_C], u), rounds=20)
    assert (client.status()["fault"] == 0) == (bench == "moving")
    speed, ratio = SIMULATED_S / rig_s, rig_s / c_s
    print(f"{bench}: {speed:.0f} simulated seconds per second, {ratio:.2f} of the plant in C")
    assert rig_s < 2 * c_s


@compiled
def converted(bench, ticks):
    words, codes, state, levels, noise, par, sensors, values, u, work = bench
    for _ in range(ticks):
        convert(values, par.oil_k, sensors, noise, words)


def test_converting_the_sensors_takes_less_than_a_quarter_of_the_plant_in_plain_c(
    start, plant_in_c
):
    """Noise, rounding and the converter's limits of seven channels."""
    bench = new_simulated_bench(workflow.load_experiment(SCHEDULE, None).bench, None, 1)
    bench.values[:] = 0.1, 15e5, 20e5, 15e5, 20e5, 150e5, 100.0, 0.0
    u = commands(SIMULATED_S * TICKS_PER_S)
    converted(bench, 1)
    ours_s, c_s = best_seconds(
        lambda: converted(bench, len(u)), lambda: plant_in_c(start[STATES_IN_C], u), rounds=20
    )
    print(f"sensors: {ours_s / c_s:.2f} of the plant in C")
    assert ours_s < 0.25 * c_s
