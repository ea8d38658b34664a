"""Detection of stuck sensors in imported logs: a channel that is constant in a whole file.

Within one file, a stuck pressure sensor looks like a regulated pressure with a coarse resolution.
The other files show the difference: there, a stuck sensor's channel has many values. A channel that
is constant at 0 is not reported: an idle load cell and a vented chamber read 0 as well. A channel
that is constant beyond all values of the files in which its noise is resolved is at the end of its
range, in however many files.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hbench.channels import CHANNELS
from hbench.store.importing.channels import FileChannels
from hbench.store.importing.file_notes import FileNote
from hbench.units import from_si

_SENSORS = ("p_tp_pa", "p_tr_pa", "f_applied_n", "f_drive_n")  # which friction is computed from
_LIVELY = 10  # different values in a file: the sensor and its converter resolve changes
_NOISY = 0.5  # of the samples differ from the one before: the sensor's noise is resolved


@dataclass(frozen=True)
class SensorActivity:
    """Which sensors of a file change, and the values of those that do not."""

    lively: frozenset[str]
    noisy: Mapping[str, float]  # largest magnitude of sensors whose noise is resolved, in SI
    constant: Mapping[str, float]  # in SI, as logged; without those at 0


def activity_of(read: FileChannels, least_travel_m: float) -> SensorActivity:
    """Return the activity of a file's sensors; none if the piston moves less than that."""
    lively, noisy, constant = set(), {}, {}
    if np.ptp(read.channels["x_m"]) >= least_travel_m:
        for name in read.units.keys() & set(_SENSORS):  # the columns; constants of the map are not
            values = read.channels[name]
            known = values[np.isfinite(values)]
            different = np.unique(known)
            zero = read.zeros.get(name)
            offset = 0.0 if zero is None else zero.mean
            if len(different) >= _LIVELY:
                lively.add(name)
                if np.mean(np.diff(known) != 0) > _NOISY:
                    noisy[name] = float(np.abs(different[[0, -1]] + offset).max())
            elif len(different) == 1 and different[0] + offset != 0:
                constant[name] = float(different[0]) + offset
    return SensorActivity(frozenset(lively), noisy, constant)


def stuck_sensors(files: Mapping[str, SensorActivity]) -> dict[str, dict[str, float]]:
    """Return the stuck sensors of each file that has some, with their values.

    A sensor is stuck if it is constant in the file and changes in most of the ``files``, or if its
    constant magnitude exceeds that in all files in which its noise is resolved.
    """
    changing = {
        name
        for name in _SENSORS
        if 2 * sum(name in file.lively for file in files.values()) > len(files)
    }
    largest: dict[str, float] = {}
    for file in files.values():
        for name, magnitude in file.noisy.items():
            largest[name] = max(largest.get(name, 0.0), magnitude)
    stuck = {
        key: {
            name: value
            for name, value in file.constant.items()
            if name in changing or abs(value) > largest.get(name, np.inf)
        }
        for key, file in files.items()
    }
    return {key: found for key, found in stuck.items() if found}


def stuck_note(file: str, name: str, value: float) -> FileNote:
    """Return the note on a stuck sensor."""
    unit = "bar" if CHANNELS[name].unit == "Pa" else CHANNELS[name].unit
    text = (
        f"{name}: is {{value}} {unit} in all samples and changes in the other files: the sensor is "
        "stuck, and the runs are rejected"
    )
    return FileNote(file, text, {"value": from_si(value, unit)})
