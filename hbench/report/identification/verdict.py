"""Verdict on identified laws: the one to use, for what, and the others."""

from collections.abc import Sequence

import numpy as np

from hbench.records import Identification
from hbench.report.campaign.fit_tables import law_words
from hbench.report.identification.misfit_words import described, misfit_words
from hbench.report.identification.ranking import (
    IN_MOTION,
    best_law,
    equally_good,
    errors_in_motion,
)
from hbench.report.identification.remarks import instruments_n
from hbench.report.identification.text import (
    hardly_determined_words,
    scatter_n,
    undetermined_words,
)
from hbench.report.render.numbers import half_width, number, short, significant
from hbench.sentences import listed, plural

_ANOTHER = "A real cylinder may need another law."


def verdict_words(identification: Identification) -> str:
    """Return the law to use, its error, what it can be relied on for, and those as good.

    If no law describes the friction, this comes first.
    """
    misfit = misfit_words(identification)
    if identification.not_verified:
        why = f"{identification.not_verified[0].upper()}{identification.not_verified[1:]}."
        return f"{misfit} {why}".strip()
    best = best_law(identification)
    if not best:
        return misfit
    parts = (
        misfit,
        _closest(identification, best),
        _scatter(identification),
        _reserve(identification, best),
        _as_good(identification, best),
        _ANOTHER if _is_simulated(identification) else "",
    )
    return " ".join(filter(None, parts))


def _closest(identification: Identification, best: str) -> str:
    """Name the law to use with its error of friction in motion."""
    error = number(errors_in_motion(identification)[best], 1)
    use = "On this simulated cylinder, use" if _is_simulated(identification) else "Use"
    if not described(identification):
        use = "In the model of the bench, the closest is"
    return (
        f"{use} {law_words(best)}: it predicts friction in motion with an RMS error of {error} N"
        f"{_range(identification)}."
    )


def _is_simulated(identification: Identification) -> bool:
    return identification.provenance.source == "simulated"


def _scatter(identification: Identification) -> str:
    """Return how far the trials scatter in motion, and the errors of the instruments, if known.

    The latter are common to all runs.
    """
    trials, half = "", instruments_n(identification)
    if identification.scatter:
        trials = f"The trials scatter by {scatter_n(identification, IN_MOTION)} N."
    if half is None:
        return trials
    shift = f"may shift friction by up to ±{half_width(half)} N (95 %)"
    return f"{trials} Errors of the instruments, common to all runs, {shift}.".strip()


def _range(identification: Identification) -> str:
    """Return the measured friction of the verification runs, both directions; may be empty."""
    known = [
        run.measured.friction_n[
            np.isfinite(run.measured.friction_n) & (run.measured.t_s >= run.compared_from_s)
        ]
        for run in identification.followed
    ]
    if not any(map(len, known)):
        return ""
    rms = float(np.sqrt(np.mean(np.concatenate(known) ** 2)))
    return f" at a measured friction of {significant(rms, 3)} N (RMS, both directions)"


def _as_good(identification: Identification, best: str) -> str:
    """Name the laws that are as good as the one to use, and why it is preferred; else empty."""
    errors = errors_in_motion(identification)
    fits = {law.law: law.fit for law in identification.laws if law.fit is not None}
    others = [law for law in equally_good(errors) if law != best]
    if not others:
        return ""
    counts = [len(fits[law].undetermined) if law in fits else 0 for law in (best, *others)]
    names = listed([f"{law_words(law)} ({number(errors[law], 1)} N)" for law in others])
    verb = plural(len(others), "is", "are")
    if counts[0] == min(counts[1:]):
        return f"{names} {verb} as good."
    more = listed([str(count) for count in counts[1:]])
    has = plural(len(others), "has", "have")
    return f"{names} {verb} as good, but {has} {more} undetermined parameters."


def _reserve(identification: Identification, best: str) -> str:
    """State for which motions the law was verified, and what is not determined of it."""
    fits = {law.law: law.fit for law in identification.laws if law.fit is not None}
    parts = []
    if verified := _verified_range(identification):
        others = _other_loads(identification)
        never = f", not for loads of {_load_words(others)}" if others else ""
        parts.append(f"The law is verified for {verified}{never}.")
    if unknown := undetermined_words(fits[best]) if best in fits else []:
        parts.append(
            f"These runs do not determine its {listed(unknown)}: do not rely on motions that "
            "depend on it."
        )
    if hardly := hardly_determined_words(fits[best]) if best in fits else []:
        parts.append(f"The runs hardly determine its {listed(hardly)}.")
    return " ".join(parts)


def _verified_range(identification: Identification) -> str:
    """Return the speeds and the loads of the verification runs; empty if they are not known."""
    speeds = [np.abs(run.measured.v_m_s).max() for run in identification.followed]
    loads = _verified_loads(identification)
    if not speeds:
        return ""
    fastest = f"speeds up to {significant(1e3 * float(max(speeds)), 2)} mm/s"
    return f"{fastest} and loads of {_load_words(loads)}" if loads else fastest


def _other_loads(identification: Identification) -> list[float]:
    """Return the loads of the steady curves at which no law was verified."""
    verified = _verified_loads(identification)
    loads = [along.curve.f_load_n for along in identification.steady]
    measured = {load for load in loads if load is not None}
    return sorted(measured.difference(verified), key=abs) if verified else []


def _verified_loads(identification: Identification) -> list[float]:
    loads = {run.f_load_n for run in identification.followed if run.f_load_n is not None}
    return sorted(loads, key=abs)


def _load_words(loads: Sequence[float]) -> str:
    """Write loads with their signs: ``+500 and +5000 N``."""
    words = [short(load) if load < 0 else f"+{short(load)}" for load in loads]
    return f"{listed(words)} N"
