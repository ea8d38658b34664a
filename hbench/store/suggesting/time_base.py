"""The column of times of some files, and its unit."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hbench.config.import_layout import DATE_TIME
from hbench.store.suggesting.choice import GUESS, LIKELY, SURE, Choice
from hbench.store.suggesting.quantities import quantity_of
from hbench.store.suggesting.samples import SampleColumn, SampleFile
from hbench.units import parse_unit

_RATES_HZ = (5.0, 50e3)  # of a log in which a motion can be seen
_REGULAR = 20.0  # times the median step: most steps are shorter
_LEAST_STEPS = 0.3  # of the steps of a coarse clock are not zero
_EVENLY = "increases evenly"
_ASSUMED_STEP_S = 0.01  # between numbered samples, to look at their motion
_DAYS = ((20e3, 60e3), (650e3, 800e3))  # of today in spreadsheets and in MATLAB
_SHORT_DAY = 1e-3
_FIRST_DATE = np.datetime64("1970-01-02")  # earlier ones are times of day


@dataclass(frozen=True)
class TimeChoice:
    """The times of some files."""

    choice: Choice | None  # None: the files state times, or contain none
    t_s: tuple[np.ndarray, ...]  # of each file, from its first sample
    repeats: bool = False  # some times are equal to the one before
    stated: bool = False  # by the files beside the columns

    @property
    def rate_hz(self) -> float:
        """Median sampling rate."""
        steps = np.concatenate([np.diff(t[np.isfinite(t)]) for t in self.t_s])
        return float(1 / np.median(steps[steps > 0])) if (steps > 0).any() else np.nan

    def is_that_of(self, column: SampleColumn, i: int, file: SampleFile) -> bool:
        """Return whether a column has these times in ``file``, the number ``i``."""
        own_s = file.own_times.get(column.key) if self.stated else None
        same = own_s is None or np.array_equal(own_s, self.t_s[i], equal_nan=True)
        return len(column.values[i]) == len(self.t_s[i]) and same


def choose_time(files: Sequence[SampleFile], columns: Sequence[SampleColumn]) -> TimeChoice:
    """Choose the column of times: by its name, by its type, or because it increases evenly."""
    named = [c for c in columns if c.meaning.channel == "t_s" and not c.is_date_time]
    positions = [c for c in columns if c.meaning.channel == "x_m"]
    named.sort(
        key=lambda c: (
            not any(_lengths(c) == _lengths(x) for x in positions),
            not c.meaning.is_sure,
            c.unit is None,
        )
    )
    dated = [c for c in columns if c.is_date_time]
    others = [c for c in columns if not c.is_date_time and not c.meaning.quantity]
    for group, how in ((named, "by its name"), (dated, "date-times"), (others, _EVENLY)):
        for column in group:
            seconds = _seconds(column)
            if all(_increases(t) for t in seconds[1]):
                return _choice(column, *seconds, how)
        if group is dated and files[0].own_times:
            keys = (*(x.key for x in positions), *files[0].own_times)
            key = next(k for k in keys if k in files[0].own_times)
            times = tuple(file.own_times[key] for file in files)
            return TimeChoice(None, times, stated=True)
    return TimeChoice(None, tuple(np.zeros(0) for _ in files))


def with_own_times(
    choices: dict[str, Choice], time: TimeChoice, columns: Sequence[SampleColumn]
) -> dict[str, Choice]:
    """Return the choices with the column of times of each that has another number of samples.

    This is one of the same length and unit, of the same group or struct if there is one.
    """
    out = dict(choices)
    for channel, choice in choices.items() if time.choice is not None else ():
        lengths = _lengths(choice.column)
        if lengths == [len(t) for t in time.t_s]:
            continue
        fits = [c for c in columns if c.meaning.channel == "t_s" and _lengths(c) == lengths]
        fits.sort(key=lambda c: _group(c) != _group(choice.column))
        for column in fits[:1]:
            unit, t_s = _seconds(column)
            if time.choice is not None and unit == time.choice.unit and all(map(_increases, t_s)):
                out[channel] = replace(choice, time=column)
    return out


def _lengths(column: SampleColumn) -> list[int]:
    return list(map(len, column.values))


def _group(column: SampleColumn) -> str:
    """Return the group or struct in a column's path; empty if it has none."""
    return str(column.key).replace(".", "/").rpartition("/")[0]


def _choice(column: SampleColumn, unit: str, t_s: tuple[np.ndarray, ...], how: str) -> TimeChoice:
    if how == _EVENLY and column.unit is None and _counts(column):
        reason = "numbers of samples: give the seconds from one to the next as scale"
        choice = Choice(column, "s", False, GUESS, reason, scale=None)
        return TimeChoice(choice, tuple(np.arange(len(t)) * _ASSUMED_STEP_S for t in t_s))
    if column.is_date_time:
        certainty, reason = SURE, how
        if all(len(v) and v[0] < _FIRST_DATE for v in column.values):
            reason = "times of day; for the order of the runs add test: {date: 2026-03-02}"
    elif column.unit is not None:
        certainty, reason = (SURE if how == "by its name" else LIKELY), how
    else:
        certainty = LIKELY if how == "by its name" else GUESS
        reason = f"{how}; {unit} assumed from its steps"
    choice = Choice(column, unit, column.in_file and not column.is_date_time, certainty, reason)
    steps = np.concatenate([np.diff(t) for t in t_s])
    return TimeChoice(choice, t_s, repeats=bool((steps == 0).any()))


def _counts(column: SampleColumn) -> bool:
    """Return whether the column contains the numbers of its rows."""
    return all(bool((np.diff(v[np.isfinite(v)]) == 1).all()) for v in column.values)


def _seconds(column: SampleColumn) -> tuple[str, tuple[np.ndarray, ...]]:
    """Return a column's unit and its times [s] in each file."""
    if column.is_date_time:
        return DATE_TIME, tuple((v - v[0]) / np.timedelta64(1, "ns") * 1e-9 for v in column.values)
    unit = column.unit if quantity_of(column.unit) == "time" else None
    unit = unit or _assumed_unit(column)
    factor = parse_unit(unit).factor
    return unit, tuple((v - v[np.isfinite(v)][0]) * factor for v in column.values)


def _assumed_unit(column: SampleColumn) -> str:
    steps = np.concatenate([np.diff(v[np.isfinite(v)]) for v in column.values])
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else 1.0
    start = column.known[0]
    if step < _SHORT_DAY and any(low < start < high for low, high in _DAYS):
        return "d"
    for unit in ("s", "ms", "us", "ns"):
        if _RATES_HZ[0] <= 1 / (step * parse_unit(unit).factor) <= _RATES_HZ[1]:
            return unit
    return "s"


def _increases(t_s: np.ndarray) -> bool:
    """Return whether times increase evenly, apart from gaps and repeats of a coarse clock."""
    steps = np.diff(t_s[np.isfinite(t_s)])
    if len(steps) < 2 or (steps < 0).any() or np.mean(steps > 0) < _LEAST_STEPS:
        return False
    return bool(np.quantile(steps, 0.9) <= _REGULAR * np.median(steps[steps > 0]))
