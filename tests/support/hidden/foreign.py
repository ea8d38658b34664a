"""Campaigns as logs of another bench, for ``hbench import``.

``index`` is the default layout: SI, with ``runs.csv`` and ``settings.yaml``. It contains all that a
campaign does except the motions and the bench file: the board that made the logs is unknown.
``map`` is what a data logger writes: other names and units, a decimal comma, numbers in the files'
names. A map has one kind, so that each kind is a folder with its own ``map.yaml``, to be imported
as a campaign of its own.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from hbench.analysis.screening.calibrate import calibrate
from hbench.config.bench import Bench
from hbench.records import KINDS, Run, RunPlan
from hbench.store.campaign.folder import load_campaign
from hbench.store.exporting.runs import Files, channels, csv_files
from hbench.units import parse_unit

# Channel: name and unit in the logger's file.
_COLUMNS = {
    "t_s": ("Zeit", "ms"),
    "x_m": ("Weg", "mm"),
    "v_m_s": ("Geschwindigkeit", "mm/s"),
    "p_tp_pa": ("p_A", "bar"),
    "p_tr_pa": ("p_B", "bar"),
    "p_lp_pa": ("p_C", "bar"),
    "p_lr_pa": ("p_D", "bar"),
    "p_s_pa": ("p_P", "bar"),
    "f_applied_n": ("Kraft", "kN"),
    "u_t_v": ("U_1", "V"),
    "u_l1_v": ("U_2", "V"),
    "u_l2_v": ("U_3", "V"),
    "v_ref_m_s": ("v_soll", "mm/s"),
}


def write_index(campaign: Path, out: Path) -> None:
    """Write a campaign in the default layout, without verdicts."""
    runs, content = _runs(campaign)
    settings = {"settings.yaml": _settings(content)}
    _write(csv_files(((run, "") for run in runs), settings), out)


def write_mapped(campaign: Path, out: Path) -> None:
    """Write a folder for each kind: ``map.yaml`` and a file for each run."""
    runs, content = _runs(campaign)
    bench = load_campaign(campaign).bench()
    by_kind: dict[str, list[Run]] = {}
    for run in runs:
        by_kind.setdefault(run.plan.kind, []).append(run)
    for kind, of_kind in by_kind.items():
        _write(_mapped_files(kind, of_kind, bench, content), out / kind)


def _runs(campaign: Path) -> tuple[list[Run], dict[str, Any]]:
    stored = load_campaign(campaign)
    bench = stored.bench()
    return [calibrate(raw, bench) for raw in stored.raw_runs()], stored.header["bench"]["content"]


def _write(files: Files, out: Path) -> None:
    for name, data in files:
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (out / name).write_bytes(data)


def _mapped_files(kind: str, runs: Iterable[Run], bench: Bench, content: dict[str, Any]) -> Files:
    series: dict[str, dict[str, Any]] = {}
    names: set[str] = set()
    for run in runs:
        pattern, fields = _name(run.plan)
        name = pattern.format_map(fields)
        assert name not in names, name
        names.add(name)
        label = run.plan.label or kind
        series.setdefault(pattern, {"label": label, "files": pattern} | _described(bench, fields))
        yield name, _text(run)
    columns = {key: {"column": name, "unit": unit} for key, (name, unit) in _COLUMNS.items()}
    rules = {
        "name": kind,
        "kind": kind,
        "format": {"separator": "semicolon", "decimal": ","},
        "columns": columns,
        "constants": {"p_lr_ref_pa": "{pressure} bar"},
        "series": list(series.values()),
        **_settings(content),
    }
    yield "map.yaml", yaml.safe_dump(rules, sort_keys=False).encode()


def _settings(content: dict[str, Any]) -> dict[str, Any]:
    """Return what a bench's owner knows of it beside the cylinders."""
    return {
        "instruments": content["instruments"],
        "moving_mass": content["moving_mass"]["test"],
    }


def _name(plan: RunPlan) -> tuple[str, dict[str, str]]:
    """Return the pattern of a run's file, and the fields in its name.

    A hold has no speed, which must not be 0 in a name, but a position.
    """
    fields = {
        "load": f"{plan.f_load_n:.6g}",
        "pressure": f"{plan.p_lr_ref_pa / 1e5:.6g}",
        "trial": f"{plan.trial}",
    }
    if KINDS[plan.kind].is_at_rest:
        first = "{position}mm"
        fields["position"] = f"{1e3 * plan.planned_motion.x_start_m:.6g}"
    else:
        first = "{speed}mm_s"
        fields["speed"] = f"{1e3 * abs(plan.v_ref_m_s):.6g}"
    folder = re.sub(r"[^a-z]+", "_", plan.label.lower() or plan.kind)
    return f"{folder}/{first}_{{load}}N_{{pressure}}bar_{{trial}}.csv", fields


def _described(bench: Bench, fields: dict[str, str]) -> dict[str, Any]:
    """Return a series' cylinder, and the position of a hold, which is no field of the import."""
    test = bench.test_cylinder
    sizes = ("piston_diameter", "rod_diameter", "stroke")
    return {
        "cylinder": {size: f"{1e3 * getattr(test, size):.9g} mm" for size in sizes},
        "factors": {"position": "mm"} if "position" in fields else {},
    }


def _text(run: Run) -> bytes:
    values = channels(run)
    table = np.column_stack(
        [values[key] / parse_unit(unit).factor for key, (_, unit) in _COLUMNS.items()]
    )
    return "".join(_lines([name for name, _ in _COLUMNS.values()], table)).encode()


def _lines(names: Iterable[str], table: np.ndarray) -> Iterator[str]:
    yield ";".join(names) + "\n"
    for row in table.tolist():
        yield ";".join(f"{value:.9g}" for value in row).replace(".", ",") + "\n"


LAYOUTS: dict[str, Callable[[Path, Path], None]] = {"index": write_index, "map": write_mapped}
