"""Tables, timetables, datetimes and durations in a MATLAB 7.3 file."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hbench.store.formats.arrays import Signal
from hbench.store.formats.matlab.hdf5 import Group, cells, channel_of, texts
from hbench.store.formats.matlab.objects import ObjectStore


@dataclass(frozen=True)
class _Times:
    """Date-times or durations [ms], as sums of a large and a small part."""

    is_date: bool  # since 1970
    size: int
    read: Callable[[], tuple[np.ndarray, np.ndarray]]

    def signal(self) -> Signal:
        """Return the date-times (datetime64), or the durations in s."""
        if self.is_date:
            return Signal(self.size, self._dates)
        return Signal(self.size, self.seconds, unit="s")

    def seconds(self, origin_ms: float = 0.0) -> np.ndarray:
        """Return the times (n,) [s] since ``origin_ms``."""
        large, small = self.read()
        return ((large - origin_ms) + small) * 1e-3

    def _dates(self) -> np.ndarray:
        large, small = self.read()
        whole = np.floor(large)
        ns = whole.astype(np.int64) * 1_000_000 + np.round((large - whole + small) * 1e6)
        return ns.astype(np.int64).astype("datetime64[ns]")


class ObjectReader:
    """Reader of the objects in an HDF5 file ``content`` that contain channels."""

    def __init__(self, content: Group):
        self._content = content
        self._store = ObjectStore(content)
        self._origins_ms: list[float] = []  # of the timetables with date-times

    def read(self, node: Any) -> tuple[bool, Any]:
        """Return whether ``node`` is an object, and what it contains.

        That is a dict of columns for a table, a signal for times, else None; also for an object
        that is stored otherwise than expected, since other variables may be readable.
        """
        try:
            found = self._store.find(node)
            return found is not None, self._content_of(node, *found) if found else None
        except Exception:  # of many kinds
            return True, None

    def _content_of(self, node: Any, name: str, about: Mapping[str, Any]) -> Any:
        if name == "timetable":
            return self._timetable(about["any"])
        if name == "table":
            units = about["props"].get("VariableUnits")
            return self._columns(about["data"], about["varnames"], units, None)
        times = self._times(node)
        return times.signal() if times is not None else None

    def _timetable(self, table: Mapping[str, Any]) -> dict[str, Any]:
        times = self._row_times(table["rowTimes"], int(table["numRows"][()].item()))
        if times is None:
            return self._columns(table["data"], table["varNames"], table.get("varUnits"), None)
        if times.is_date and times.size:
            self._origins_ms.append(times.read()[0][0])

        def seconds() -> np.ndarray:
            return times.seconds(min(self._origins_ms) if times.is_date else 0.0)

        columns = self._columns(table["data"], table["varNames"], table.get("varUnits"), seconds)
        return {texts(self._content, table["dimNames"])[0]: times.signal(), **columns}

    def _columns(
        self, data: Any, names: Any, units: Any, times: Callable[[], np.ndarray] | None
    ) -> dict[str, Any]:
        """Return the variables of a table; None for one that is not numeric."""
        given = texts(self._content, units) if units is not None else []
        given += [""] * data.size
        return {
            name: None
            if isinstance(node, Group) or self._store.find(node) is not None
            else channel_of(node, times, unit or None)
            for name, node, unit in zip(
                texts(self._content, names), cells(self._content, data), given, strict=False
            )
        }

    def _row_times(self, node: Any, count: int) -> _Times | None:
        """Return row times: an object, or a struct of origin and step or rate."""
        if not isinstance(node, Group):
            return self._times(node)
        origin = self._times(node["origin"])
        if origin is None:
            return None
        if node["specifiedAsRate"][()].item():
            step_ms = 1e3 / node["sampleRate"][()].item()
        else:
            step = self._times(node["stepSize"])
            if step is None:  # a calendarDuration
                return None
            step_ms = float(step.read()[0][0])

        def read() -> tuple[np.ndarray, np.ndarray]:
            large, small = origin.read()
            return np.full(count, large[0]), small[0] + step_ms * np.arange(count)

        return _Times(origin.is_date, count, read)

    def _times(self, node: Any) -> _Times | None:
        """Return an object of class datetime or duration; None for another."""
        name, about = self._store.find(node) or ("", {})
        data = about.get({"datetime": "data", "duration": "millis"}.get(name, ""))
        if data is None:
            return None

        def read() -> tuple[np.ndarray, np.ndarray]:
            values = data[()].ravel()
            if values.dtype.names:  # complex: the imaginary part is below the resolution
                return values["real"], values["imag"]
            return values, np.zeros(len(values))

        return _Times(name == "datetime", data.size, read)
