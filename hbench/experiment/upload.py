"""Segments and steps of planned runs, in batches that the board can hold."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from hbench.config.bench import Bench
from hbench.errors import ConfigError
from hbench.experiment.plan import trials_in_a_row
from hbench.protocol.dictionary import CONDITIONS, VALVES
from hbench.records import KINDS, RunPlan, Segment
from hbench.rig.client import Identity


@dataclass
class Upload:
    """One schedule of the board, in the fields of the message dictionary.

    With the supply off, or with the supply on, as its first run needs it.
    """

    first: RunPlan | None = None
    segments: list[dict[str, Any]] = field(default_factory=list)
    steps: list[dict[str, Any]] = field(default_factory=list)
    _rows: dict[tuple[Segment, ...], int] = field(default_factory=dict)

    @property
    def supply_is_off(self) -> bool:
        """Whether its runs need the supply switched off."""
        return self.first is not None and KINDS[self.first.kind].needs_supply_off

    def longest_rest_s(self, bench: Bench) -> float:
        """Return the longest time between two records [s]: brake, return, load and hold.

        The return and the ramps of the load's pressures have twice the time that the board allows
        them (firmware/core/schedule.c).
        """
        control, limits = bench.controllers, bench.limits
        speed, acceleration = control.return_speed, control.acceleration
        travel = limits.travel_max - limits.travel_min
        gain = min(5.0, 1.5 * acceleration / speed)
        back = 3 * travel / speed + 10 + 8 / gain
        load = 2 * (limits.pressure_max / control.pressure_slew + speed / acceleration) + 0.1
        brake = limits.speed_max / acceleration
        return 2 * (brake + back + load + max(step["hold_s"] for step in self.steps))

    def takes(self, plan: RunPlan, board: Identity) -> bool:
        """Return whether one more step with the motion of ``plan`` has room."""
        if self.first and KINDS[plan.kind].needs_supply_off != self.supply_is_off:
            return False
        row = plan.planned_motion.segments
        new = 0 if row in self._rows else len(row)
        return len(self.steps) < board.max_steps and len(self.segments) + new <= board.max_segments

    def add(self, trials: Sequence[RunPlan]) -> None:
        """Append the step of runs that differ only in their trial."""
        plan = trials[0]
        self.first = self.first or plan
        motion = plan.planned_motion
        if motion.segments not in self._rows:  # steps may share a row
            self._rows[motion.segments] = len(self.segments)
            self.segments += [_segment(segment) for segment in motion.segments]
        self.steps.append(
            {
                "run": int(plan.run),
                "trials": len(trials),
                "segment": self._rows[motion.segments],
                "segments": len(motion.segments),
                "cycles": motion.cycles,
                "until": CONDITIONS.index(motion.until),
                "within": motion.within,
                "p_lr_ref_pa": plan.p_lr_ref_pa or 0.0,
                "p_lp_ref_pa": plan.p_lp_ref_pa or 0.0,
                "x_start_m": motion.x_start_m,
                "x_min_m": motion.x_min_m,
                "x_max_m": motion.x_max_m,
                "hold_s": motion.hold_s,
            }
        )


def uploads(plans: Sequence[RunPlan], board: Identity) -> Iterator[Upload]:
    """Yield the plan as schedules that fit the board. Raises ``ConfigError`` for too long a run."""
    upload = Upload()
    for trials in trials_in_a_row(plans):
        row = trials[0].planned_motion.segments
        if len(row) > board.max_segments:
            raise ConfigError(
                f"run {trials[0].run}: its profile has {len(row)} segments; limit of the board "
                f"{board.max_segments}",
                "Divide the profile into several experiments.",
            )
        if not upload.takes(trials[0], board):
            yield upload
            upload = Upload()
        upload.add(trials)
    if upload.steps:
        yield upload


def _valves(segment: Segment) -> str:
    if segment.closed or segment.vented:
        return "closed" if segment.closed else "venting"
    return "pushing" if segment.force_rate_n_s else "controlled"


def _segment(segment: Segment) -> dict[str, Any]:
    return {
        "valves": VALVES.index(_valves(segment)),
        "v_m_s": segment.v_m_s,
        "a_m_s2": segment.a_m_s2,
        "duration_s": segment.duration_s,
        "force_rate_n_s": segment.force_rate_n_s,
        "displacement_m": segment.displacement_m,
    }
