"""Reader of a folder in the default layout: an index of runs and a table per run, all in SI.

The index is ``runs.csv`` (a CSV or Parquet file per run), ``runs.parquet`` (the same), or
``campaign.mat`` with the struct array ``runs``, which contains the logs too. An optional
``bench.yaml`` beside it describes the cylinder and the bench.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from hbench.config.bench import parse_bench
from hbench.config.files.loading import read_yaml
from hbench.config.import_layout import Format
from hbench.errors import DataError
from hbench.records import KINDS, RunPlan, Specimen, kind_names
from hbench.store.campaign.journal import check_run_id
from hbench.store.campaign.plan_fields import check_number
from hbench.store.campaign.run_csv import read_channels
from hbench.store.files.bounded_read import check_inside, read_file
from hbench.store.formats.arrays import Arrays
from hbench.store.formats.matlab.mat import read_mat
from hbench.store.formats.parquet import read_parquet, require_pyarrow
from hbench.store.formats.reading import read_apart
from hbench.store.formats.table import Table
from hbench.store.formats.text import TextTable, parse_table
from hbench.store.importing.imported_run import (
    ImportedRun,
    ImportedRuns,
    SourceFile,
    StoreLog,
    describe_source,
    open_source,
)
from hbench.untrusted_text import from_cell

INDICES = ("runs.csv", "runs.parquet", "campaign.mat")
BENCH = "bench.yaml"

_REQUIRED = ("run", "file", "v_ref_m_s")
_OPTIONAL = ("a_ref_m_s2", "f_load_n", "p_lr_ref_pa", "p_lp_ref_pa")
_COLUMNS = (*_REQUIRED, "kind", "trial", "label", *_OPTIONAL)
_OF_EXPORT = ("accepted", "reason")  # ignored: the screening is repeated
# The reference bench's cylinder, 40/25/400 mm, for logs without a bench file.
_REFERENCE = Specimen(area_piston_m2=1.25664e-3, area_rod_m2=7.65763e-4, stroke_m=0.4)


# The index, and a function from a run's number and its cell "file" to its table and file.
_Log = Callable[[int, str], AbstractContextManager[tuple[Table, SourceFile]]]
_Index = tuple[TextTable, _Log]


def read_indexed(folder: Path, store: StoreLog) -> ImportedRuns:
    """Read and store the runs that the folder's index lists.

    Raises ``DataError`` naming file and line.
    """
    present = [name for name in INDICES if (folder / name).is_file()]
    if not present:
        raise DataError(
            f"{folder}: contains none of {', '.join(INDICES)}",
            "For another layout, write a map and give it with --map; see configs/import-csv.yaml.",
        )
    name = present[0]
    index, log = (_mat_index if name.endswith(".mat") else _table_index)(folder, name)
    for column in (*_REQUIRED, *(name for name in index.names if name in _COLUMNS)):
        index.position(column)
    bench, specimen, notes = _bench(folder, name)
    known = (*_COLUMNS, *_OF_EXPORT)
    notes += _left_out(name, [column for column in index.names if column not in known])
    runs: list[ImportedRun] = []
    lines: dict[str, int] = {}
    for row, cells in enumerate(index.rows):
        plan, file_name = _plan(index, row, dict(zip(index.names, cells, strict=True)), specimen)
        if plan.run in lines:
            raise _fault(index, row, "run", plan.run, f"occurs in line {lines[plan.run]} too")
        lines[plan.run] = index.lines[row]
        with log(row, file_name) as (table, file):
            channels, unknown = read_channels(table)
            first, last = table.lines_of(np.array([0, len(channels["t_s"]) - 1])).tolist()
        notes += _left_out(file.name, [column for column in unknown if column != "run"])
        runs.append(ImportedRun(plan, store(file.name, plan.run, channels), file, (first, last)))
        del table, channels  # before the next ones are read
    return ImportedRuns(tuple(runs), (*notes, *_unlisted(folder, name, runs)), bench)


def _unlisted(folder: Path, index: str, runs: Sequence[ImportedRun]) -> Iterator[str]:
    """Report files beside those of the index that no row lists."""
    listed = {(folder / run.file.name).resolve() for run in runs} | {(folder / index).resolve()}
    beside = {(path.parent, path.suffix) for path in listed if path.name != index}
    unlisted = {path for at, suffix in beside for path in at.glob(f"*{suffix}")} - listed
    if unlisted:
        names = sorted(path.relative_to(folder.resolve()).as_posix() for path in unlisted)
        few = ", ".join(names[:10]) + (", ..." if len(names) > 10 else "")
        yield f"{index}: no row for {few}: left out ({len(names)} files)"


def _table_index(folder: Path, name: str) -> _Index:
    path = folder / name
    check_inside(folder, path)
    if name.endswith(".parquet"):
        require_pyarrow()
        data = read_apart(path, _parquet_as_csv, path)
    else:
        data = read_file(path)
    index = parse_table(data, str(path), Format())
    return index, lambda _, file_name: open_source(folder, file_name, Format())


def _parquet_as_csv(path: Path) -> bytes:
    return read_parquet(read_file(path), str(path)).to_csv(index=False).encode()


def _mat_runs(path: Path) -> Any:
    return read_mat(read_file(path), str(path)).get("runs")


def _mat_index(folder: Path, name: str) -> _Index:
    file, path = describe_source(folder, name), folder / name
    source = str(path)
    runs = read_apart(path, _mat_runs, path)
    runs = [runs] if isinstance(runs, dict) else runs
    if (
        not isinstance(runs, (list, np.ndarray))
        or not len(runs)
        or not all(isinstance(run, dict) and "log" in run for run in runs)
    ):
        raise DataError(f"{source}: contains no struct array 'runs' with the field 'log'")
    names = [field for field in runs[0] if field != "log"]
    rows = [[*(_cell(run.get(field)) for field in names), name] for run in runs]
    count = np.arange(1, len(rows) + 1)
    index = TextTable((*names, "file"), (), rows, count, Format(), source)

    def log(row: int, _: str) -> AbstractContextManager[tuple[Table, SourceFile]]:
        return nullcontext((Arrays(runs[row]["log"], f"{source}: runs({row + 1}).log"), file))

    return index, log


def _cell(value: Any) -> str:
    """Return a scalar of a struct as the cell of a table; empty for NaN and other values."""
    if np.size(value) != 1:
        return ""
    text = str(np.asarray(value).item())
    return "" if text in ("nan", "None") else text


def _left_out(name: str, columns: Sequence[str]) -> tuple[str, ...]:
    note = f"{name}: unknown columns left out: {', '.join(columns)}"
    return (note,) if columns else ()


def _bench(folder: Path, index: str) -> tuple[dict[str, Any] | None, Specimen, tuple[str, ...]]:
    path = folder / BENCH
    if not path.exists():
        note = (
            f"no {BENCH} beside {index}: the reference bench's test cylinder is assumed "
            "(40 mm piston, 25 mm rod, 400 mm stroke)"
        )
        return None, _REFERENCE, (note,)
    content = read_yaml(path)
    cylinder = parse_bench(content, str(path)).test_cylinder
    specimen = Specimen(cylinder.area_piston_m2, cylinder.area_rod_m2, cylinder.stroke)
    return {"file": BENCH, "content": content}, specimen, ()


def _plan(
    index: TextTable, row: int, cells: dict[str, str], specimen: Specimen
) -> tuple[RunPlan, str]:
    """Return the plan and the file of one row of the index."""
    cells = {name: cell.strip() for name, cell in cells.items()}
    kind = cells.get("kind") or "steady"
    if kind not in KINDS:
        raise _fault(index, row, "kind", kind, f"expected one of {kind_names()}")
    trial = cells.get("trial") or "1"
    if not trial.isdecimal() or len(trial) > 6 or int(trial) < 1:
        raise _fault(index, row, "trial", trial, "expected a whole number from 1 to 999999")
    references: dict[str, Any] = {
        name: _number(index, row, name, cells[name]) for name in _OPTIONAL if cells.get(name)
    }
    plan = RunPlan(
        run=check_run_id(cells["run"], f"{index.source}: {index.where(row)}"),
        kind=kind,
        trial=int(trial),
        v_ref_m_s=_number(index, row, "v_ref_m_s", cells["v_ref_m_s"]),
        specimen=specimen,
        label=_label(index, row, cells.get("label", "")),
        **references,
    )
    return plan, cells["file"]


def _label(index: TextTable, row: int, cell: str) -> str:
    label = from_cell(cell)
    if not label.isprintable():
        raise _fault(index, row, "label", cell, "expected printable characters")
    return label


def _number(index: TextTable, row: int, column: str, cell: str) -> float:
    try:
        value = float(cell)
        check_number(column, value)
    except ValueError as error:
        fault = str(error) if cell else "missing"
        raise _fault(index, row, column, cell, f"expected a number: {fault}") from None
    return value


def _fault(index: TextTable, row: int, column: str, cell: str, expected: str) -> DataError:
    return DataError(f"{index.source}: {index.where(row)}: {column} {cell[:60]!r}: {expected}")
