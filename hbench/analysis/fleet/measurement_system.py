"""Precision, control charts and wear of the numbers of a fleet's table."""

from functools import partial
from typing import Literal, NamedTuple

import numpy as np

from hbench.analysis.fleet.control_chart import Charted, control_charts
from hbench.analysis.fleet.precision import Tolerance, plan_of, precision_of
from hbench.analysis.fleet.wear import WEARING, corrected, cumulated, wear_trends
from hbench.records import CYLINDER, QUANTITIES, ControlChart, Precision, Quantity, Side, WearTrend
from hbench.records.fleet.campaign_names import distinct_names
from hbench.store.fleet.table import FleetTable

_TOLERATED = ("friction_n", "half_band_n", "efficiency")  # numbers that a tolerance is of
_AMOUNTS: tuple[Literal["distance_m", "friction_work_j"], ...] = ("distance_m", "friction_work_j")


class MeasurementSystem(NamedTuple):
    """What repeated campaigns show about the measurement and its cylinders."""

    precision: tuple[Precision, ...]
    notes: tuple[str, ...]  # on the plan
    charts: tuple[ControlChart, ...]
    wear: tuple[WearTrend, ...]


def measurement_system(
    table: FleetTable,
    good: np.ndarray,
    compared: np.ndarray,
    days: np.ndarray,
    tolerance: Tolerance | None,
) -> MeasurementSystem:
    """Return what the ``compared`` campaigns (rows,) show.

    ``good`` (rows,) are those that could be analyzed: all of them wear a cylinder. ``days`` (rows,)
    are days since the first campaign, NaN where the date is not known.
    """
    cylinders, names = _cylinders(table)
    rows = np.flatnonzero(compared)
    identities = {
        name: [str(text or "") for text in table.values(name, rows)]
        for name in ("operator", "mounting", "day")
    }
    identities[CYLINDER] = [names[i] if i >= 0 else "" for i in cylinders[rows]]
    plan = plan_of(rows, identities)
    dated = np.isfinite(days)
    charted = np.flatnonzero(compared & dated)
    moving = np.flatnonzero(good & dated & (cylinders >= 0))
    sums = {amount: np.full(table.rows, np.nan) for amount in _AMOUNTS}
    for amount, total in sums.items():
        total[moving] = cumulated(table.numbers(amount)[moving], cylinders[moving], days[moving])

    campaigns = _campaigns(table)
    studies: list[Precision] = []
    notes = dict.fromkeys(plan.notes)
    numbers: list[Charted] = []
    trends: list[WearTrend] = []
    for quantity, direction in _numbers():
        column = quantity.column(direction)
        x = table.numbers(column)
        if len(plan.rows):
            endings = ("_se", "_trials", "_dof")
            columns = np.array(
                [x[plan.rows], *(table.numbers(f"{column}{e}")[plan.rows] for e in endings)]
            )
            width = _width(quantity, tolerance)
            study, remarks = precision_of(quantity, direction, plan, columns, width)
            studies += [] if study is None else [study]
            notes |= dict.fromkeys(remarks)
        at = charted[np.isfinite(x[charted])]
        named = partial(_named, campaigns, at)
        numbers.append(Charted(quantity, direction, days[at], x[at], cylinders[at], named))
        if quantity.name in WEARING:
            worn = charted[cylinders[charted] >= 0]
            amounts = {amount: total[worn] for amount, total in sums.items()}
            trends += wear_trends(quantity, direction, x[worn], amounts, cylinders[worn], names)
    return MeasurementSystem(
        tuple(studies), tuple(notes), control_charts(numbers), corrected(trends)
    )


def _numbers() -> list[tuple[Quantity, Side]]:
    """Return the numbers that repeated trials measure."""
    return [(each, side) for each in QUANTITIES if each.listed for side in each.sides]


def _campaigns(table: FleetTable) -> np.ndarray:
    """Return the name of each row's campaign (rows,)."""
    paths = table.values("path", np.arange(table.rows))
    names = distinct_names(paths)
    return np.array([names[path] for path in paths])


def _named(campaigns: np.ndarray, rows: np.ndarray, positions: np.ndarray) -> list[str]:
    """Return the names of the campaigns at some positions in ``rows``."""
    return list(map(str, campaigns[rows[positions]]))


def _cylinders(table: FleetTable) -> tuple[np.ndarray, list[str]]:
    """Return the cylinder of each row (rows,) as a position in a list of names; -1: not stated.

    Its serial number names it, or else the campaign's single label.
    """
    names: dict[str, int] = {}
    every = np.arange(table.rows)
    numbers = [
        names.setdefault(serial or label, len(names)) if serial or label else -1
        for serial, label in zip(
            table.values("specimen", every), table.values("label", every), strict=True
        )
    ]
    return np.array(numbers, dtype=int), list(names)


def _width(quantity: Quantity, tolerance: Tolerance | None) -> float | None:
    applies = tolerance is not None and quantity.name in _TOLERATED
    return tolerance.value if applies and tolerance and tolerance.unit == quantity.unit else None
