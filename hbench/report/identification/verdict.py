"""Verdict on identified laws: the best ones, and which to use with which reserve."""

from collections.abc import Sequence

import numpy as np

from hbench.records import Identification
from hbench.report.campaign.fit_tables import law_words
from hbench.report.identification.ranking import (
    best_law,
    equally_good,
    errors_in_motion,
    ranked_laws,
)
from hbench.report.identification.text import error_range, undetermined_words
from hbench.report.render.numbers import alike, number, significant, span
from hbench.report.render.symbols import listed


def verdict_words(identification: Identification) -> str:
    """Return the best laws, how they were verified, and the next step."""
    if identification.not_verified:
        return f"{identification.not_verified[0].upper()}{identification.not_verified[1:]}."
    return " ".join(
        filter(
            None, (_closest(identification), _method(identification), _next_step(identification))
        )
    )


def _method(identification: Identification) -> str:
    count = len(identification.verification_runs)
    return (
        f"Each law was simulated in a model of the bench, with the firmware in closed loop, over "
        f"{count} verification runs, which were not used for the identification."
    )


def _closest(identification: Identification) -> str:
    """Name the law to use with its error of friction in motion, and those as good as it."""
    best = best_law(identification)
    if not best:
        return ""
    errors = errors_in_motion(identification)
    words = (
        f"Use {law_words(best)}: it predicts friction in motion with an RMS error of "
        f"{number(errors[best], 1)} N{_range(identification)}."
    )
    worse = {law: error for law, error in errors.items() if law not in equally_good(errors)}
    others = f"The errors of the other laws are {error_range(worse.values())} N." if worse else ""
    if len(worse) == 1:
        others = f"The error of {law_words(*worse)} is {error_range(worse.values())} N."
    oscillating = [
        law_words(law.law)
        for law in ranked_laws(identification)
        if law.steady and law.steady.oscillating
    ]
    if oscillating:
        others += f" Simulations with {listed(oscillating)} oscillate at some constant speeds."
    return " ".join(filter(None, (words, _as_good(identification, best), others.strip())))


def _range(identification: Identification) -> str:
    """Return the measured steady friction, with which an error compares; empty without curves."""
    curves = [along.curve for along in identification.steady]
    friction = [abs(point.friction_n) for curve in curves for point in curve.points]
    if not friction:
        return ""
    return f" at a measured steady friction of {alike(friction)} N"


def _as_good(identification: Identification, best: str) -> str:
    """Name the laws that are as good as the one to use, and why it is preferred; else empty."""
    errors = errors_in_motion(identification)
    fits = {law.law: law.fit for law in identification.laws if law.fit is not None}
    others = [law for law in equally_good(errors) if law != best]
    if not others:
        return ""
    counts = [len(fits[law].undetermined) if law in fits else 0 for law in (best, *others)]
    names = listed([f"{law_words(law)} ({number(errors[law], 1)} N)" for law in others])
    verb = "is" if len(others) == 1 else "are"
    if counts[0] == min(counts[1:]):
        return f"{names} {verb} as good."
    more = listed([str(count) for count in counts[1:]])
    has = "has" if len(others) == 1 else "have"
    return (
        f"{names} {verb} as good, but {has} more undetermined parameters ({more} instead of "
        f"{counts[0]})."
    )


def _next_step(identification: Identification) -> str:
    """Return how to use the best law, and what the runs do not determine of it."""
    best = best_law(identification)
    if not best:
        return ""
    fits = {law.law: law.fit for law in identification.laws if law.fit is not None}
    unknown = undetermined_words(fits[best]) if best in fits else []
    return (
        f"Next step: simulate with hbench run --plant {best}.yaml."
        f"{_reserve(identification, unknown)}"
    )


def _reserve(identification: Identification, unknown: Sequence[str]) -> str:
    """State what is not determined of the law, and for which motions it was verified."""
    parts = []
    if unknown:
        parts.append(
            f" These runs do not determine its {listed(unknown)}: motions that depend on "
            f"{'it' if len(unknown) == 1 else 'them'} can differ from the simulation."
        )
    if verified := _verified_range(identification):
        parts.append(
            f" The law is verified for {verified}: verify it again before you exceed them."
        )
    return "".join(parts)


def _verified_range(identification: Identification) -> str:
    """Return the speeds and the loads of the verification runs; empty if they are not known."""
    speeds = [np.abs(run.measured.v_m_s).max() for run in identification.followed]
    loads = [run.f_load_n for run in identification.followed if run.f_load_n is not None]
    if not speeds:
        return ""
    fastest = f"speeds up to {significant(1e3 * float(max(speeds)), 2)} mm/s"
    return f"{fastest} and loads of {span(loads)} N" if loads else fastest
