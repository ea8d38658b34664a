"""Runs a plan on a board: uploads it, follows it, pulls every run's log and journals it.

The log is pulled while the runs go on. A run's raw log is on disk before its stop part is in the
journal, and both are there before anything is derived. Whatever ends the campaign early, the
board is told to stop; a board that can't hear that stops by its heartbeat limit.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import numpy as np

from hbench.config.bench import Bench
from hbench.errors import ConfigError, DeviceError
from hbench.experiment.upload import uploads
from hbench.protocol.dictionary import FAULTS, FLAGS, RECORD, STATES
from hbench.records import Outcome, RunPlan
from hbench.rig.client import BoardClient, Identity, NoAnswer
from hbench.rig.settings import board_settings
from hbench.store.campaign import CampaignWriter

POLL_S = 0.25  # between two looks at the board
LEAST_LOG_S = 4.0  # that its log must hold: some lost looks and their repetitions
END_MISSING = "the end of its log is missing"
OVERRUN = "{} records were overwritten before they were pulled: the log ran over"

# What the board's latched causes mean on the bench.
FAULT_WORDS = {
    "heartbeat": "it had not heard its host for longer than limits.heartbeat",
    "sensor": "the position or a pressure reads what its sensor can't give; look at the wires",
    "travel": "the piston left limits.travel, or was about to",
    "pressure": "a pressure was above limits.pressure_max",
    "speed": "the piston was faster than limits.speed_max",
    "speed_error": "for limits.speed_error_time the speed was off its reference by more than "
    "limits.speed_error",
    "overrun": "its control interrupt came late or took too long",
    "return": "the piston did not come back to the start of a run in time",
}

_WORDS = [word.name for word in RECORD]
_RUN, _INDEX, _FLAGS = (_WORDS.index(name) for name in ("run", "index", "flags"))
_LAST, _SETTLED = (1 << FLAGS.index(name) for name in ("last", "settled"))


@dataclass(frozen=True)
class Progress:
    """Where a campaign stands."""

    runs_done: int
    runs_total: int
    plan: RunPlan  # the run that is being made
    v_m_s: float
    f_applied_n: float
    at_most: bool = False  # the total is not known yet: it may become less


def run_campaign(
    plans: Sequence[RunPlan],
    bench: Bench,
    client: BoardClient,
    journal: CampaignWriter,
    clock: Callable[[], datetime],
    report: Callable[[Progress], None],
    resume: bool = False,
) -> None:
    """Make all runs of ``plans`` and journal them.

    A board that still runs for an earlier host, or that has stopped itself, is taken over only
    with ``resume`` (see ``bring_to_rest``). Raises ``ConfigError`` where bench file and board
    differ, and ``DeviceError`` when the board faults or the line is lost; what was measured until
    then is in the journal.
    ``DeviceError`` too where all steps have been made and some runs failed.
    """
    identity = client.identify()
    _check_rates(bench, identity)
    bring_to_rest(client, resume)
    settings_crc = client.write_settings(board_settings(bench))
    recorder = _Recorder(plans, journal, clock)
    try:
        for upload in uploads(plans, identity):
            schedule_crc = client.write_schedule(upload.segments, upload.steps)
            number = client.status()["log_next"]  # the board is idle: what it holds is not ours
            client.start(settings_crc, schedule_crc)
            _follow(client, recorder, report, number)
    except BaseException as error:
        _stop(client)  # first of all: what follows may fail too
        cause = _cause(error, client, identity, recorder.current)
        recorder.abandon(cause)
        raise cause from None
    recorder.close()


def _check_rates(bench: Bench, identity: Identity) -> None:
    control = bench.controllers
    if control.rate != identity.rate_hz:
        raise ConfigError(
            f"controllers.rate = {control.rate:g} Hz, but the board controls at "
            f"{identity.rate_hz} Hz"
        )
    held_s = identity.ring_records / control.log_rate
    if held_s < LEAST_LOG_S:
        raise ConfigError(
            f"controllers.log_rate = {control.log_rate:g} Hz: the board's log would hold "
            f"{held_s:.1f} s; at least {LEAST_LOG_S:g} s are needed to pull it in time"
        )


def bring_to_rest(client: BoardClient, allowed: bool) -> None:
    """Bring the board to rest, whatever an earlier host left, or raise ``DeviceError``."""
    status = client.status()
    state = STATES[status["state"]]
    if state == "fault" and not allowed:
        raise DeviceError(
            f"the board has stopped itself: {_fault(status)}",
            "Look at the bench, then give --take-over, or go on with --resume.",
        )
    if state == "running" and not allowed:
        raise DeviceError(
            "the board is running a schedule that another host began",
            "Wait until it stops itself, or stop it with --take-over or --resume.",
        )
    if state == "running":
        client.stop()
    elif state == "fault":
        client.clear_fault()


def _follow(client: BoardClient, recorder: "_Recorder", report: Callable, number: int) -> None:
    """Watch the board through one upload, pulling records from ``number`` until it is done."""
    while True:
        status = client.status()
        state = STATES[status["state"]]
        # First, so that a run is whole before the next begins.
        for part in client.pull(number, status["log_next"]):
            recorder.lose(part.lost)
            recorder.feed(part.words)
        number = status["log_next"]
        if state in ("running", "fault"):
            recorder.begin(status["run"])
        if recorder.current:
            report(recorder.progress(status))
        if state == "fault":
            raise DeviceError(
                f"run {status['run']:04d}: the board stopped itself: {_fault(status)}",
                "Look at the bench, then go on with --resume.",
            )
        if state == "done":
            recorder.finish("failed", END_MISSING)
            return
        if state != "running":
            raise DeviceError(
                f"{_where(recorder.current)}: the board was stopped from elsewhere",
                "Go on with --resume.",
            )
        client.wait(POLL_S)


def _stop(client: BoardClient) -> None:
    """Ask for neutral valves; a board out of reach has its heartbeat limit for that."""
    with suppress(DeviceError):
        client.stop()


def _cause(
    error: BaseException, client: BoardClient, identity: Identity, run: str
) -> BaseException:
    """Return what ended the campaign: a lost line and a reset explain whatever came of them."""
    if not isinstance(error, DeviceError):
        return error
    try:
        if isinstance(error, NoAnswer):
            raise error
        reset = client.identify().boots != identity.boots
    except DeviceError:
        return DeviceError(
            f"{_where(run)}: the line to the board is lost: {error.message}",
            "Without its host the board stops itself. Check power and cable, then go on with "
            "--resume.",
        )
    if reset:
        return DeviceError(
            f"{_where(run)}: the board was reset", "Check its supply, then go on with --resume."
        )
    return error


def _fault(status: Mapping[str, Any]) -> str:
    name = FAULTS[status["fault"]]
    return f"{name}: {FAULT_WORDS.get(name, 'a cause that this state does not have')}"


def _ending(plan: RunPlan, flags: int) -> str:
    """What to say of a run that came to its end: whether what it waited for has settled."""
    motion = plan.motion
    if motion.until == "cycles":
        return ""
    quantity = motion.until.replace("_", " ")
    if flags & _SETTLED:
        return f"{quantity} settled within {100 * motion.within:g} %"
    return (
        f"{quantity} had not settled within {100 * motion.within:g} % after {motion.cycles} cycles"
    )


def _where(run: str) -> str:
    return f"run {run}" if run else "between two runs"


class _Recorder:
    """Sorts pulled records into runs and journals each at its start and its end.

    Only a run of which all records have come, up to its last, is done.
    """

    def __init__(
        self, plans: Iterable[RunPlan], journal: CampaignWriter, clock: Callable[[], datetime]
    ):
        self._plans = {int(plan.run): plan for plan in plans}
        self._journal = journal
        self._clock = clock
        self._words: list[np.ndarray] = []
        self._number = 0  # of the run that is being made; 0: none
        self._lost = 0  # records of that run, at most
        self._gap = 0  # records lost right before the next one
        self._finished: dict[int, Outcome] = {}

    @property
    def current(self) -> str:
        """Id of the run that is being made; empty between runs."""
        return self._plans[self._number].run if self._number else ""

    def progress(self, status: dict) -> Progress:
        """Return where the campaign stands."""
        plan = self._plans[self._number]
        done, total = len(self._finished), len(self._plans)
        return Progress(done, total, plan, status["v_m_s"], status["f_applied_n"])

    def begin(self, number: int) -> None:
        """A run has started, as its status or its first record tells.

        The board still names a run while it brakes after the last record; that starts nothing.
        """
        if number == self._number or number in self._finished:
            return
        if number not in self._plans:
            raise DeviceError(f"the board reports run {number}, which is not in the plan")
        self.finish("failed", END_MISSING)
        self._journal.start_run(self._plans[number], self._clock())
        self._number = number

    def lose(self, count: int) -> None:
        """The next ``count`` records are gone, whichever runs' they were."""
        self._gap += count
        if self._number:
            self._lost += count

    def feed(self, words: np.ndarray) -> None:
        """Take records in order: (n, words of a record)."""
        edges = np.flatnonzero(np.diff(words[:, _RUN])) + 1
        for piece in np.split(words, edges) if len(words) else ():
            self.begin(int(piece[0, _RUN]))
            if not self._words and piece[0, _INDEX]:
                self._lost = self._gap  # it held this run's beginning
            self._gap = 0
            if not self._number:
                raise DeviceError(f"the board sent records of run {piece[0, _RUN]} after its last")
            self._words.append(piece)
            if piece[-1, _FLAGS] & _LAST:
                self.finish("done", _ending(self._plans[self._number], piece[-1, _FLAGS]))

    def finish(self, outcome: Outcome, why: str) -> None:
        """The run is over: its log to disk, then its stop part to the journal."""
        if not self._number:
            return
        plan = self._plans[self._number]
        words = np.concatenate(self._words) if self._words else np.zeros((0, len(RECORD)), "<u2")
        if self._lost and (outcome == "done" or why == END_MISSING):
            outcome, why = "failed", OVERRUN.format(self._lost)
        self._finished[self._number] = outcome
        self._words, self._number, self._lost = [], 0, 0
        self._journal.finish_run(plan, words, outcome, why, self._clock())

    def abandon(self, error: BaseException) -> None:
        """Something ended the campaign in the middle of a run."""
        interrupted = not isinstance(error, Exception)
        why = "interrupted by the operator" if interrupted else str(error) or type(error).__name__
        self.finish("aborted" if interrupted else "failed", why)

    def close(self) -> None:
        """All steps have been made. Raises ``DeviceError`` if runs failed."""
        for number in [n for n in self._plans if n not in self._finished]:
            self.begin(number)
            self.finish("failed", "all its records were overwritten: the log ran over")
        failed = [plan.run for n, plan in self._plans.items() if self._finished[n] == "failed"]
        if failed:
            raise DeviceError(
                f"{len(failed)} of {len(self._plans)} runs failed: {', '.join(failed)}",
                "Make them again with --resume. Where the log ran over, a faster line (--baud) or "
                "a lower controllers.log_rate helps.",
            )
