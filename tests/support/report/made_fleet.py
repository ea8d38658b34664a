"""A fleet's table without campaigns: its numbers are drawn here, with a known truth."""

from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path

import numpy as np

from hbench.analysis.fleet.summary import summarize
from hbench.records import Fleet, FleetNumber, FleetRow
from hbench.store.fleet.table import TABLE, FleetTable, cells_of, write_table
from hbench.workflow.fleet import report_link

FAILURE = "campaign.yaml: 'name'"
START = datetime(2026, 3, 2, 7, 0, tzinfo=UTC)
SE = {"friction_n": 4.0, "efficiency": 0.0008, "b_viscous_n_s_m": 60.0, "v_stribeck_m_s": 0.004}
MIDDLE = {"friction_n": 390.0, "efficiency": 0.857, "b_viscous_n_s_m": 2750, "v_stribeck_m_s": 0.07}
BETWEEN = {"friction_n": 9.0, "efficiency": 0.002, "b_viscous_n_s_m": 80, "v_stribeck_m_s": 0.006}


def made_row(
    number: int,
    rng: np.random.Generator,
    path: str,
    days: float,
    drift_n: float = 0.0,
    off_n: float = 0.0,
    noisy: float = 1.0,
) -> FleetRow:
    """A campaign with friction extending that is off by ``drift_n`` and ``off_n``."""
    numbers = {}
    for name, middle in MIDDLE.items():
        for direction, factor in (("extend", 1.0), ("retract", 1.2)):
            se = noisy * SE[name]
            value = factor * middle + rng.normal(0, BETWEEN[name]) + rng.normal(0, se)
            if (name, direction) == ("friction_n", "extend"):
                value += drift_n + off_n
            if name == "efficiency" and direction == "retract":
                value = min(value - 0.2 * middle, 1.0)
            half = 4.3 * se + 0.03 * middle
            numbers[name, direction] = FleetNumber(value, value - half, value + half, se)
    return FleetRow(
        path=path,
        name="cylinder test",
        source="real",
        bench="end-of-line bench",
        started=START + timedelta(days=days),
        protocol="1257/766 mm²; extend 2000 N, 15 bar; retract −2000 N, 110 bar; 35 mm/s",
        area_piston_m2=1.257e-3,
        area_rod_m2=7.66e-4,
        stroke_m=0.4,
        quality="good" if noisy == 1.0 else "poor",
        runs=36,
        accepted=36 if noisy == 1.0 else 27,
        v_m_s=0.035,
        numbers=numbers,
    )


def made_table(
    folder: Path, campaigns: int, drift_n: float = 0.0, off: dict[int, float] | None = None,
    failed: tuple[int, ...] = (), noisy: tuple[int, ...] = (), seed: int = 1, name: str = "",
) -> Path:  # fmt: skip
    """Write a table: ``drift_n`` over all, ``off`` [N] of some, one campaign an hour."""
    rng = np.random.default_rng(seed)

    def rows():
        for i in range(campaigns):
            path = str(folder / "line" / f"{name}{i:07d}")
            if i in failed:
                yield cells_of(FleetRow(path, failed=FAILURE))
                continue
            yield cells_of(
                made_row(
                    i,
                    rng,
                    path,
                    i / 24,
                    drift_n * i / campaigns,
                    (off or {}).get(i, 0.0),
                    10.0 if i in noisy else 1.0,
                )  # fmt: skip
            )

    write_table(folder / TABLE, rows())
    return folder


def summary_of(
    folder: Path, tolerance=None, requirements=(), decision=lambda _: "", checks=lambda _: ()
) -> Fleet:
    """The summary of the table in a folder, by default without tolerance, limits and decisions."""
    table, link = FleetTable(folder / TABLE), partial(report_link, folder)
    return summarize(table, link, tolerance, requirements, decision, checks)
