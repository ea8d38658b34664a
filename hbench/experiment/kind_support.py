"""Check that every stage supports the kinds of experiment of a schedule, before anything moves."""

from collections.abc import Collection

from hbench.analysis.by_kind import ANALYSES
from hbench.analysis.identification.usable_runs import USES
from hbench.analysis.screening.screen import SCREENING_RULES
from hbench.config.schedule import Schedule
from hbench.errors import ConfigError
from hbench.experiment.motions import PROFILES
from hbench.protocol.dictionary import VALVES
from hbench.records import KINDS
from hbench.report.campaign.figures import FIGURE_NAMES

# Column of ``KINDS``: the stage that reads it, and the values that the stage supports.
STAGES: dict[str, tuple[str, Collection[str]]] = {
    "profile": ("plan", PROFILES),
    "valves": ("upload", VALVES),
    "screening": ("screening", SCREENING_RULES),
    "analysis": ("analysis", ANALYSES),
    "identification": ("identification", USES),
    "figure": ("report", ("", *FIGURE_NAMES)),
}


def check_kinds(schedule: Schedule, source: str) -> None:
    """Raise ``ConfigError`` for an experiment of a kind that a stage does not support."""
    for number, experiment in enumerate(schedule.experiments):
        for column, (stage, supported) in STAGES.items():
            value = getattr(KINDS[experiment.kind], column)
            if value not in supported:
                raise ConfigError(
                    f"{source}: experiments.{number}.kind = {experiment.kind!r}: the stage "
                    f"'{stage}' has no {column} {value!r}; it supports "
                    f"{', '.join(filter(None, supported))}",
                    "Choose another kind, or add this one to the stage (hbench/records/kinds.py).",
                )
