"""A fleet's table of a plan: cylinders, operators, mountings and days with known effects."""

import math
from dataclasses import replace
from datetime import timedelta

import numpy as np

from hbench.records import FleetNumber, FleetRow
from hbench.store.fleet.table import TABLE, cells_of, write_table
from tests.support.report.made_fleet import START, made_row

SIGMA_N = {"cylinder": 20.0, "operator": 6.0, "mounting": 5.0, "trials": 4.0}
WEAR_N_M = -0.05  # of the first cylinder
WAY_M = 200.0  # of a campaign


def plan_rows(
    cylinders: int = 8,
    operators: int = 3,
    mountings: int = 2,
    lost: float = 0.0,
    seed: int = 5,
    trials: int = 3,
) -> list[FleetRow]:
    """Campaigns of each cylinder by each operator, mounted again by each; some of them lost.

    The truth is not the model of the analysis: the effects are Laplace's, the trials Student's with
    five degrees of freedom, and the scatter grows with the level of friction.
    """
    rng = np.random.default_rng(seed)

    def laplace(name: str, *shape: int) -> np.ndarray:
        return SIGMA_N[name] / math.sqrt(2) * rng.laplace(size=shape)

    of_cylinder, of_operator = laplace("cylinder", cylinders), laplace("operator", operators)
    order = [
        (c, o, m) for m in range(mountings) for o in range(operators) for c in range(cylinders)
    ]
    rows = []
    for number, (c, o, m) in enumerate(order):
        mounted = laplace("mounting")
        if rng.random() < lost:
            continue
        path = f"/plan/c{c + 1}-{'ABCDEF'[o]}{m + 1}"
        row = made_row(number, rng, path, number / 6)
        numbers = dict(row.numbers)
        for direction, level in (("extend", 390.0), ("retract", 470.0)):
            worn = WEAR_N_M * WAY_M * (number // cylinders) * (c == 0)
            mean = level + of_cylinder[c] + of_operator[o] + mounted + worn
            scatter = SIGMA_N["trials"] * mean / level * math.sqrt(3 / 5)
            drawn = mean + scatter * rng.standard_t(5, size=trials)
            value, se = float(drawn.mean()), float(drawn.std(ddof=1) / math.sqrt(trials))
            half = 4.3 * se + 12.0
            numbers["friction_n", direction] = FleetNumber(
                value, value - half, value + half, se, float(trials), trials - 1.0
            )
        started = START + timedelta(days=number // 6, minutes=45 * (number % 6))
        rows.append(
            replace(
                row,
                numbers=numbers,
                started=started,
                specimen=f"C-{c + 1:03d}",
                operator="ABCDEF"[o],
                mounting=f"{'ABCDEF'[o]}{m + 1}",
                day=f"{started:%Y-%m-%d}",
                distance_m=WAY_M,
                friction_work_j=WAY_M * 400.0,
            )
        )
    return sorted(rows, key=lambda row: row.path)


def write_plan(folder, rows):
    """Write the table of some rows; return its folder."""
    folder.mkdir(parents=True, exist_ok=True)
    write_table(folder / TABLE, map(cells_of, rows))
    return folder
