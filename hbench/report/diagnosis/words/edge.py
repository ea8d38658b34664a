"""Metering edges of the valves in words: the one that deviates, and what several have in common."""

from typing import NamedTuple

from hbench.records import Diagnosis
from hbench.report.diagnosis.names import in_sentence, parts_of
from hbench.report.diagnosis.words.place import (
    CLEARLY_LARGER,
    edge_gaps,
    rms_words,
)
from hbench.report.diagnosis.words.refit import refit_increases
from hbench.sentences import listed

_LINES = {"tank": "the return line", "supply": "the supply line"}  # of each edge


class EdgePattern(NamedTuple):
    """Same metering edge of several valves at which the flows to their chambers deviate most."""

    edge: str  # supply or tank
    valves: dict[str, str]  # by balance, the largest deviation at that edge first


def suspect_edge(diagnosis: Diagnosis, name: str) -> tuple[str, str] | None:
    """Return the metering edge with a clearly larger gap, and the other one; None without one."""
    gaps = edge_gaps(diagnosis, name)
    if len(gaps) < 2 or not max(gaps.values()) > CLEARLY_LARGER * min(gaps.values()):
        return None
    worst, other = sorted(gaps, key=lambda edge: -gaps[edge])
    return worst, other


def edge_pattern(diagnosis: Diagnosis) -> EdgePattern | None:
    """Return the edge at which unexplained flows of several valves deviate; None without one."""
    sizes = {gap.name: gap.scatter for gap in diagnosis.where}
    moved = refit_increases(diagnosis)  # which no valve does
    for edge in _LINES:
        names = [
            gap.name
            for gap in diagnosis.rest
            if (found := suspect_edge(diagnosis, gap.name)) and found[0] == edge
            if gap.name not in moved
        ]
        names.sort(key=lambda name: -edge_gaps(diagnosis, name)[edge] * sizes[name])
        valves = {name: parts_of(diagnosis, name)[0] for name in names}
        if len(set(valves.values())) > 1:
            return EdgePattern(edge, valves)
    return None


def pattern_words(diagnosis: Diagnosis, pattern: EdgePattern) -> tuple[str, str]:
    """Return what to inspect, and the sentence on what the valves have in common."""
    edge = pattern.edge
    sizes = [
        f"{in_sentence(name)} by {rms_words(diagnosis, name, edge_gaps(diagnosis, name)[edge])}"
        for name in pattern.valves
    ]
    valves = listed(list(pattern.valves.values()))
    return (
        f"{valves} at their metering edges to {edge}, and {_LINES[edge]} that they share",
        f"The flows of {valves} deviate most while these edges meter them, {listed(sizes)} over "
        "all speeds, so that a common cause is likely.",
    )
