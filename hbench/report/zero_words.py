"""Zero errors of the sensors that U does not contain, in words."""

from collections.abc import Mapping, Sequence
from typing import Any

from hbench.records import Results
from hbench.report.quality_words import LOAD_CELL_ZERO
from hbench.report.render.numbers import significant
from hbench.sentences import capital, listed
from hbench.units import to_si

_NO_ZEROS = (
    "The campaign has no zero checks of the sensors (experiments of kind check): u contains zero "
    "errors only as far as the stated tolerances do."
)
_ZERO_ERROR = 1e-3  # of full scale, for an example
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
        f"reading, and {whose} {zeros} not checked.{_example(results, names)}"
    )


def _example(results: Results, names: Sequence[str]) -> str:
    """Return how much small zero errors of the sensors would change friction; empty if unknown."""
    instruments = results.provenance.settings.get("instruments", {})
    area = results.runs[0].run.plan.specimen.area_piston_m2 if results.runs else 0.0
    parts = []
    for name, (words, _), unit, per_unit in (
        ("force", _SENSORS["force"], "N", 1.0),
        ("pressure", _SENSORS["pressure"], "Pa", area),
    ):
        full_scale = instruments.get(name, {}).get("full_scale")
        if words in names and full_scale and per_unit:
            change = _ZERO_ERROR * to_si(full_scale, unit) * per_unit
            one = "the piston-side transducer" if name == "pressure" else words
            parts.append(f"{significant(change, 2)} N ({one}, {full_scale})")
    if not parts:
        return ""
    return f" A zero error of 0.1 % of full scale would change friction by {listed(parts)}."


def zero_notes(results: Results) -> tuple[str, ...]:
    """Return what u contains of zero errors that were not checked; the summary has the reserve."""
    if zero_reserve(results):
        return ()
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
