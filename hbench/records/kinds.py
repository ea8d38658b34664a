"""Kinds of experiment: one row each, on which every stage from schedule to report dispatches.

A row holds data alone. A stage that needs code for a kind has a table from the values of one
column to functions:

    profile         keys of the schedule file    config/experiments.py
                    velocity profile             experiment/motions.py
    valves          wire segments                protocol/dictionary.py (VALVES)
    screening       reasons for rejection        analysis/screening/by_kind.py
    analysis        curves, loops, levels, ...   analysis/by_kind.py
    identification  part in the identification   workflow/identification.py
    figure          figure of the report         report/campaign/figures/all_figures.py

The name alone serves the campaign folder, import maps, index files and the JSON Schemas. A new kind
is a row, and code for those values alone that no other row has. ``hbench run --check`` refuses a
kind with a value that its stage does not implement.
"""

from dataclasses import dataclass
from typing import Literal

Profile = Literal[
    "constant_speed",
    "acceleration_ramp",
    "triangle",
    "velocity_steps",
    "stretches",
    "at_rest",
    "force_ramp",
    "levelled",
]
Valves = Literal["controlled", "closed", "pushing", "venting"]
ScreeningRule = Literal[
    "steady_window",
    "complete_ramp",
    "tracking",
    "whole_cycles",
    "settled_levels",
    "rest",
    "moved_off",
    "levelled",
]
Analysis = Literal[
    "steady_curve",
    "ramp_curve",
    "hysteresis",
    "step_levels",
    "leakage",
    "breakaway",
    "zero_check",
    "verification",
]
IdentificationUse = Literal["steady_curve", "motion", "verification", "too_fast", "unused"]


@dataclass(frozen=True)
class ExperimentKind:
    """One kind of experiment: its name, and what each stage does with its runs."""

    name: str  # ``kind`` in schedules, campaigns, import maps, index files and results
    display_name: str
    profile: Profile
    screening: ScreeningRule
    analysis: Analysis
    figure: str  # that shows the runs; empty: none, or `hbench identify` draws them
    identification: IdentificationUse
    valves: Valves = "controlled"  # during the motion
    valve_may_saturate: bool = False  # a saturated valve is a note, not a reason for rejection
    reverses: bool = False  # within a run: shows presliding and the friction's lag
    has_fast_changes: bool = False  # excites valves, masses and filters
    is_reconciled: bool = True  # `hbench reconcile` uses the runs

    def counted(self, count: int) -> str:
        """Write a number of runs among those of other kinds, such as ``2 zero checks``."""
        is_noun = not (self.has_constant_speed or self.display_name.endswith("s"))
        return f"{count} {self.display_name}{'s' * (is_noun and count != 1)}"

    @property
    def has_constant_speed(self) -> bool:
        """A run has one velocity, at which its steady window is averaged."""
        return self.screening == "steady_window"

    @property
    def is_ramp(self) -> bool:
        """A run's friction is a curve over its rising speed."""
        return self.analysis == "ramp_curve"

    @property
    def is_at_rest(self) -> bool:
        """The piston rests with closed valves, so that a run has no reference and no friction."""
        return self.valves in ("closed", "venting")

    @property
    def needs_supply_off(self) -> bool:
        """The runs need the supply switched off."""
        return self.valves == "venting"

    @property
    def raises_force(self) -> bool:
        """A run pushes a resting piston with a rising force, until it moves."""
        return self.valves == "pushing"

    @property
    def covers_speeds(self) -> bool:
        """One run covers a range of speeds."""
        return not (self.has_constant_speed or self.is_at_rest or self.raises_force)


_ROWS = (
    ExperimentKind(
        name="steady",
        display_name="steady",
        profile="constant_speed",
        screening="steady_window",
        analysis="steady_curve",
        figure="stribeck",
        identification="steady_curve",
    ),
    ExperimentKind(
        name="ramp",
        display_name="ramp",
        profile="acceleration_ramp",
        screening="complete_ramp",
        analysis="ramp_curve",
        figure="ramps",
        identification="motion",
    ),
    ExperimentKind(
        name="triangle",
        display_name="triangle",
        profile="triangle",
        screening="whole_cycles",
        analysis="hysteresis",
        figure="hysteresis",
        identification="motion",
        valve_may_saturate=True,
        reverses=True,
        has_fast_changes=True,
    ),
    ExperimentKind(
        name="steps",
        display_name="steps",
        profile="velocity_steps",
        screening="settled_levels",
        analysis="step_levels",
        figure="steps",
        identification="too_fast",
        valve_may_saturate=True,
        has_fast_changes=True,
    ),
    ExperimentKind(
        name="hold",
        display_name="hold",
        profile="at_rest",
        screening="rest",
        analysis="leakage",
        figure="leakage",
        identification="unused",
        valves="closed",
    ),
    ExperimentKind(
        name="breakaway",
        display_name="breakaway",
        profile="force_ramp",
        screening="moved_off",
        analysis="breakaway",
        figure="breakaway",
        identification="unused",
        valves="pushing",
        is_reconciled=False,
    ),
    ExperimentKind(
        name="check",
        display_name="zero check",
        profile="levelled",
        screening="levelled",
        analysis="zero_check",
        figure="",
        identification="unused",
        valves="venting",
        is_reconciled=False,
    ),
    ExperimentKind(
        name="verification",
        display_name="verification",
        profile="stretches",
        screening="tracking",
        analysis="verification",
        figure="",
        identification="verification",
        reverses=True,
        has_fast_changes=True,
    ),
)
KINDS: dict[str, ExperimentKind] = {row.name: row for row in _ROWS}


def kind_names() -> str:
    """Return the names of all kinds as messages list them: ``steady, ramp, ...``."""
    return ", ".join(KINDS)
