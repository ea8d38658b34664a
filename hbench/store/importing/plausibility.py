"""Plausibility of pressures, forces and dates: absolute pressures, other units, unset clocks.

Pressures of a cylinder are those above the atmosphere: it acts on the rod, so that F_T of absolute
pressures would be too large by p_atm (A_p - A_r).
"""

import re
from collections import defaultdict
from collections.abc import Hashable, Iterable, Iterator, Mapping
from datetime import datetime
from itertools import pairwise
from statistics import fmean, median
from typing import NamedTuple

import numpy as np

from hbench.channels import CHANNELS
from hbench.config.import_layout import ImportedCylinder
from hbench.config.import_map import ImportMap
from hbench.store.importing.file_notes import FileNote
from hbench.units import from_si, to_si

ATMOSPHERE = "1.013 bar"  # at sea level
_NOISE = 0.02  # of a channel's range in the file
_OVERRANGE = 1.1  # of the full scale, which sensors can show
# Ratios of units that are mistaken for one another, by the unit in SI.
_RATIOS = {
    "Pa": {
        6.895: "kPa and psi", 10.0: "bar and MPa", 14.50: "psi and bar", 100.0: "kPa and bar",
        145.0: "psi and MPa", 1000.0: "kPa and MPa", 1e5: "Pa and bar", 1e6: "Pa and MPa",
    },
    "N": {4.448: "N and lbf", 9.807: "N and kgf", 1000.0: "N and kN"},
}  # fmt: skip
_SAME_RATIO = 1.1  # trials of one point differ by less
_LEAST_LEVEL = 0.01  # of a channel's largest level: below it is the error of its zero
# After a unit: bara, bar(a), psia, kPa abs. A blank or a capital A may be the port: bar A.
_BEHIND_UNIT = re.compile(
    r"(?:bar|psi|Pa)(?:a|\(a\)|[\s_]*[(\[]?abs(?:olute?)?\.?[)\]]?)(?![^\W_])"
)
_WORD = re.compile(r"(?<![^\W_])abs(?:olut\w*)?(?![^\W_])|absolutdruck", re.IGNORECASE)


class Levels(NamedTuple):
    """Mean magnitudes [SI] of the measured channels of a run, by channel."""

    file: str
    point: Hashable  # runs of one operating point have it in common
    of: Mapping[str, float]


def other_units(runs: Iterable[Levels]) -> Iterator[FileNote]:
    """Yield a note on each channel of a file that is larger or smaller than that of other files.

    At the same operating point its level has a ratio to theirs that two units have.
    """
    levels: dict[tuple[str, Hashable], dict[str, list[float]]] = defaultdict(dict)
    largest: dict[str, float] = defaultdict(float)
    for run in runs:
        for channel, level in run.of.items():
            levels[channel, run.point].setdefault(run.file, []).append(level)
            largest[channel] = max(largest[channel], level)
    for (channel, _), of_files in levels.items():
        for file, own in of_files.items():
            others = [fmean(each) for name, each in of_files.items() if name != file]
            if not others:
                continue
            level, usual = fmean(own), median(others)
            if not max(level, usual) > _LEAST_LEVEL * largest[channel] or not min(level, usual) > 0:
                continue
            units = _units_apart(channel, max(level, usual) / min(level, usual))
            if units:
                text = (
                    f"{channel}: has {{ratio}} times its values in other files of the same "
                    f"operating point, as if {units} were mistaken for one another: check the "
                    "unit in this file; import files of each unit with a map of their own"
                )
                yield FileNote(file, text, {"ratio": float(f"{level / usual:.3g}")})


class LoggedSpan(NamedTuple):
    """First and last time of a file, by its dates."""

    file: str
    start: datetime
    stop: datetime


