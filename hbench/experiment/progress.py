"""Progress of a campaign, for the operator."""

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace

from hbench.config.bench import Bench
from hbench.experiment.plan import Plan, run_seconds
from hbench.records import RunPlan


@dataclass(frozen=True)
class Ended:
    """Completed run with its verdict."""

    plan: RunPlan
    attempt: int  # of this run in this session, from 1
    reasons: tuple[str, ...]  # why it is rejected; empty: accepted
    friction_n: float | None  # mean of the steady window
    again: bool = False  # it is repeated at once


@dataclass(frozen=True)
class Progress:
    """Progress of a campaign and the board's present readings."""

    runs_done: int
    runs_total: int
    plan: RunPlan  # the current run, or the last one
    v_m_s: float
    f_applied_n: float
    v_ref_m_s: float = 0.0  # at present; the plan has that of the steady part
    f_load_n: float = 0.0  # F_L, from the load cylinder's pressures
    pressures_pa: Mapping[str, float] = field(default_factory=dict)  # p_tp, p_tr, p_lp, p_lr, p_s
    pressure_max_pa: float = 0.0  # at which the board stops itself
    x_m: float = 0.0
    travel_m: tuple[float, float] = (0.0, 0.0)  # limits of x_m, at which the board stops itself
    phase: str = "none"
    attempt: int = 1
    waiting: str = ""  # what the operator has to do before the runs go on
    ended: tuple[Ended, ...] = ()  # since the last report, in order
    at_most: bool = False  # the total is an upper limit
    # Of the campaign as a whole:
    trials: int = 1  # of this run's reference
    rejected: int = 0  # attempts of this session
    last_rejected: Ended | None = None
    seconds_left: float | None = None  # wall-clock time; None: not known yet


Report = Callable[[Progress], None]


def no_report(progress: Progress) -> None:
    """Report nothing."""


def report_of_part(report: Report, part: int, parts: int, runs: int) -> Report:
    """Return the report of a part, from 0, of a whole of ``parts`` with ``runs`` runs each."""

    def report_whole(progress: Progress) -> None:
        done = part * runs + progress.runs_done
        report(replace(progress, runs_done=done, runs_total=parts * runs))

    return report_whole


class WholeCampaign:
    """Progress of a whole campaign, from that of its parts."""

    def __init__(self, report: Report, bench: Bench, plans: Iterable[RunPlan]):
        self._report = report
        self._bench = bench
        self._start = self._last_end = time.monotonic()
        self._seconds_done = 0.0  # as estimated
        self._rejected = 0
        self._last_rejected: Ended | None = None
        self._trials: dict[tuple, int] = {}
        self._count_trials(plans)

    def part(self, part: Plan, runs_before: int) -> Report:
        """Return a report function for ``part``, with ``runs_before`` runs before it."""
        self._count_trials((*part.runs, *part.undecided))
        seconds = run_seconds((*part.runs, *part.undecided), self._bench)

        def report(now: Progress) -> None:
            for ended in now.ended:
                self._last_end = time.monotonic()
                if not ended.again:
                    self._seconds_done += seconds[ended.plan.run]
                if ended.reasons:
                    self._rejected += 1
                    self._last_rejected = ended
            remaining = list(seconds.values())[now.runs_done :]
            self._report(
                replace(
                    now,
                    runs_done=runs_before + now.runs_done,
                    runs_total=runs_before + now.runs_total + len(part.undecided),
                    at_most=bool(part.undecided),
                    trials=self._trials[now.plan.operating_point],
                    rejected=self._rejected,
                    last_rejected=self._last_rejected,
                    seconds_left=self._left(remaining),
                )
            )

        return report

    def _left(self, remaining: list[float]) -> float | None:
        """Return the time left at the pace so far, less the time of the current run."""
        if not self._seconds_done:
            return None
        pace = (self._last_end - self._start) / self._seconds_done
        since = time.monotonic() - self._last_end
        return pace * sum(remaining) - min(since, pace * remaining[0]) if remaining else 0.0

    def _count_trials(self, plans: Iterable[RunPlan]) -> None:
        for plan in plans:
            point = plan.operating_point
            self._trials[point] = max(plan.trial, self._trials.get(point, 0))
