"""Zero errors of the sensors that U does not contain, in words."""

from collections.abc import Mapping
from typing import Any

from hbench.records import Results
from hbench.report.quality_words import LOAD_CELL_ZERO
from hbench.report.render.symbols import capital, listed

_NO_ZEROS = (
    "The campaign has no zero checks of the sensors (experiments of kind check): u contains zero "
    "errors only as far as the stated tolerances do."
)
_SENSORS = {"force": ("the load cell", "f_"), "pressure": ("the pressure transducers", "p_")}


def zero_reserve(results: Results) -> str:
    """State which sensors' zero errors U does not contain; empty if none.

    Those are sensors whose stated errors are all relative to the reading, and whose zeros the
    campaign did not check.
    """
    instruments = results.provenance.settings.get("instruments", {})
    checked = {zero.channel for check in results.motions.zero_checks for zero in check.zeros}
    names = [
        words
        for name, (words, prefix) in _SENSORS.items()
        if _of_reading(instruments.get(name))
        and not any(channel.startswith(prefix) for channel in checked)
    ]
    if not names:
        return ""
    several = len(names) > 1 or names[0].endswith("s")
    whose, tolerances, zeros = (
        ("their", "tolerances are", "zeros were")
        if several
        else ("its", "tolerance is", "zero was")
    )
    return (
        f"U contains no zero error of {listed(names)}: {whose} {tolerances} relative to the "
        f"reading, and {whose} {zeros} not checked."
    )


def zero_notes(results: Results) -> tuple[str, ...]:
    """Return what the combined uncertainty u contains of zero errors that were not checked."""
    if reserve := zero_reserve(results):
        return (reserve,)
    if results.motions.load_cell_zero_unchecked:
        return (f"{capital(LOAD_CELL_ZERO)}.",)
    return () if results.motions.zero_checks else (_NO_ZEROS,)


def tolerance_words(instruments: Mapping[str, Any]) -> str:
    """Return the stated tolerances, such as ``force 1.0 % of reading``; empty without any."""
    stated = []
    for name in _SENSORS:
        instrument = instruments.get(name)
        if isinstance(instrument, Mapping) and instrument.get("tolerance"):
            of = "reading" if instrument.get("of") == "reading" else "full scale"
            stated.append(f"{name} {instrument['tolerance']} of {of}")
    return f"tolerances: {', '.join(stated)}" if stated else ""


def _of_reading(instrument: Any) -> bool:
    """Return whether all stated errors of an instrument are relative to its reading."""
    if not isinstance(instrument, Mapping) or not instrument.get("tolerance"):
        return False
    further = instrument.get("further") or {}
    return all(each.get("of") == "reading" for each in (instrument, *further.values()))