def at_the_same_time(spans: Iterable[LoggedSpan]) -> str:
    """Return a note if two files of one bench have the same times; empty if none have.

    The end of a file may be the beginning of the next one: they share half of the shorter one.
    """
    for before, after in pairwise(sorted(spans, key=lambda span: span.start)):
        shared = min(before.stop, after.stop) - after.start
        shorter = min(span.stop - span.start for span in (before, after))
        if 2 * shared > shorter:
            return (
                f"{before.file} and {after.file} were logged at the same time by their dates, as "
                "if a clock had not been set: the dates are not used, and the order of the runs "
                "is that of the files' names"
            )
    return ""


def _units_apart(channel: str, ratio: float) -> str:
    """Return two units of a channel with this ratio; empty if there are none."""
    for known, units in _RATIOS.get(CHANNELS[channel].unit, {}).items():
        if 1 / _SAME_RATIO < ratio / known < _SAME_RATIO:
            return units
    return ""


def is_absolute_pressure(channel: str, *names: str) -> bool:
    """Return whether the ``names`` of a channel's column and unit state an absolute pressure."""
    return CHANNELS[channel].unit == "Pa" and any(
        pattern.search(name) for name in names for pattern in (_BEHIND_UNIT, _WORD)
    )


def below_vacuum(name: str, channels: Mapping[str, np.ndarray]) -> Iterator[FileNote]:
    """Yield a note for each pressure [Pa] of the file ``name`` that is below a vacuum."""
    for channel, values in channels.items():
        if not channel.endswith("_pa") or not np.isfinite(values).any():
            continue
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        below = values < -to_si(ATMOSPHERE, "Pa") - _NOISE * (high - low)
        if below.any():
            text = (
                f"{channel}: down to {{low}} bar, below a vacuum (-{ATMOSPHERE}) in {{count}} of "
                "{samples} samples: check its zero, sign, unit and offset"
            )
            numbers = {"low": from_si(low, "bar"), "count": below.sum(), "samples": len(values)}
            yield FileNote(name, text, numbers)


def beyond_full_scale(
    name: str, channels: Mapping[str, np.ndarray], rules: ImportMap
) -> Iterator[FileNote]:
    """Yield a note for each measured channel of the file ``name`` with values beyond 110 %."""
    if rules.instruments is None:
        return
    ranges = {
        "p_tp_pa": (rules.instruments.pressure.full_scale, "bar"),
        "p_tr_pa": (rules.instruments.pressure.full_scale, "bar"),
        "f_applied_n": (rules.instruments.force.full_scale, rules.unit("f_applied_n")),
    }
    for channel, (full_scale, unit) in ranges.items():
        if channel not in rules.columns:
            continue
        size = np.abs(channels[channel])
        beyond = size > _OVERRANGE * full_scale
        if beyond.any():
            text = (
                f"{channel}: up to {{high}} {unit} in size, beyond the instrument's full scale "
                f"({from_si(full_scale, unit):g} {unit}) in {{count}} of {{samples}} samples: "
                "check its unit and scale, and full_scale in the map"
            )
            numbers = {
                "high": from_si(float(np.nanmax(size)), unit),
                "count": beyond.sum(),
                "samples": len(size),
            }
            yield FileNote(name, text, numbers)


def forgotten_rod(name: str, cylinder: ImportedCylinder, rules: ImportMap) -> Iterator[FileNote]:
    """Yield a note on a cylinder whose map states no rod, but a pressure on the rod side."""
    is_stated = {"rod_diameter", "rod_area", "displacement"} & cylinder.model_fields_set
    if cylinder.known and not is_stated and "p_tr_pa" in rules.columns:
        acts = "the whole piston area" if cylinder.area_rod_m2 else "no area"
        key = "rod_diameter" if cylinder.area_rod_m2 else "rod_area"
        zero = "0 mm" if cylinder.area_rod_m2 else "0 mm^2"
        text = (
            f"the map states no {key}, so that p_tr_pa acts on {acts}: enter {key}, or write "
            f"'{key}: {zero}' if this is so"
        )
        yield FileNote(name, text)
