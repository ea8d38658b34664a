"""A bad line to a virtual rig, repeatable from its script, and what the board itself logged.

``World`` is the bench with its board, which goes on whatever happens to the host; ``World.open``
gives a session its ``FaultyLine``. ``Truth`` reads the board's log past the line.
"""

import ctypes
from collections import Counter, deque
from dataclasses import dataclass, field

import numpy as np

from hbench.config.bench import Bench
from hbench.errors import DeviceError
from hbench.protocol.dictionary import RECORD
from hbench.rig.firmware import HostFirmware, load_library
from hbench.rig.virtual import VirtualRig

RUN, INDEX, FLAGS = ([w.name for w in RECORD].index(n) for n in ("run", "index", "flags"))


@dataclass(frozen=True)
class Octets:
    """What happens to octets on their way in one direction: probabilities."""

    drop: float = 0.0
    flip: float = 0.0
    duplicate: float = 0.0
    delay: float = 0.0


@dataclass(frozen=True)
class Event:
    """Something that happens to the line or the board, at a time of the bench."""

    at_s: float
    kind: str  # vanish: errors until it is opened again; silence: nothing passes; reset
    duration_s: float = 0.0


@dataclass(frozen=True)
class Kill:
    """The host dies in one session: at a call of its port, or in the middle of a write."""

    session: int
    call: int | None = None
    write: int | None = None
    part: float = 0.0  # of that write's octets that are on disk
    politely: bool = False  # interrupted, and may clean up


@dataclass(frozen=True)
class Script:
    """All that goes wrong. Its ``repr`` is enough to repeat it."""

    seed: int = 0
    to_board: Octets = Octets()
    to_host: Octets = Octets()
    baud: int = 0  # 0: octets take no time
    chunk: int = 0  # most octets that a read returns; 0: all that there are
    events: tuple[Event, ...] = ()
    kills: tuple[Kill, ...] = ()
    pauses_s: tuple[float, ...] = (0.1,)  # of the operator, before each resume


class Killed(BaseException):
    """The host process is dead: nothing that it would still do happens."""


def random_script(number: int) -> Script:
    """Return script ``number`` of the sweep: faulty octets up to 1 % each way, and events."""
    rng = np.random.default_rng(number)

    def octets() -> Octets:
        total = rng.choice([0.0, 1e-4, 1e-3, 3e-3, 0.01])
        return Octets(*np.round(total * rng.dirichlet(np.ones(4)), 6).tolist())

    events = [
        Event(
            round(float(rng.uniform(0.0, 12.0)), 4),
            str(rng.choice(["vanish", "silence", "reset"])),
            round(float(rng.choice([0.05, 0.5, 1.5, 4.0]) * rng.uniform(0.5, 1.0)), 4),
        )
        for _ in range(rng.integers(0, 4))
    ]
    kills = []
    for session in range(rng.integers(0, 4)):
        moment = (
            {"call": int(rng.integers(1, 120))}
            if rng.random() < 0.5
            else {"write": int(rng.integers(0, 16)), "part": round(float(rng.random()), 3)}
        )
        kills.append(Kill(session, **moment, politely=bool(rng.random() < 0.3)))
    return Script(
        seed=number,
        to_board=octets(),
        to_host=octets(),
        baud=int(rng.choice([0, 115_200])),
        chunk=int(rng.choice([0, 0, 1, 7, 64])),
        events=tuple(sorted(events, key=lambda event: event.at_s)),
        kills=tuple(kills),
        pauses_s=tuple(np.round(rng.choice([0.1, 0.3, 2.5], 3), 1).tolist()),
    )


class Truth:
    """Every record that the board published, read past the line."""

    def __init__(self):
        self._copy = load_library().hb_probe_records
        self._copy.restype = ctypes.c_uint32
        self._copy.argtypes = (ctypes.c_void_p, ctypes.c_uint32, ctypes.c_void_p, ctypes.c_uint32)
        self._next = 0
        self._records = [np.zeros((0, len(RECORD)), np.uint16)]

    def sample(self, board: HostFirmware) -> np.ndarray:
        """Copy and return what is new; often enough that nothing has been overwritten."""
        words = np.zeros((256, len(RECORD)), np.uint16)
        count = self._copy(board.addresses[2], self._next, words.ctypes.data, len(words))
        assert count < len(words)
        self._next += count
        words = words[:count].copy()
        if count:
            self._records.append(words)
        return words

    def restart(self) -> None:
        """The board was reset and numbers its records from 0 again."""
        self._next = 0

    def words(self) -> np.ndarray:
        """Return all records so far."""
        return np.concatenate(self._records)


def attempts(words: np.ndarray) -> list[np.ndarray]:
    """Return the records of each motion that a board made, in order."""
    return np.split(words, np.flatnonzero(words[:, INDEX] == 0))[1:] if len(words) else []


