"""Whether any law describes the measured friction: a sentence and a table."""

import math
from collections.abc import Iterator

from hbench.records import Identification, LackOfFit, WordTable
from hbench.records.identification import NEGLIGIBLE_MISFIT
from hbench.report.campaign.fit_tables import law_words
from hbench.report.render.numbers import significant
from hbench.sentences import capital

MISFIT = "Measured friction, and what each law misses of it"
_HEAD = (
    *("Law", "Motion", "Friction (N)", "Error (N)", "Scatter (N)", "Misfit (N)", "Misfit (%)"),
    "Describes it",
)
_STEADY, _MOVING = "steady", "reversing"
_WHERE = {_STEADY: "at steady speeds", _MOVING: "in reversing motions"}
_NOT_ITS_OWN = (
    "Friction depends on something that the laws do not contain, such as position, direction, load "
    "or time. Do not use their parameters beyond the measured points."
)
MISFIT_FACT = (
    "Misfit",
    "All forces are root mean squares. The error is the measured friction less that of the law. "
    "The misfit is the error without the scatter of the trials, and without what errors of the "
    "instruments within their tolerances explain (an offset of the force where they are not "
    "known); its percentage is that of friction. In reversing motions friction and error are less "
    "their mean over each run, and the misfit is the part that is the same in all runs. A law does "
    f"not describe friction if the misfit is significant and more than {100 * NEGLIGIBLE_MISFIT:g} "
    "% of friction. If shifted: errors of the instruments would explain most of the error.",
)

Compared = list[tuple[str, LackOfFit]]


def described(identification: Identification) -> bool:
    """Return whether laws describe the friction, at steady speeds and in motion, if known."""
    return all(_any_describes(found) for _, found in _by_data(identification))


def misfit_words(identification: Identification) -> str:
    """State where no law describes the friction; else, without verification, the misfit."""
    by_data = list(_by_data(identification))
    without = [(data, found) for data, found in by_data if not _any_describes(found)]
    if without:
        sentences = [_not_described(data, found) for data, found in without]
        return " ".join([*sentences, _NOT_ITS_OWN])
    if not identification.not_verified:
        return ""
    return " ".join(_closest_words(data, found) for data, found in by_data)


def misfit_table(identification: Identification) -> WordTable:
    """Return a row for each law and kind of data."""
    rows = [
        (
            law,
            data,
            *(_short(n) for n in (fit.friction_n, fit.error_n, fit.scatter_n, fit.misfit_n)),
            _short(100 * fit.share),
            _verdict(fit),
        )
        for data, found in _by_data(identification)
        for law, fit in sorted(found, key=lambda each: each[1].misfit_n)
    ]
    return WordTable(MISFIT, _HEAD, tuple(rows))


def _by_data(identification: Identification) -> Iterator[tuple[str, Compared]]:
    laws = identification.laws
    steady = [(law.law, law.misfit) for law in laws if law.misfit is not None]
    moving = [(law.law, law.misfit_in_motion) for law in laws if law.misfit_in_motion is not None]
    yield from ((data, found) for data, found in ((_STEADY, steady), (_MOVING, moving)) if found)


def _any_describes(found: Compared) -> bool:
    return any(fit.describes for _, fit in found)


def _not_described(data: str, found: Compared) -> str:
    law, fit = _closest(found)
    return (
        f"No law describes the friction {_WHERE[data]}: the closest, {law_words(law)}, misses it "
        f"by {_short(fit.misfit_n)} N, {_short(100 * fit.share)} % of it (RMS), beside a scatter "
        f"of {_short(fit.scatter_n)} N."
    )


def _closest_words(data: str, found: Compared) -> str:
    law, fit = _closest(found)
    words = (
        f"{capital(_WHERE[data])}, {law_words(law)} has an RMS error of {_short(fit.error_n)} N "
        f"at a measured friction of {_short(fit.friction_n)} N"
    )
    if _is_shifted(fit):
        explained = "an error of the instruments, such as an offset of the force, would explain"
        left = _short(fit.misfit_n)
        return f"{words}; {explained} {'all of it' if left == '0' else f'all but {left} N'}."
    return f"{words}."


def _verdict(fit: LackOfFit) -> str:
    if not fit.describes:
        return "no"
    return "if shifted" if _is_shifted(fit) else "yes"


def _is_shifted(fit: LackOfFit) -> bool:
    """Return whether most of the error is one of the instruments."""
    left = math.hypot(fit.misfit_n, fit.scatter_n)
    return fit.error_n > NEGLIGIBLE_MISFIT * fit.friction_n and left < fit.error_n / 2


def _closest(found: Compared) -> tuple[str, LackOfFit]:
    return min(found, key=lambda each: each[1].misfit_n)


def _short(value: float) -> str:
    return significant(value, 2) if value < 100 else significant(value, 3)
