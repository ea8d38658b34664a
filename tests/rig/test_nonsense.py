"""A device that talks nonsense ends in one clear error, soon; what has not come is not made up."""

import os
import pty
import threading
import time
import tty

import numpy as np
import pytest

from hbench.cli.main import main
from hbench.errors import DeviceError, ExitCode
from hbench.experiment.runner import run_campaign
from hbench.protocol.codec import BY_NAME, pack
from hbench.protocol.dictionary import ERROR, PROTOCOL, RECORD, REPLY, STATES, dictionary_hash
from hbench.protocol.frames import Frame, Receiver, encode
from hbench.rig.client import ATTEMPTS, REPLY_TIMEOUT_S, BoardClient, NoAnswer, Refused

OCTETS_S = 11_520.0  # on the line
CODES = {message.code: message for message in BY_NAME.values()}
WHO = {"protocol": PROTOCOL, "dictionary": dictionary_hash(), "rate_hz": 10000, "boots": 1}


class Babbler:
    """A port whose far end talks without being asked: ``talk(n)`` is its n-th word."""

    name = "babbler"

    def __init__(self, talk):
        self.talk = talk
        self.words = 0
        self.time_s = 0.0

    def write(self, data):
        pass

    def read(self, timeout_s):
        self.words += 1
        said = self.talk(self.words)
        self.time_s += min(len(said) / OCTETS_S, timeout_s) or timeout_s
        return said

    def now(self):
        return self.time_s

    def close(self):
        pass


def random_octets(n):
    return np.random.default_rng(n).bytes(100)


def foreign_reply(n):
    return encode(Frame(n % 250 + 5, BY_NAME["identify"].code | REPLY, bytes(50)))


NONSENSE = {
    "random octets": random_octets,
    "zeros": lambda n: bytes(100),
    "ones": lambda n: b"\xff" * 100,
    "another protocol's text": lambda n: b"$GPGGA,123519,4807.038,N,01131.000,E,1,08*47\r\n",
    "one frame without end": lambda n: b"\x05hbench" * 1000,
    "huge frames": lambda n: b"\x05hbench" * 1000 + b"\0",
    "replies to what was not asked": foreign_reply,
    "silence": lambda n: b"",
}


@pytest.mark.parametrize("kind", NONSENSE)
def test_nonsense_without_end_is_no_board_and_costs_the_time_of_silence(kind):
    line = Babbler(NONSENSE[kind])
    with pytest.raises(NoAnswer, match=r"babbler: .*'identify' .*\b8\b") as error:
        BoardClient(line).identify()
    assert error.value.exit_code == ExitCode.DEVICE
    assert "port" in error.value.hint
    assert line.time_s < ATTEMPTS * REPLY_TIMEOUT_S + 1.0


class Liar(Babbler):
    """A port whose far end answers each request with the octets of ``answer(frame)``."""

    name = "liar"

    def __init__(self, answer):
        super().__init__(lambda n: b"")
        self.answer = answer
        self.receiver = Receiver()
        self.waiting = b""

    def write(self, data):
        for frame in self.receiver.feed(data):
            self.waiting += self.answer(frame)

    def read(self, timeout_s):
        said, self.waiting = self.waiting, b""
        self.time_s += 0.001 if said else timeout_s
        return said


def test_a_plug_that_echoes_is_no_board():
    with pytest.raises(NoAnswer, match="'identify'"):
        BoardClient(Liar(encode)).identify()


@pytest.mark.parametrize("length", [0, 1, 47, 49, 200])
def test_an_identity_of_another_length_is_refused(length):
    line = Liar(lambda f: encode(Frame(f.sequence, f.code | REPLY, bytes(length))))
    with pytest.raises(DeviceError, match="liar: (reply to 'identify'|firmware .* protocol 0,)"):
        BoardClient(line).identify()


@pytest.mark.parametrize("payload", [b"", b"\1", b"\1\0\xff", bytes(200)])
def test_a_refusal_of_any_length_is_a_refusal(payload):
    line = Liar(lambda f: encode(Frame(f.sequence, ERROR, payload)))
    with pytest.raises(Refused, match="'identify'"):
        BoardClient(line).identify()


def lie(rng):
    """A board that knows who it is and makes up all the rest, in replies of the right form."""

    def answer(frame):
        message = CODES[frame.code]
        values = {name: made_up(rng, name, kind) for name, kind in message.reply}
        if message.name == "identify":
            values |= WHO | {"ring_records": 1024, "max_steps": 128, "max_segments": 128}
        return encode(Frame(frame.sequence, frame.code | REPLY, pack(message.reply, values)))

    return answer


def made_up(rng, name, kind):
    if name == "state":
        return int(rng.integers(0, len(STATES) + 1))
    if name == "run":
        return int(rng.integers(0, 6))
    if kind == "text16":
        return "liar"
    if kind == "words":
        return rng.integers(0, rng.choice([3, 2**16]), len(RECORD) * int(rng.integers(0, 8)))
    if kind == "f32":
        return float(rng.choice([0.0, 1e30, np.nan, -np.inf]))
    most = {"u16": 2**16, "u32": 2**32}[kind]
    return int(rng.integers(0, rng.choice([2, 20, 2000, most])))


class NoJournal:
    """Takes the parts of runs and keeps the outcomes."""

    def __init__(self):
        self.outcomes = []

    def start_run(self, plan, at, after_rejection):
        pass

    def finish_run(self, plan, words, outcome, why, at):
        self.outcomes.append(outcome)


@pytest.mark.parametrize("seed", range(100))
def test_a_board_that_makes_up_its_answers_ends_a_campaign_in_a_clear_error(
    quick_experiment, clock, seed
):
    line, journal = Liar(lie(np.random.default_rng(seed))), NoJournal()
    with pytest.raises(DeviceError) as error:
        run_campaign(
            quick_experiment.plans,
            quick_experiment.bench,
            BoardClient(line),
            journal,
            clock,
            lambda progress: None,
            resume=True,
        )
    assert error.value.message and line.time_s < 60.0
    assert "done" not in journal.outcomes


def test_the_command_line_says_so_with_exit_code_3(quick_schedule, tmp_path, monkeypatch, capsys):
    """On a pseudo-terminal whose far end sends another protocol's text."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    stop = threading.Event()

    def talk():
        while not stop.wait(0.01):
            try:
                os.write(master, NONSENSE["another protocol's text"](0))
            except BlockingIOError:
                pass

    thread = threading.Thread(target=talk)
    thread.start()
    port, begin = os.ttyname(slave), time.monotonic()
    arguments = ["run", quick_schedule(), "-o", tmp_path / "out", "--port", port]
    monkeypatch.setattr("sys.argv", ["hbench", *map(str, arguments)])
    try:
        with pytest.raises(SystemExit) as end:
            main()
    finally:
        stop.set()
        thread.join()
        os.close(master)
        os.close(slave)
    told = capsys.readouterr().err
    assert end.value.code == 3 and f"error: {port}: " in told
    assert "Traceback" not in told and time.monotonic() - begin < 10.0
    assert not (tmp_path / "out").exists()
