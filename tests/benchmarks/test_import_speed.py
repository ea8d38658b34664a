"""``import`` of logs, against pandas (and scipy) reading and writing the same files.

``pytest -s -m slow tests/benchmarks/test_import_speed.py`` imports 40 MB and prints the times.
"""

import time
import tracemalloc
from datetime import UTC, datetime

import numpy as np
import pandas as pd
import pytest
import yaml

from hbench.store.importing.importer import import_folder

AT = datetime(2026, 1, 1, tzinfo=UTC)
COLUMNS = {"t_s": ("t", "s"), "x_m": ("x", "mm"), "v_m_s": ("v", "mm/s"), "p_tp_pa": ("pa", "bar"),
           "p_tr_pa": ("pb", "bar"), "f_applied_n": ("f", "kN")}  # fmt: skip


@pytest.fixture
def logs(tmp_path):
    """Return a function that writes logs of strokes, each of ``size`` bytes, with their map."""

    def write(files, size):
        folder = tmp_path / f"logs-{files}"
        folder.mkdir()
        rng = np.random.default_rng(1)
        rows = size // 48
        t = np.arange(rows) / 1000
        frame = pd.DataFrame({"t": t, "x": 200 * t})
        for name, mean, noise in (("v", 200, 0.1), ("pa", 60, 1), ("pb", 15, 1), ("f", 2, 0.1)):
            frame[name] = rng.normal(mean, noise, rows)
        frame["x"] += rng.normal(0, 1e-3, rows)
        text = frame.round(4).to_csv(index=False)
        for number in range(files):
            (folder / f"{number}.csv").write_text(text.replace("0.002,", f"0.002{number},", 1))
        cylinder = {"piston_diameter": "40 mm", "rod_diameter": "25 mm"}
        rules = {
            "name": "speed",
            "columns": {key: {"column": c, "unit": unit} for key, (c, unit) in COLUMNS.items()},
            "series": [{"label": "", "files": "{load}.csv", "cylinder": cylinder}],
        }
        (folder / "map.yaml").write_text(yaml.safe_dump(rules))
        return folder

    return write


def timed(call):
    """CPU time of this process [s]."""
    before = time.process_time()
    call()
    return time.process_time() - before


def wall(call):
    """Wall time [s], which contains that of the process that reads."""
    before = time.perf_counter()
    call()
    return time.perf_counter() - before


def compare(folder, out):
    """Return the seconds of an import, of pandas' ``read_csv``, and of its ``to_csv``."""
    files = sorted(folder.glob("*.csv"))
    pd.read_csv(files[0])  # loads what it needs
    read = timed(lambda: [pd.read_csv(file) for file in files])
    write = timed(lambda: [pd.read_csv(f).to_csv(out.with_suffix(".csv")) for f in files]) - read
    ours = timed(lambda: import_folder(folder, out, folder / "map.yaml", {}, AT))
    megabytes = sum(file.stat().st_size for file in files) / 1e6
    print(
        f"\nimport of {megabytes:.0f} MB in {len(files)} files: {ours:.2f} s, {ours / read:.1f} "
        f"times pandas' read_csv ({read:.2f} s), {ours / (read + write):.2f} times both that and "
        f"to_csv ({write:.2f} s)"
    )
    return ours, read, write


def test_an_import_takes_less_time_than_pandas_to_read_and_write(logs, tmp_path):
    import_folder(warm := logs(1, 10_000), tmp_path / "first", warm / "map.yaml", {}, AT)
    ours, read, write = compare(logs(4, 500_000), tmp_path / "out")
    assert ours < 0.8 * (read + write)


@pytest.mark.slow
def test_forty_files_of_a_megabyte(logs, tmp_path):
    ours, read, write = compare(logs(40, 1_000_000), tmp_path / "out")
    assert ours < 0.8 * (read + write)


def test_an_import_of_matlab_files_takes_less_time_than_scipy_and_pandas(logs, tmp_path):
    """All digits of each float are written; the process that reads starts before the clock."""
    from scipy.io import loadmat, savemat

    folder = logs(4, 500_000)
    rng = np.random.default_rng(2)
    for file in sorted(folder.glob("*.csv")):
        frame = pd.read_csv(file)
        noisy = {name: frame[name] + rng.normal(0, 1e-6, len(frame)) for name in ("x", "v", "f")}
        savemat(file.with_suffix(".mat"), {name: frame[name].to_numpy() for name in frame} | noisy)
        file.unlink()
    rules = folder / "map.yaml"
    rules.write_text(rules.read_text().replace("{load}.csv", "{load}.mat"))
    files = sorted(folder.glob("*.mat"))

    def as_csv():
        for file in files:
            columns = {name: v.ravel() for name, v in loadmat(file).items() if name[0] != "_"}
            pd.DataFrame(columns).to_csv(tmp_path / "out.csv")

    import_folder(folder, tmp_path / "first", rules, {}, AT)
    ours = wall(lambda: import_folder(folder, tmp_path / "out", rules, {}, AT))
    theirs = wall(as_csv)
    megabytes = sum(file.stat().st_size for file in files) / 1e6
    print(
        f"\nimport of {megabytes:.1f} MB of MATLAB files: {ours:.2f} s, {ours / theirs:.2f} times"
    )
    assert ours < 0.8 * theirs


def test_memory_does_not_grow_with_the_number_of_files(logs, tmp_path):
    peaks = []
    for files in (2, 6):
        folder = logs(files, 500_000)
        tracemalloc.start()
        import_folder(folder, tmp_path / f"out-{files}", folder / "map.yaml", {}, AT)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    print(f"\npeak {peaks[0] / 1e6:.1f} MB for 2 files, {peaks[1] / 1e6:.1f} MB for 6")
    assert peaks[1] - peaks[0] < 1e6  # four files and their channels: 4 MB
