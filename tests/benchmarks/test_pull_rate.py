"""How much of a serial line a pull of the log fills, with its window and by stop-and-wait.

Octets are paced in simulated time. The adapter is modelled on FTDI's USB converters: octets reach
the host when 62 of them have come or 16 ms after the first (AN232B-04, latency timer).
"""

from pathlib import Path

import pytest

from hbench import workflow
from hbench.experiment.upload import uploads
from hbench.protocol.dictionary import RECORD
from hbench.rig.board_settings import board_settings
from hbench.rig.client import PULL_WINDOW, BoardClient
from hbench.rig.virtual import VirtualRig

SCHEDULE = Path(__file__).parents[2] / "configs" / "stribeck.yaml"
RECORDS = 800
WINDOWS = {"stop-and-wait": 1, f"window of {PULL_WINDOW}": PULL_WINDOW}


class Adapter:
    """A port behind a USB converter that gathers octets before it hands them on."""

    packet, latency_s = 62, 0.016

    def __init__(self, port):
        self.port, self.name = port, port.name
        self.write, self.now = port.write, port.now
        self.held, self.since_s = b"", 0.0

    def read(self, timeout_s):
        end_s = self.now() + timeout_s
        while len(self.held) < self.packet and self.now() < end_s:
            if self.held and self.now() >= self.since_s + self.latency_s:
                whole, self.held = self.held, b""
                return whole
            came = self.port.read(0.0)
            if came and not self.held:
                self.since_s = self.now()
            self.held += came
        whole = len(self.held) // self.packet * self.packet
        data, self.held = self.held[:whole], self.held[whole:]
        self.since_s = self.now()
        return data


@pytest.mark.parametrize("adapter", [None, Adapter], ids=["direct", "usb"])
@pytest.mark.parametrize("baud", [115_200, 921_600])
def test_a_window_fills_the_line_that_stop_and_wait_does_not(baud, adapter):
    """Shares of baud/10 octets a second that are records; frames allow 240/254 = 0.945.

    The adapter's 16 ms at the end of a pull are in it: 6 % of the 0.28 s at 921 600 baud.
    """
    experiment = workflow.load_experiment(SCHEDULE, None)
    rig = VirtualRig(experiment.bench, None, 1, baud)
    client = BoardClient(rig)
    upload = next(uploads(experiment.plans[1:-1], client.identify()))  # no zero checks
    schedule_crc = client.write_schedule(upload.segments, upload.steps)
    client.start(client.write_settings(board_settings(experiment.bench)), schedule_crc)
    while (until := client.status()["log_next"]) < RECORDS:
        client.wait(1.0)
    client.stop()
    client = BoardClient(adapter(rig) if adapter else rig)
    shares = {}
    for name, window in WINDOWS.items():
        begin_s = rig.now()
        got = sum(len(part.words) for part in client.pull(until - RECORDS, until, window))
        assert got == RECORDS
        shares[name] = got * 2 * len(RECORD) / ((rig.now() - begin_s) * baud / 10)
    print(f"{baud} baud: " + ", ".join(f"{n} {share:.3f}" for n, share in shares.items()))
    assert shares[f"window of {PULL_WINDOW}"] > (0.85 if adapter else 0.9)
    assert shares[f"window of {PULL_WINDOW}"] > shares["stop-and-wait"]
