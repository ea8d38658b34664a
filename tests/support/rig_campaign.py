"""Campaigns that are measured on the virtual rig, with the options that most tests share."""

from dataclasses import fields
from datetime import UTC, datetime
from pathlib import Path

from hbench import workflow


def measure_on_rig(experiment, folder: Path, **options):
    """Make the runs of an experiment without progress, as of 2026; ``options`` replace others.

    They may contain those of the line.
    """
    names = {field.name for field in fields(workflow.Line)}
    line = workflow.Line(**{name: options.pop(name) for name in names & options.keys()})
    usual = {
        "resume": False,
        "clock": lambda: datetime(2026, 1, 1, tzinfo=UTC),
        "report": lambda progress: None,
    }
    return workflow.measure(experiment, folder, line, **usual | options)
