"""Runs in SI for other programs: CSV, Parquet and MATLAB files.

CSV consists of an index ``runs.csv``, a CSV file per run and ``bench.yaml``. Parquet contains the
same tables. A MATLAB file contains a struct array ``runs`` with each run's channels in its field
``log``; ``bench.yaml`` is beside it. ``settings.yaml`` contains the screening limits and, without a
bench file, the instruments. ``hbench import`` reads each of them back without a map.
Sample times are unchanged, and a channel that the bench does not have is left out.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml

from hbench.records import RUN_FLAGS, Run
from hbench.store.campaign.run_csv import RUN_CHANNELS, format_run
from hbench.store.exporting.mat_file import mat_file
from hbench.store.formats.parquet import require_pyarrow
from hbench.untrusted_text import as_cell

if TYPE_CHECKING:
    from pandas import DataFrame

_FREE_TEXTS = ("label", "factors", "reason", "truncated", "aborted")  # from files of other people

Files = Iterator[tuple[str, bytes]]  # paths below the folder, and contents
Beside = Mapping[str, Mapping[str, Any]]  # contents of YAML files beside the index, by their names

_INDEX = (
    *"run file kind label trial v_ref_m_s a_ref_m_s2 f_load_n p_lr_ref_pa p_lp_ref_pa".split(),
    *"force_rate_n_s dwell_s x_low_m x_high_m speed_is_measured".split(),
    *"area_piston_m2 area_rod_m2 stroke_m".split(),
    *"factors truncated aborted accepted reason".split(),
)


def csv_files(runs: Iterable[tuple[Run, str]], beside: Beside) -> Files:
    """Yield the files in the default layout of ``hbench import``."""
    rows = []
    for run, reason in runs:
        name = f"runs/{run.plan.run}.csv"
        rows.append(_row(run, name, reason))
        yield name, b"".join(format_run(channels(run)))
    for row in rows:
        row |= {name: as_cell(row[name]) for name in _FREE_TEXTS}
    yield "runs.csv", _frame(rows).to_csv(index=False, lineterminator="\n").encode()
    yield from _files_beside(beside)


def parquet_files(runs: Iterable[tuple[Run, str]], beside: Beside) -> Files:
    """Yield a table per run, with the run's id in a column, and the index of runs.

    Raises ``ConfigError`` if pyarrow is not installed.
    """
    require_pyarrow()
    import pandas as pd

    rows = []
    for run, reason in runs:
        name = f"runs/{run.plan.run}.parquet"
        rows.append(_row(run, name, reason))
        table = pd.DataFrame({"run": run.plan.run, **channels(run)})
        yield name, table.to_parquet(engine="pyarrow", index=False)
    yield "runs.parquet", _frame(rows).to_parquet(engine="pyarrow", index=False)
    yield from _files_beside(beside)


def mat_files(runs: Iterable[tuple[Run, str]], beside: Beside) -> Files:
    """Yield ``campaign.mat`` (version 5) with the struct array ``runs``: plan, verdict, log."""
    names = [name for name in _INDEX if name != "file"]
    kind = [(name, object) for name in (*names, "log")]
    rows = []
    for run, reason in runs:
        row = _row(run, "", reason)
        values = [np.nan if row[name] is None else row[name] for name in names]
        rows.append((*values, channels(run)))
    yield "campaign.mat", mat_file({"runs": np.array(rows, dtype=kind)}, compressed=True)
    yield from _files_beside(beside)


def channels(run: Run) -> dict[str, np.ndarray]:
    """Return a run's channels (n,) by their names in SI; flags are 0 or 1."""
    logged = {name: getattr(run, name) for name in (*RUN_CHANNELS, *RUN_FLAGS)}
    return {name: 1 * values for name, values in logged.items() if values is not None}


def _files_beside(beside: Beside) -> Files:
    for name, content in beside.items():
        yield name, yaml.safe_dump(content, sort_keys=False, allow_unicode=True).encode()


def _row(run: Run, file: str, reason: str) -> dict[str, Any]:
    plan = run.plan
    cells = {name: getattr(plan, name, getattr(plan.specimen, name, None)) for name in _INDEX}
    cells["factors"] = json.dumps(plan.factor_values, ensure_ascii=False) if plan.factors else ""
    cells |= {"truncated": run.truncated, "aborted": run.aborted}
    return cells | {"file": file, "accepted": not reason, "reason": reason}


def _frame(rows: list[dict[str, Any]]) -> "DataFrame":
    import pandas as pd

    return pd.DataFrame(rows, columns=list(_INDEX))


FORMATS: dict[str, Callable[[Iterable[tuple[Run, str]], Beside], Files]] = {
    "csv": csv_files,
    "parquet": parquet_files,
    "mat": mat_files,
}
