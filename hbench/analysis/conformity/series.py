"""Measured checks of several cylinders, matched by what they are of."""

from collections.abc import Sequence

from hbench.records.conformity.acceptance import ConformityCheck
from hbench.records.rod_pressure import series_key

Series = tuple[tuple, tuple, int]  # requirement, label and load, number of its kind


def checks_by_series(checks: Sequence[ConformityCheck]) -> dict[Series, ConformityCheck]:
    """Return the measured checks of a cylinder by what they are of.

    Measured speeds, which differ a little from cylinder to cylinder, are no part of that: several
    speeds of a series are counted.
    """
    found: dict[Series, ConformityCheck] = {}
    for check in checks:
        what, series = check.requirement, check.measurement
        if series is None:
            continue
        load = series_key(series)
        named = (what.quantity, what.unit, what.name, what.v_m_s, what.dwell_s, what.leak)
        count = sum(key[:2] == (named, load) for key in found)
        found[named, load, count] = check
    return found