@dataclass
class World:
    """A virtual rig that outlives its hosts, and a line to it on which a script is played."""

    bench: Bench
    script: Script
    truth: Truth = field(default_factory=Truth)
    counts: Counter = field(default_factory=Counter)  # what was injected
    boots: int = 1
    gone_until_s: float = 0.0
    silent_until_s: float = 0.0
    session: int = -1
    dead: bool = False  # the host of this session

    def __post_init__(self):
        self.rig = VirtualRig(self.bench, None, 1, self.script.baud)
        self._events = deque(self.script.events)
        self.rng = np.random.default_rng(self.script.seed)

    def open(self) -> "FaultyLine":
        """Begin a session. Raises ``DeviceError`` while the port is not there."""
        self.session += 1
        self.dead = False
        if self.rig.now() < self.gone_until_s:
            raise DeviceError("sim: can't open: no such device")
        return FaultyLine(self)

    def step(self, seconds: float) -> bytes:
        """Let time pass up to the next event, or until the board speaks."""
        if self._events:
            seconds = min(seconds, max(self._events[0].at_s - self.rig.now(), 0.0))
        said = self.rig.read(min(seconds, 1.0))
        self.truth.sample(self.rig._board)
        while self._events and self.rig.now() >= self._events[0].at_s:
            self._happen(self._events.popleft())
        return said

    def wait(self, seconds: float) -> None:
        """Let time pass with nobody on the line."""
        end_s = self.rig.now() + seconds
        while self.rig.now() < end_s:
            self.step(end_s - self.rig.now())

    def kill(self) -> Kill | None:
        """Return how this session's host is to die."""
        return next((kill for kill in self.script.kills if kill.session == self.session), None)

    def die(self) -> None:
        """The host is killed, or interrupted."""
        if self.kill().politely:
            self.counts["interrupt"] += 1
            raise KeyboardInterrupt
        self.counts["kill"] += 1
        self.dead = True
        raise Killed

    def check_alive(self) -> None:
        """Raise ``Killed`` once the host is dead."""
        if self.dead:
            raise Killed

    def _happen(self, event: Event) -> None:
        self.counts[event.kind] += 1
        end_s = self.rig.now() + event.duration_s
        if event.kind == "vanish":
            self.gone_until_s = end_s
        elif event.kind == "silence":
            self.silent_until_s = end_s
        else:
            self.boots += 1
            self.rig._board.close()
            self.rig._board = HostFirmware(self.boots, self.script.baud)
            self.truth.restart()


class FaultyLine:
    """A session's port. Octets keep their order; one that is late makes those behind it late."""

    name = "sim"

    def __init__(self, world: World):
        self._world = world
        self._rig = world.rig
        self._to_board: deque[tuple[float, int]] = deque()  # (due, octet)
        self._to_host: deque[tuple[float, int]] = deque()
        self._calls = 0
        self._lost = False
        self._kill = world.kill()

    def write(self, data: bytes) -> None:
        """Send octets, some of which get hurt."""
        self._use()
        self._send(data, self._to_board, self._world.script.to_board)
        self._deliver()

    def read(self, timeout_s: float) -> bytes:
        """Return the octets that are due, or nothing after the timeout."""
        self._use()
        end_s = self._rig.now() + timeout_s
        while not (said := self._due()) and (left := end_s - self._rig.now()) > 0:
            queues = (queue[0][0] for queue in (self._to_board, self._to_host) if queue)
            step_s = min([left, *(due - self._rig.now() for due in queues)])
            heard = self._world.step(max(step_s, 0.0))
            self._send(heard, self._to_host, self._world.script.to_host)
            self._deliver()
            self._use(call=0)
        return said

    def now(self) -> float:
        """Bench time."""
        return self._rig.now()

    def close(self) -> None:
        """Leave; the bench goes on."""

    def _use(self, call: int = 1) -> None:
        """Die, or notice that the port is gone, as the script says."""
        self._calls += call
        if call and self._kill and self._kill.call == self._calls:
            self._world.die()
        self._world.check_alive()
        self._lost |= self._rig.now() < self._world.gone_until_s
        if self._lost:
            raise DeviceError("sim: can't read: the device has vanished")

    def _send(self, data: bytes, queue: deque, odds: Octets) -> None:
        world, now = self._world, self._rig.now()
        due = max(now, queue[-1][0]) if queue else now
        if now < world.silent_until_s:
            return
        limits = np.cumsum([odds.drop, odds.flip, odds.duplicate, odds.delay])
        fates = np.searchsorted(limits, world.rng.random(len(data)), side="right")
        for octet, fate in zip(data, fates, strict=True):
            if fate < 4:
                world.counts[("drop", "flip", "duplicate", "delay")[fate]] += 1
            if fate == 1:
                octet ^= 1 << int(world.rng.integers(8))
            elif fate == 3:
                due += float(world.rng.choice([0.002, 0.02, 0.3]))
            if fate != 0:
                queue.append((due, octet))
            if fate == 2:
                queue.append((due, octet))

    def _deliver(self) -> None:
        self._rig.write(self._take(self._to_board, 0))

    def _due(self) -> bytes:
        most = self._world.script.chunk
        return self._take(self._to_host, int(self._world.rng.integers(1, most + 1)) if most else 0)

    def _take(self, queue: deque, most: int) -> bytes:
        taken = bytearray()
        while queue and queue[0][0] <= self._rig.now() and (not most or len(taken) < most):
            taken.append(queue.popleft()[1])
        return bytes(taken)
