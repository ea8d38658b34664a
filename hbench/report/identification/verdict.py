"""Verdict on identified laws: the one to use, for what, and the others."""

from collections.abc import Sequence

import numpy as np

from hbench.records import Identification
from hbench.report.campaign.fit_tables import law_words
from hbench.report.identification.ranking import best_law, equally_good, errors_in_motion
from hbench.report.identification.text import (
    error_range,
    hardly_determined_words,
    undetermined_words,
)
from hbench.report.render.numbers import alike, number, significant
from hbench.report.render.symbols import listed


def verdict_words(identification: Identification) -> str:
    """Return the law to use, what it can be relied on for, those beside it, and the next step."""
    if identification.not_verified:
        return f"{identification.not_verified[0].upper()}{identification.not_verified[1:]}."
    best = best_law(identification)
    if not best:
        return ""
    parts = (
        _closest(identification, best),
        _reserve(identification, best),
        _as_good(identification, best),
        _worse(identification),
        f"To simulate with {law_words(best)}: hbench run --plant {best}.yaml.",
    )
    return " ".join(filter(None, parts))


def _closest(identification: Identification, best: str) -> str:
    """Name the law to use with its error of friction in motion."""
    error = number(errors_in_motion(identification)[best], 1)
    return (
        f"Use {law_words(best)}: it predicts friction in motion with an RMS error of {error} N"
        f"{_range(identification)}."
    )


def _worse(identification: Identification) -> str:
    """State the errors of the laws that are not as good; empty if all are."""
    errors = errors_in_motion(identification)
    worse = {law: error for law, error in errors.items() if law not in equally_good(errors)}
    if len(worse) == 1:
        return f"The error of {law_words(*worse)} is {error_range(worse.values())} N."
    return f"The errors of the other laws are {error_range(worse.values())} N." if worse else ""


def _range(identification: Identification) -> str:
    """Return the measured steady friction at the speeds and loads of verification; may be empty."""
    runs = identification.followed
    fastest = max((float(np.abs(run.measured.v_m_s).max()) for run in runs), default=np.inf)
    loads = _verified_loads(identification)
    friction = [
        abs(point.friction_n)
        for along in identification.steady
        if not loads or along.curve.f_load_n in loads
        for point in along.curve.points
        if abs(point.v_m_s) <= fastest
    ]
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


def _reserve(identification: Identification, best: str) -> str:
    """State for which motions the law was verified, and what is not determined of it."""
    fits = {law.law: law.fit for law in identification.laws if law.fit is not None}
    parts = []
    if verified := _verified_range(identification):
        others = _other_loads(identification)
        never = f", not for loads of {_load_words(others)}" if others else ""
        parts.append(f"It is verified for {verified}{never}.")
    if unknown := undetermined_words(fits[best]) if best in fits else []:
        parts.append(
            f"Do not rely on motions that depend on its {listed(unknown)}, which these runs do not "
            "determine."
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
    return f"{listed([f'{load:+.4g}'.replace('-', '−') for load in loads])} N"
