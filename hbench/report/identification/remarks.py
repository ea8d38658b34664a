"""Remarks on an identification: runs that are not used, and what its intervals leave out."""

from hbench.records import Identification
from hbench.records.numbers import NORMAL_95
from hbench.report.campaign.fit_tables import law_words
from hbench.report.identification.ranking import ranked_laws
from hbench.report.render.numbers import half_width, span
from hbench.sentences import listed, plural


def left_out_words(identification: Identification) -> list[str]:
    """Return the reasons why runs are not used, each with its runs."""
    runs: dict[str, list[str]] = {}
    for line in identification.left_out:
        run, _, why = line.partition(" ")
        runs.setdefault(why, []).append(run)
    return [
        f"{plural(len(each), 'run', 'runs')} {', '.join(each)} {why}" for why, each in runs.items()
    ]


def instruments_n(identification: Identification) -> float | None:
    """Return the half-width of friction's 95 % interval by the instruments alone, the largest."""
    sigmas = [
        point.sigma_instruments_n
        for along in identification.steady
        for point in along.curve.points
        if point.sigma_instruments_n is not None
    ]
    return NORMAL_95 * max(sigmas) if sigmas else None


def interval_words(identification: Identification) -> str:
    """State that the intervals of the parameters do not contain the errors of the instruments."""
    half = instruments_n(identification)
    size = "" if half is None else f" by up to ±{half_width(half)} N of friction (95 %)"
    return (
        "Intervals contain the scatter of the runs alone, not the errors of the instruments. An "
        f"error of a sensor is common to all runs and shifts the parameters of all laws{size}."
    )


def oscillation_words(identification: Identification) -> str:
    """State where the errors at constant speed leave out oscillations; empty without any."""
    where: dict[str, list[str]] = {}
    for law in ranked_laws(identification):
        if (steady := law.steady) is not None and steady.oscillating is not None:
            speeds = span([1e3 * v for v in steady.speeds_m_s])
            place = f"in {len(steady.speeds_m_s)} of {steady.parts} parts, at {speeds} mm/s"
            where.setdefault(place, []).append(law_words(law.law))
    if not where:
        return ""
    parts = "; ".join(f"{place}: {listed(names)}" for place, names in where.items())
    return (
        f"In brackets: without the parts where the simulation oscillates, {parts}. Where friction "
        "falls with speed, a static law damps no oscillation; the measured motion does not "
        "oscillate there."
    )
