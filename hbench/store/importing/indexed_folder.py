"""Reader of a folder in the default layout: an index of runs and a table per run, all in SI.

The index is ``runs.csv`` (a CSV or Parquet file per run), ``runs.parquet`` (the same), or
``campaign.mat`` with the struct array ``runs``, which contains the logs too. An optional
``bench.yaml`` beside it describes the cylinder and the bench, a ``settings.yaml`` the screening
limits and instruments.
"""

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from hbench.config.bench import parse_bench
from hbench.config.campaign_settings import parse_settings
from hbench.config.files.loading import read_yaml
from hbench.config.import_layout import Format
from hbench.errors import DataError
from hbench.records import KINDS, Factors, Outcome, RunPlan, Specimen, kind_names
from hbench.sentences import abridged, counted, plural
from hbench.store.campaign.journal import check_run_id
from hbench.store.campaign.plan_fields import check_number, read_factors
from hbench.store.campaign.run_csv import check_complete, read_channels
from hbench.store.files.bounded_read import check_inside, read_file
from hbench.store.formats.arrays import Arrays
from hbench.store.formats.matlab.mat import read_mat
from hbench.store.formats.parquet import read_parquet, require_pyarrow
from hbench.store.formats.reading import read_apart
from hbench.store.formats.table import Table
from hbench.store.formats.text import TextTable, parse_table
from hbench.store.importing.file_notes import ROTARY_NOTE
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
BENCH, SETTINGS = "bench.yaml", "settings.yaml"

_REQUIRED = ("run", "file", "v_ref_m_s")
_OPTIONAL = (
    *("a_ref_m_s2", "f_load_n", "p_lr_ref_pa", "p_lp_ref_pa", "x_low_m", "x_high_m"),
    *("force_rate_n_s", "dwell_s"),
)
_CYLINDER = ("area_piston_m2", "area_rod_m2", "stroke_m")
_TEXTS = ("label", "factors", "truncated", "aborted")
_COLUMNS = (*_REQUIRED, "kind", "trial", "speed_is_measured", *_TEXTS, *_OPTIONAL, *_CYLINDER)
_OF_EXPORT = ("accepted", "reason")  # ignored: the screening is repeated
_FLAGS = {"": False, "0": False, "false": False, "1": True, "true": True}
_SAME_AREA = 1e-3  # relative difference of areas, by rounding
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
    has_cylinders = {"area_piston_m2", "area_rod_m2"} <= set(index.names)
    bench, specimen, notes = _bench(folder, name, has_cylinders)
    known = (*_COLUMNS, *_OF_EXPORT)
    notes += _left_out(name, [column for column in index.names if column not in known])
    runs: list[ImportedRun] = []
    lines: dict[str, int] = {}
    for row, values in enumerate(index.rows):
        cells = {name: v.strip() for name, v in zip(index.names, values, strict=True)}
        plan, file_name = _plan(index, row, cells, specimen)
        if plan.run in lines:
            raise _fault(index, row, "run", plan.run, f"occurs in line {lines[plan.run]} too")
        lines[plan.run] = index.lines[row]
        with log(row, file_name) as (table, file):
            channels, unknown = read_channels(table)
            first, last = table.lines_of(np.array([0, len(channels["t_s"]) - 1])).tolist()
        notes += _left_out(file.name, [column for column in unknown if column != "run"])
        stored = store(file.name, plan.run, channels)
        outcome, why = _outcome(index, row, cells)
        runs.append(ImportedRun(plan, stored, file, (first, last), outcome, why))
        del table, channels  # before the next ones are read
    if bench is not None:
        notes += _other_cylinders(runs, specimen)
    beside = _unlisted(folder, name, runs)
    settings = _settings(folder)
    if settings is not None and settings["content"].get("rotary"):
        notes += (ROTARY_NOTE,)
    return ImportedRuns(tuple(runs), (*notes, *beside), bench, settings)


