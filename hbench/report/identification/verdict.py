"""Verdict on identified laws: the best ones, and which to use with which reserve."""

from collections.abc import Sequence

import numpy as np

from hbench.records import Identification
from hbench.report.campaign.fit_tables import law_words
from hbench.report.identification.ranking import best_law, equally_good, errors_in_motion
from hbench.report.identification.text import undetermined_words
from hbench.report.render.numbers import number, significant, span
from hbench.report.render.symbols import listed


def verdict_words(identification: Identification) -> str:
    """Return the best laws, how they were verified, and the next step."""
    if identification.not_verified:
        return f"{identification.not_verified[0].upper()}{identification.not_verified[1:]}."
    count = len(identification.verification_runs)
    return (
        f"{_closest(identification)}Each law was simulated in a model of the bench, with the "
        f"firmware in closed loop, over {count} verification runs, which were not "
        f"used for the identification.{_next_step(identification)}"
    ).strip()


def _closest(identification: Identification) -> str:
    """Name the laws with the smallest errors of friction in motion."""
    errors = errors_in_motion(identification)
    if not errors:
        return ""
    best = equally_good(errors)
    names = [f"{law_words(law)} ({number(error, 1)} N)" for law, error in best.items()]
    verb = "predicts" if len(best) == 1 else "predict"
    measured = _range(identification)
    return f"{' and '.join(names)} {verb} friction in motion best, by RMS error{measured}. "


def _range(identification: Identification) -> str:
    """Return the measured steady friction, with which an error compares; empty without curves."""
    curves = [along.curve for along in identification.steady]
    friction = [abs(point.friction_n) for curve in curves for point in curve.points]
    if not friction:
        return ""
    low, high = (significant(end, 3) for end in (min(friction), max(friction)))
    return f"; the measured steady friction is {low} to {high} N"


def _next_step(identification: Identification) -> str:
    """Return how to use the best law, and what the runs do not determine of it."""
    best = best_law(identification)
    if not best:
        return ""
    fits = {law.law: law.fit for law in identification.laws if law.fit is not None}
    unknown = undetermined_words(fits[best]) if best in fits else []
    return (
        f" Next step: simulate with hbench run --plant {best}.yaml.{_choice(identification, best)}"
        f"{_reserve(identification, unknown)}"
    )


def _choice(identification: Identification, best: str) -> str:
    """State why one of several equally good laws is used; empty for a single one."""
    fits = {law.law: law.fit for law in identification.laws if law.fit is not None}
    others = [law for law in equally_good(errors_in_motion(identification)) if law != best]
    if not others:
        return ""
    counts = [len(fits[law].undetermined) if law in fits else 0 for law in (best, *others)]
    names = listed([f"{other}.yaml" for other in others])
    if counts[0] == min(counts[1:]):
        return f" Its error and its number of undetermined parameters are those of {names} too."
    against = listed([str(count) for count in counts[1:]])
    return f" It has fewer undetermined parameters ({counts[0]}) than {names} ({against})."


def _reserve(identification: Identification, unknown: Sequence[str]) -> str:
    """State what is not determined of the law, and for which motions it was verified."""
    if not unknown:
        return ""
    verified = _verified_range(identification) or "motions like the verification runs"
    return (
        f" These runs do not determine its {listed(unknown)}, so the law is verified for "
        f"{verified} only: verify it again before you use it for other motions."
    )


def _verified_range(identification: Identification) -> str:
    """Return the speeds and the loads of the verification runs; empty if they are not known."""
    speeds = [np.abs(run.measured.v_m_s).max() for run in identification.followed]
    loads = [run.f_load_n for run in identification.followed if run.f_load_n is not None]
    if not speeds:
        return ""
    fastest = f"speeds up to {significant(1e3 * float(max(speeds)), 2)} mm/s"
    return f"{fastest} and loads of {span(loads)} N" if loads else fastest
