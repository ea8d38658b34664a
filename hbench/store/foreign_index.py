"""Reads a folder in the default layout: an index ``runs.csv`` and one CSV a run, all in SI.

``bench.yaml`` beside the index, if there, tells the cylinder and all else about the bench.
"""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hbench.config.bench import parse_bench
from hbench.config.importmap import Format
from hbench.config.loading import read_yaml
from hbench.errors import DataError
from hbench.records import RunPlan, Specimen
from hbench.store.foreign_run import ForeignRun, ForeignRuns, read_source
from hbench.store.journal import check_run_id
from hbench.store.run_csv import read_channels
from hbench.store.table import Table, parse_table

INDEX = "runs.csv"
BENCH = "bench.yaml"

_KINDS = ("steady", "ramp", "triangle", "steps", "hold", "verification")
_REQUIRED = ("run", "file", "v_ref_m_s")
_OPTIONAL = ("a_ref_m_s2", "f_load_n", "p_lr_ref_pa", "p_lp_ref_pa")
_COLUMNS = (*_REQUIRED, "kind", "trial", "label", *_OPTIONAL)
# The source's own cylinder, 40/25/400 mm, for logs that come without a bench file.
_REFERENCE = Specimen(area_piston_m2=1.25664e-3, area_rod_m2=7.65763e-4, stroke_m=0.4)


def read_indexed(folder: Path) -> ForeignRuns:
    """Read the runs that ``runs.csv`` lists. Raises ``DataError`` naming file and line."""
    index = parse_table(read_source(folder, INDEX).data, str(folder / INDEX), Format())
    for name in _REQUIRED:
        index.position(name)
    bench, specimen, notes = _bench(folder)
    notes += _left_out(INDEX, [name for name in index.names if name not in _COLUMNS])
    runs: list[ForeignRun] = []
    lines: dict[str, int] = {}
    for row, cells in enumerate(index.rows):
        plan, name = _plan(index, row, dict(zip(index.names, cells, strict=True)), specimen)
        if plan.run in lines:
            raise _fault(index, row, "run", plan.run, f"stands in line {lines[plan.run]} too")
        lines[plan.run] = index.line(row)
        file = read_source(folder, name)
        channels, others = read_channels(file.data, str(folder / name))
        notes += _left_out(name, others)
        runs.append(ForeignRun(plan, channels, file, (2, 1 + len(channels["t_s"]))))
    return ForeignRuns(tuple(runs), notes, bench)


def _left_out(name: str, columns: Sequence[str]) -> tuple[str, ...]:
    known = f"{name}: unknown columns are left out: {', '.join(columns)}"
    return (known,) if columns else ()


def _bench(folder: Path) -> tuple[dict[str, Any] | None, Specimen, tuple[str, ...]]:
    path = folder / BENCH
    if not path.exists():
        note = (
            f"no {BENCH} beside {INDEX}: the cylinder under test is taken to be the reference "
            "bench's (40 mm piston, 25 mm rod, 400 mm stroke)"
        )
        return None, _REFERENCE, (note,)
    content = read_yaml(path)
    cylinder = parse_bench(content, str(path)).test_cylinder
    specimen = Specimen(cylinder.area_piston_m2, cylinder.area_rod_m2, cylinder.stroke)
    return {"file": BENCH, "content": content}, specimen, ()


def _plan(index: Table, row: int, cells: dict[str, str], specimen: Specimen) -> tuple[RunPlan, str]:
    """Return the plan and the file of one row of the index."""
    cells = {name: cell.strip() for name, cell in cells.items()}
    kind = cells.get("kind") or "steady"
    if kind not in _KINDS:
        raise _fault(index, row, "kind", kind, f"expected one of {', '.join(_KINDS)}")
    trial = cells.get("trial") or "1"
    if not trial.isdecimal() or int(trial) < 1:
        raise _fault(index, row, "trial", trial, "expected a number from 1")
    plan = RunPlan(
        run=check_run_id(cells["run"], f"{index.source}: line {index.line(row)}"),
        kind=kind,
        trial=int(trial),
        v_ref_m_s=_number(index, row, "v_ref_m_s", cells["v_ref_m_s"]),
        specimen=specimen,
        label=cells.get("label", ""),
        **{name: _number(index, row, name, cells[name]) for name in _OPTIONAL if cells.get(name)},
    )
    return plan, cells["file"]


def _number(index: Table, row: int, column: str, cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise _fault(index, row, column, cell, "expected a number")
    return value


def _fault(index: Table, row: int, column: str, found: str, expected: str) -> DataError:
    return DataError(f"{index.source}: line {index.line(row)}: {column} {found!r}: {expected}")
