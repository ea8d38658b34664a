"""Runner of a plan on a board: uploads it, follows it, pulls and journals each run's log.

The log is pulled during the runs. A run's raw log is on disk before its stop part is in the
journal, and both before anything is derived. Whatever ends the campaign early, the runner stops
the board; a board out of reach stops itself at its heartbeat limit.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from datetime import datetime
from typing import Any

from hbench.analysis.screening.by_kind import SUPPLY_OFF_PA
from hbench.config.bench import Bench
from hbench.errors import ConfigError, DeviceError
from hbench.experiment.progress import Report
from hbench.experiment.recorder import END_MISSING, Judge, Recorder
from hbench.experiment.run_journal import Journal
from hbench.experiment.upload import Upload, uploads
from hbench.protocol.dictionary import FAULTS, STATES
from hbench.records import KINDS, RunPlan
from hbench.rig.board_settings import board_settings
from hbench.rig.client import BoardClient, Identity, NoAnswer

POLL_S = 0.25  # between two status requests
_SUPPLY_ON = 0.8  # of the supply's pressure
_SUPPLY_S = 600.0  # longest wait for the operator
LEAST_LOG_S = 4.0  # capacity of the board's log: some lost requests and their repetitions

# The board's latched faults in words.
FAULT_WORDS = {
    "heartbeat": "no message from the host for longer than limits.heartbeat",
    "sensor": "the position or a pressure is outside its sensor's range; check the wiring",
    "travel": "the piston left limits.travel, or could not stop within it",
    "pressure": "a pressure was above limits.pressure_max",
    "speed": "the speed was above limits.speed_max",
    "speed_error": "the speed was off its reference by more than limits.speed_error for "
    "limits.speed_error_time",
    "overrun": "the control interrupt was late or took too long",
    "return": "the piston did not return to the start of a run in time",
    "load": "the references of the load's pressures were not reached in time",
    "supply": "the supply was on during a zero check",
}


def run_campaign(
    plans: Sequence[RunPlan],
    bench: Bench,
    client: BoardClient,
    journal: Journal,
    clock: Callable[[], datetime],
    report: Report,
    resume: bool = False,
    judge: Judge | None = None,
    retry: int = 0,
) -> None:
    """Make all runs of ``plans`` and journal them.

    A run that ``judge`` rejects is repeated at once, up to ``retry`` times. With ``retry`` the
    board gets one run at a time, and rests in between with its valves in neutral.

    A board that still runs for an earlier host, or that has stopped itself, is taken over only
    with ``resume`` (see ``bring_to_rest``). Raises ``ConfigError`` where bench file and board
    differ, and ``DeviceError`` when the board faults, the line is lost or runs failed; all runs
    made until then are in the journal.
    """
    identity = client.identify()
    _check_rates(bench, identity)
    bring_to_rest(client, resume)
    settings_crc = client.write_settings(board_settings(bench))
    recorder = Recorder(plans, bench, journal, clock, judge, retry)
    try:
        for batch in [[plan] for plan in plans] if retry else [plans]:
            _make(batch, client, identity, settings_crc, recorder, report)
            while retry and recorder.again(batch[0]):
                _make(batch, client, identity, settings_crc, recorder, report)
    except BaseException as error:
        cause = error
        try:
            _stop(client)  # first, since the next lines may fail too
            cause = _cause(error, client, identity, recorder.current)
        finally:  # also where the operator interrupts again
            recorder.abandon(cause)
        raise cause from None
    recorder.close()


def _make(
    plans: Sequence[RunPlan],
    client: BoardClient,
    identity: Identity,
    settings_crc: int,
    recorder: Recorder,
    report: Report,
) -> None:
    for upload in uploads(plans, identity):
        schedule_crc = client.write_schedule(upload.segments, upload.steps)
        if upload.supply_is_off != recorder.supply_is_off:
            _await_supply(client, upload, recorder, report)
        number = client.status()["log_next"]  # records before are of an earlier host
        client.start(settings_crc, schedule_crc)
        _follow(client, recorder, report, number, upload.longest_rest_s(recorder.bench))


def _await_supply(client: BoardClient, upload: Upload, recorder: Recorder, report: Report) -> None:
    """Wait, with the valves in neutral, until the operator has switched the supply off or on.

    Raises ``DeviceError`` after ten minutes.
    """
    off, plan = upload.supply_is_off, upload.first
    assert plan is not None  # every upload has runs
    limit_pa = SUPPLY_OFF_PA if off else _SUPPLY_ON * recorder.bench.supply.pressure
    deadline = client.port.now() + _SUPPLY_S
    while True:
        status = client.status()
        p_s_pa = status["p_s_pa"]
        if (p_s_pa < limit_pa) == off:
            recorder.supply_is_off = off
            return
        what = (
            f"switch the supply {'off' if off else 'on'}: P_S is {p_s_pa / 1e5:.1f} bar, "
            f"{'below' if off else 'above'} {limit_pa / 1e5:.4g} bar is needed"
        )
        if client.port.now() > deadline:
            raise DeviceError(
                f"run {plan.run} ({KINDS[plan.kind].display_name}) was not started: {what}; limit "
                f"{_SUPPLY_S:g} s",
                "Continue with --resume.",
            )
        report(recorder.waiting(status, plan, what))
        client.wait(POLL_S)


def _check_rates(bench: Bench, identity: Identity) -> None:
    control = bench.controllers
    if control.rate != identity.rate_hz:
        raise ConfigError(
            f"controllers.rate = {control.rate:g} Hz, but the board's rate is "
            f"{identity.rate_hz} Hz",
            f"Set controllers.rate to {identity.rate_hz} Hz.",
        )
    held_s = identity.ring_records / control.log_rate
    if held_s < LEAST_LOG_S:
        raise ConfigError(
            f"controllers.log_rate = {control.log_rate:g} Hz: the board's log holds "
            f"{held_s:.1f} s; limit {LEAST_LOG_S:g} s",
            "Lower controllers.log_rate, so that the log can be pulled in time.",
        )


def bring_to_rest(client: BoardClient, allowed: bool) -> None:
    """Stop the board or clear its fault if ``allowed``; otherwise raise ``DeviceError``."""
    status = client.status()
    state = STATES[status["state"]]
    if state == "fault" and not allowed:
        raise DeviceError(
            f"the board has stopped itself: {_fault(status)}",
            "Check the bench, then give --take-over, or continue with --resume.",
        )
    if state == "running" and not allowed:
        raise DeviceError(
            "the board is running a schedule of another host",
            "Wait until it stops, or stop it with --take-over or --resume.",
        )
    if state == "running":
        client.stop()
    elif state == "fault":
        client.clear_fault()


def _follow(
    client: BoardClient, recorder: Recorder, report: Report, number: int, longest_rest_s: float
) -> None:
    """Follow the board through one upload, and pull its records from ``number`` on.

    Raises ``DeviceError`` if it is running without a record for longer than ``longest_rest_s``.
    """
    recorded_s = client.port.now()
    while True:
        status = client.status()
        state = STATES[status["state"]]
        if status["log_next"] > number:
            recorded_s = client.port.now()
        elif state == "running" and client.port.now() - recorded_s > longest_rest_s:
            raise DeviceError(
                f"run {status['run']:04d}: the board is running, but logged nothing for "
                f"{client.port.now() - recorded_s:.0f} s; limit {longest_rest_s:.0f} s",
                "Reset the board, then continue with --resume.",
            )
        if status["log_next"] < number:
            raise DeviceError(
                f"{_where(recorder.current)}: the board reports {status['log_next']} records; "
                f"before it reported {number}",
                "Reset the board, then continue with --resume.",
            )
        # Before the status counts, so that a run is complete before the next begins.
        for part in client.pull(number, status["log_next"]):
            recorder.lose(part.lost)
            recorder.feed(part.words)
        number = status["log_next"]
        recorder.follow(status)
        if state in ("running", "fault"):
            recorder.begin(status["run"])
        if state == "done":
            recorder.finish("failed", END_MISSING)
        if progress := recorder.progress(status):
            report(progress)
        if state == "fault":
            raise DeviceError(
                f"run {status['run']:04d}: the board stopped itself: {_fault(status)}",
                "Check the bench, then continue with --resume.",
            )
        if state == "done":
            return
        if state != "running":
            raise DeviceError(
                f"{_where(recorder.current)}: the board was stopped from elsewhere",
                "Continue with --resume.",
            )
        client.wait(POLL_S)


def _stop(client: BoardClient) -> None:
    """Stop the board; one out of reach stops itself at its heartbeat limit."""
    with suppress(DeviceError):
        client.stop()


def _cause(
    error: BaseException, client: BoardClient, identity: Identity, run: str
) -> BaseException:
    """Return the cause of an error: a lost line or a reset of the board, else the error itself."""
    if not isinstance(error, DeviceError):
        return error
    try:
        if isinstance(error, NoAnswer):
            raise error
        reset = client.identify().boots != identity.boots
    except DeviceError:
        return DeviceError(
            f"{_where(run)}: the line to the board is lost: {error.message}",
            "The board stops itself without its host. Check power and cable, then continue with "
            "--resume.",
        )
    if reset:
        return DeviceError(
            f"{_where(run)}: the board was reset", "Check its supply, then continue with --resume."
        )
    return error


def _fault(status: Mapping[str, Any]) -> str:
    name = FAULTS[status["fault"]]
    return f"{name}: {FAULT_WORDS.get(name, 'unknown cause')}"


def _where(run: str) -> str:
    return f"run {run}" if run else "between two runs"