def _other_cylinders(runs: Sequence[ImportedRun], specimen: Specimen) -> tuple[str, ...]:
    """Report runs whose cylinder in the index is not that of the bench file."""
    areas = [(run.plan.specimen.area_piston_m2, run.plan.specimen.area_rod_m2) for run in runs]
    given = (specimen.area_piston_m2, specimen.area_rod_m2)
    others = sum(not np.allclose(area, given, rtol=_SAME_AREA, atol=0) for area in areas)
    note = (
        f"{counted(others, 'run')} {plural(others, 'has', 'have')} another cylinder in the index "
        f"than in {BENCH}: that of the index is used; remove the columns of areas for the other"
    )
    return (note,) if others else ()


def _settings(folder: Path) -> dict[str, Any] | None:
    path = folder / SETTINGS
    if not path.exists():
        return None
    content = read_yaml(path)
    parse_settings(content, str(path))
    return {"file": SETTINGS, "content": content}


def _unlisted(folder: Path, index: str, runs: Sequence[ImportedRun]) -> Iterator[str]:
    """Report files beside those of the index that no row lists."""
    listed = {(folder / run.file.name).resolve() for run in runs} | {(folder / index).resolve()}
    beside = {(path.parent, path.suffix) for path in listed if path.name != index}
    unlisted = {path for at, suffix in beside for path in at.glob(f"*{suffix}")} - listed
    if unlisted:
        names = sorted(path.relative_to(folder.resolve()).as_posix() for path in unlisted)
        few = abridged(names, 10)
        yield f"{index}: no row for {few}: left out ({counted(len(names), 'file')})"


def _table_index(folder: Path, name: str) -> _Index:
    path = folder / name
    check_inside(folder, path)
    if name.endswith(".parquet"):
        require_pyarrow()
        data = read_apart(path, _parquet_as_csv, path)
    else:
        data = read_file(path)
    index = parse_table(data, str(path), Format())
    check_complete(index)
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


def _bench(
    folder: Path, index: str, has_cylinders: bool
) -> tuple[dict[str, Any] | None, Specimen, tuple[str, ...]]:
    path = folder / BENCH
    if not path.exists() and has_cylinders:
        return None, _REFERENCE, ()
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
        specimen=_specimen(index, row, cells, specimen),
        speed_is_measured=_flag(index, row, "speed_is_measured", cells),
        label=_text(index, row, "label", cells),
        factors=_factors(index, row, cells),
        **references,
    )
    return plan, cells["file"]


def _specimen(index: TextTable, row: int, cells: dict[str, str], of_bench: Specimen) -> Specimen:
    """Return the run's cylinder; without areas in the index that of the bench file."""
    given = {name: cells[name] for name in _CYLINDER if cells.get(name)}
    if not given:
        return of_bench
    for name in ("area_piston_m2", "area_rod_m2"):
        if name not in given:
            raise _fault(index, row, name, "", "missing, but other sizes of the cylinder are given")
    numbers = {name: _number(index, row, name, cell) for name, cell in given.items()}
    return Specimen(**numbers)


def _flag(index: TextTable, row: int, column: str, cells: dict[str, str]) -> bool:
    cell = cells.get(column, "")
    if cell.lower() not in _FLAGS:
        raise _fault(index, row, column, cell, "expected True or False")
    return _FLAGS[cell.lower()]


def _outcome(index: TextTable, row: int, cells: dict[str, str]) -> tuple[Outcome, str]:
    """Return the outcome of an exported run, and why it is not ``done``."""
    if aborted := _text(index, row, "aborted", cells):
        return "aborted", aborted
    truncated = _text(index, row, "truncated", cells)
    return ("failed", truncated) if truncated else ("done", "")


def _factors(index: TextTable, row: int, cells: dict[str, str]) -> Factors:
    """Return the factors of an exported run, written as JSON."""
    text = _text(index, row, "factors", cells)
    if not text:
        return ()
    try:
        return read_factors(json.loads(text))
    except (ValueError, RecursionError):
        raise _fault(index, row, "factors", text, 'expected {"name": "value"}') from None


def _text(index: TextTable, row: int, column: str, cells: dict[str, str]) -> str:
    cell = cells.get(column, "")
    text = from_cell(cell)
    if not text.isprintable():
        raise _fault(index, row, column, cell, "expected printable characters")
    return text


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
