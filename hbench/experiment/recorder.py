"""Recorder of a board's log: sorts its records into runs and journals each run."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from typing import Any

import numpy as np

from hbench.config.bench import Bench
from hbench.errors import DeviceError
from hbench.experiment.progress import Ended, Progress
from hbench.experiment.run_journal import Journal
from hbench.protocol.dictionary import PHASES, PRESSURES, RECORD, RECORD_FLAGS, STATES
from hbench.records import LogChannel, Outcome, RawRun, RunPlan, ScreenedRun

LOG_CHANNELS = tuple(LogChannel(word.name, word.signed, word.scale, word.unit) for word in RECORD)
END_MISSING = "the end of its log is missing"
FALSE_END = "a record is marked as the last of its log, but the run went on"
OVERRUN = "{} records were overwritten before they were pulled: the log ran over"

_WORDS = [word.name for word in RECORD]
_RUN, _INDEX, _FLAGS = (_WORDS.index(name) for name in ("run", "index", "flags"))
_LAST, _SETTLED = (1 << RECORD_FLAGS.index(name) for name in ("last", "settled"))
_MOVING = tuple(
    PHASES.index(name) for name in ("accelerate", "steady", "closed", "push", "vent")
)  # the phases in which a run is logged

Judge = Callable[[RawRun], ScreenedRun]


class Recorder:
    """Recorder of the runs of a plan; journals each run at its start and its end.

    A run is done once all its records up to the last have been received, and the next record or the
    board's status confirms that it is over. ``judge``, if given, screens each run as it ends; a
    rejected one may be repeated ``retry`` times.
    """

    def __init__(
        self,
        plans: Iterable[RunPlan],
        bench: Bench,
        journal: Journal,
        clock: Callable[[], datetime],
        judge: Judge | None = None,
        retry: int = 0,
    ):
        self._plans = {int(plan.run): plan for plan in plans}
        self.bench = bench
        self._journal = journal
        self._clock = clock
        self._judge = judge
        self._retry = retry
        self._words: list[np.ndarray] = []
        self._records = 0  # in these words
        self._number = 0  # of the current run; 0: none
        self._lost = 0  # records of the current run, at most
        self._gap = 0  # records lost right before the next one
        self._marked = False  # the newest record is marked as the run's last
        self._false_end = False  # an earlier one was
        self._finished: dict[int, Outcome] = {}
        self._attempts: dict[int, int] = {}
        self._verdicts: dict[int, Ended] = {}  # the last of each run
        self._unreported: list[int] = []  # runs that have ended since the last report
        self._again: set[int] = set()  # finished, but to be repeated
        self.supply_is_off = False  # as the last upload needed it

    @property
    def current(self) -> str:
        """Id of the current run; empty between runs."""
        return self._plans[self._number].run if self._number else ""

    def progress(self, status: Mapping[str, Any]) -> Progress | None:
        """Return the progress of the campaign; None before the first run."""
        ended, self._unreported = self._unreported, []
        number = self._number or (ended[-1] if ended else 0)
        return self._progress(status, number, ended) if number else None

    def waiting(self, status: Mapping[str, Any], plan: RunPlan, what: str) -> Progress:
        """Return the progress while the operator has to do something before the run ``plan``."""
        return replace(self._progress(status, int(plan.run), []), waiting=what)

    def _progress(self, status: Mapping[str, Any], number: int, ended: list[int]) -> Progress:
        cylinder = self.bench.load_cylinder
        p_lp, p_lr = status["p_lp_pa"], status["p_lr_pa"]
        return Progress(
            runs_done=len(self._finished) - len(self._again),
            runs_total=len(self._plans),
            plan=self._plans[number],
            v_m_s=status["v_m_s"],
            f_applied_n=status["f_applied_n"],
            v_ref_m_s=status["v_ref_m_s"],
            f_load_n=p_lp * cylinder.area_piston_m2 - p_lr * cylinder.area_rod_m2,
            pressures_pa={name: status[f"{name}_pa"] for name in PRESSURES},
            pressure_max_pa=self.bench.limits.pressure_max,
            x_m=status["x_m"],
            travel_m=(self.bench.limits.travel_min, self.bench.limits.travel_max),
            phase=PHASES[status["phase"]] if status["phase"] < len(PHASES) else "none",
            attempt=self._attempts.get(number, 1),
            ended=tuple(self._verdicts[n] for n in ended if n in self._verdicts),
        )

    def begin(self, number: int) -> None:
        """Note that a run has started, according to the status or its first record.

        The board still names a run while it brakes after the last record; that starts nothing.
        """
        if number == self._number:
            return
        self._end_if_marked()
        if number in self._finished:
            return
        if number not in self._plans:
            raise DeviceError(f"the board reports run {number}, which is not in the plan")
        self.finish("failed", END_MISSING)
        self._attempts[number] = self._attempts.get(number, 0) + 1
        before = self._verdicts.get(number)
        self._journal.start_run(
            self._plans[number], self._clock(), "; ".join(before.reasons) if before else ""
        )
        self._number = number

    def lose(self, count: int) -> None:
        """Note that the next ``count`` records are lost, of whichever runs."""
        self._gap += count
        if self._number and not self._marked:
            self._lost += count

    def feed(self, words: np.ndarray) -> None:
        """Sort records in order: ``words`` (n, words of a record)."""
        for piece in _split(words):
            number = int(piece[0, _RUN])
            self.begin(number)
            if number != self._number:
                self._recall(number)
            if not self._words and piece[0, _INDEX]:
                self._lost = self._gap  # which held this run's first records
            self._gap = 0
            *earlier, newest = (flags & _LAST != 0 for flags in piece[:, _FLAGS].tolist())
            self._false_end |= self._marked or any(earlier)
            self._marked = newest
            self._words.append(piece)
            self._records += len(piece)
            self._check_length()

    def _check_length(self) -> None:
        plan = self._plans[self._number]
        longest = plan.planned_motion.duration_s * self.bench.controllers.log_rate
        if self._records > 1.01 * longest + 100:
            raise DeviceError(
                f"run {plan.run}: the board sent {self._records} records; its longest log has "
                f"{longest:.0f}",
                "Reset the board, then continue with --resume.",
            )

    def follow(self, status: Mapping[str, Any]) -> None:
        """Note the board's status after all records that were logged before it."""
        moving = STATES[status["state"]] == "running" and status["phase"] in _MOVING
        if moving and status["run"] == self._number:
            self._false_end |= self._marked
            self._marked = False
        self._end_if_marked()

    def _recall(self, number: int) -> None:
        """Count a run as not made, since records follow its last one. Raises ``DeviceError``."""
        del self._finished[number]
        self.begin(number)
        raise DeviceError(
            f"the board sent records of run {number:04d} after its last",
            "Reset the board, then continue with --resume.",
        )

    def _end_if_marked(self) -> None:
        if self._marked:
            self.finish("done", _ending(self._plans[self._number], self._words[-1][-1, _FLAGS]))

    def finish(self, outcome: Outcome, why: str) -> None:
        """End the current run: journal its log and its outcome, then screen it."""
        if not self._number:
            return
        number, plan = self._number, self._plans[self._number]
        words = np.concatenate(self._words) if self._words else np.zeros((0, len(RECORD)), "<u2")
        if self._lost and (outcome == "done" or why == END_MISSING):
            outcome, why = "failed", OVERRUN.format(self._lost)
        elif self._false_end and (outcome == "done" or why == END_MISSING):
            outcome, why = "failed", FALSE_END
        self._finished[number] = outcome
        self._words, self._records, self._number, self._lost = [], 0, 0, 0
        self._marked = self._false_end = False
        self._journal.finish_run(plan, words, outcome, why, self._clock())
        self._unreported.append(number)
        if self._judge is not None:
            rate_hz = self.bench.controllers.log_rate
            screened = self._judge(
                RawRun(plan, words, LOG_CHANNELS, RECORD_FLAGS, rate_hz, outcome, why)
            )
            friction_n = screened.means.friction_n if screened.means else None
            attempt = self._attempts[number]
            again = not screened.accepted and attempt <= self._retry
            self._verdicts[number] = Ended(plan, attempt, screened.reasons, friction_n, again)
            if again:
                self._again.add(number)

    def again(self, plan: RunPlan) -> bool:
        """Return whether to repeat a run at once; if so, it counts as not made."""
        number = int(plan.run)
        if number not in self._again:
            return False
        self._again.remove(number)
        del self._finished[number]
        return True

    def abandon(self, error: BaseException) -> None:
        """End the current run because of an error or an interruption."""
        interrupted = not isinstance(error, Exception)
        why = "interrupted by the operator" if interrupted else str(error) or type(error).__name__
        self.finish("aborted" if interrupted else "failed", why)

    def close(self) -> None:
        """End the campaign after its last step. Raises ``DeviceError`` if runs failed."""
        for number in [n for n in self._plans if n not in self._finished]:
            self.begin(number)
            self.finish("failed", "all its records were overwritten: the log ran over")
        failed = [plan.run for n, plan in self._plans.items() if self._finished[n] == "failed"]
        if failed:
            raise DeviceError(
                f"{len(failed)} of {len(self._plans)} runs failed: {', '.join(failed)}",
                "Repeat them with --resume. Where the log ran over, use a faster line (--baud) or "
                "a lower controllers.log_rate.",
            )


def _split(words: np.ndarray) -> Sequence[np.ndarray]:
    """Return the records of each run: mostly all records are of one."""
    runs = words[:, _RUN]
    numbers = len(set(runs.tolist()))  # faster than numpy for a few records
    if numbers < 2:
        return [words] * numbers
    return np.split(words, np.flatnonzero(np.diff(runs)) + 1)


def _ending(plan: RunPlan, flags: int) -> str:
    """Return a remark on a completed run: whether its quantity has settled."""
    motion = plan.planned_motion
    if motion.until == "cycles":
        return ""
    quantity = motion.until.replace("_", " ")
    if flags & _SETTLED:
        return f"{quantity} settled within {100 * motion.within:g} %"
    return (
        f"{quantity} had not settled within {100 * motion.within:g} % after {motion.cycles} cycles"
    )
