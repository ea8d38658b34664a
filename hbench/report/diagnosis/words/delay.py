"""Readings that are late against the position, in words."""

from dataclasses import replace

from hbench.records import Diagnosis, FitParameter
from hbench.report.diagnosis.names import PRESSURE_SYMBOLS
from hbench.report.diagnosis.words.coefficient import parameter_text
from hbench.sentences import listed

_READINGS = PRESSURE_SYMBOLS | {"f_applied": "the load cell", "commands": "the valves' commands"}


def delay_words(diagnosis: Diagnosis) -> str:
    """Return which readings are late or early by a time that matters; empty without any."""
    delays, by_way = dict(diagnosis.delays), dict[str, list[str]]()
    position = delays.pop("x", None)
    for channel, delay in delays.items():
        way = "late" if delay.value > 0 else "early"
        by_way.setdefault(way, []).append(
            f"{_READINGS[channel]} by {parameter_text(_magnitude(delay))}"
        )
    parts = [f"{way}: {listed(each)}" for way, each in by_way.items()]
    words = [f"Against the position these readings are {'; '.join(parts)}."] if parts else []
    if position:
        words.insert(0, f"The position is late by {parameter_text(position)}.")
    if not words:
        return ""
    return (
        f"{' '.join(words)} Filters of amplifiers or a "
        "logger that reads one channel after another cause this. Here it is taken into account; "
        "correct the log before other evaluations of unsteady motion."
    )


def _magnitude(delay: FitParameter) -> FitParameter:
    """Return the time without its sign."""
    if delay.value >= 0:
        return delay
    ends = delay.ci95 and (-delay.ci95[1], -delay.ci95[0])
    return replace(
        delay, value=-delay.value, ci95=ends, at_bound="upper" if delay.at_bound else None
    )
