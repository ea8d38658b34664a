"""Remarks on an identification: runs that are not used, and what its intervals leave out."""

from hbench.records import Identification
from hbench.records.numbers import NORMAL_95
from hbench.report.render.numbers import half_width


def left_out_words(identification: Identification) -> list[str]:
    """Return the reasons why runs are not used, each with its runs."""
    runs: dict[str, list[str]] = {}
    for line in identification.left_out:
        run, _, why = line.partition(" ")
        runs.setdefault(why, []).append(run)
    return [
        f"{'run' if len(each) == 1 else 'runs'} {', '.join(each)} {why}"
        for why, each in runs.items()
    ]


def interval_words(identification: Identification) -> str:
    """State that the intervals of the parameters do not contain the errors of the instruments."""
    sigmas = [
        point.sigma_instruments_n
        for along in identification.steady
        for point in along.curve.points
        if point.sigma_instruments_n is not None
    ]
    size = (
        f"; by their tolerances, it can shift the measured friction by ±"
        f"{half_width(NORMAL_95 * max(sigmas))} N (95 %)"
        if sigmas
        else ""
    )
    return (
        "Intervals contain the scatter of the runs alone, not the errors of the instruments. An "
        f"error of a sensor is common to all runs and shifts the parameters of all laws{size}."
    )
