"""A fleet on a Dask cluster of processes on this machine: speed-up, memory, time per campaign.

    pytest -m slow -s tests/benchmarks/test_fleet_scaling.py

prints all figures for a thousand campaigns of 36 runs, of a few seeds, each many times. Ratios are
of the same machine at the same time; each process has one thread for linear algebra.
"""

import os
import shutil
import time
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from statistics import median

import pytest
import yaml
from loopback import Loopback
from made_fleet import made_table

from hbench import workflow
from hbench.experiment import cores
from hbench.workflow.fleet_summary import summarize

CONFIGS = Path(__file__).parents[2] / "configs"
SAMPLE = Path(__file__).parents[2] / "data_samples" / "stribeck-small"
CYLINDER_TEST = {
    "loads": ["2000 N"],
    "velocities": [f"{v} mm/s" for v in (6, 15, 35, 70, 120, 180)],
    "trials": 3,
    "travel": {"start": "140 mm", "end": "300 mm"},
    "acceleration": "2 m/s^2",
    "hold": "0.1 s",
    "window": "0.4 s",
}
SEEDS = 8
MILLION = 1_000_000


class Watched:
    """A fleet's run: when each campaign was done, and what memory its processes had [MB]."""

    def __init__(self, places: Path, out: Path, dask: Loopback | None):
        self.done_s: list[float] = []
        self.memory: dict[str, list[float]] = {"host": [], "workers": [], "scheduler": []}
        self._dask = dask
        self._start = time.perf_counter()
        self.fleet = workflow.analyze_fleet(
            [str(places)],
            out,
            scheduler=dask and dask.address,
            speed_m_s=None,
            report=self._note,
            tell=lambda words: None,
        )
        self.wall_s = self.done_s[-1]

    def _note(self, *_):
        self.done_s.append(time.perf_counter() - self._start)
        self.memory["host"].append(_rss_mb(os.getpid()))
        if self._dask is not None:
            self.memory["workers"].append(max(_rss_mb(w.pid) for w in self._dask.workers))
            self.memory["scheduler"].append(_rss_mb(self._dask.scheduler.pid))

    def each_s(self, first: int, last: int) -> float:
        """Wall time per campaign from the one of number ``first`` to that of number ``last``."""
        return (self.done_s[last - 1] - self.done_s[first - 1]) / (last - first)


def _rss_mb(pid: int) -> float:
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGESIZE") / 1e6


def many(folder: Path, sources: list[Path], campaigns: int) -> Path:
    """Make campaigns of hard links: each is read, and analyzed, by itself."""
    for i in range(campaigns):
        source = sources[i % len(sources)]
        shutil.copytree(source, folder / f"{i:05d}", copy_function=os.link)
    return folder


@pytest.fixture
def loopback(tmp_path):
    pytest.importorskip("distributed")
    started = []

    def start(workers):
        folder = tmp_path / f"cluster-{len(started)}"
        folder.mkdir()
        started.append(Loopback(folder, workers))
        return started[-1]

    yield start
    for one in started:
        one.close()


def test_memory_of_a_worker_and_time_per_campaign_do_not_grow(loopback, tmp_path):
    """The small version: 30 campaigns of 72 runs on one worker."""
    dask = loopback(1)
    seen = Watched(many(tmp_path / "line", [SAMPLE], 30), tmp_path / "out", dask)
    early, late = seen.each_s(5, 15), seen.each_s(20, 30)
    workers = seen.memory["workers"]
    print(f"\n{1e3 * early:.0f}, then {1e3 * late:.0f} ms a campaign; {workers[4]:.0f}, then "
          f"{workers[-1]:.0f} MB")  # fmt: skip
    assert late < 3 * early, "whatever else the machine does"
    assert workers[-1] < 1.1 * workers[4] + 5


@pytest.mark.slow
def test_a_thousand_campaigns(loopback, tmp_path):
    before = time.perf_counter()
    sources = _made(tmp_path)
    print(f"\n{SEEDS} campaigns of 36 runs made in {time.perf_counter() - before:.0f} s")
    line = many(tmp_path / "line", sources, 1000)
    part = many(tmp_path / "part", sources, 100)

    one, two = loopback(1), loopback(2)
    for number, dask in enumerate((one, two)):  # their first campaigns: imports
        first = Watched(part, tmp_path / f"warm-{number}", dask)
        print(f"first campaign of {number + 1} worker(s) after {first.done_s[0]:.1f} s")
    ratios = []
    for turn in range(3):
        walls = [
            Watched(part, tmp_path / f"{turn}-{number}", dask).wall_s
            for number, dask in enumerate((one, two))
        ]
        ratios.append(walls[0] / walls[1])
        print(f"100 campaigns: {walls[0]:.1f} s on one worker, {walls[1]:.1f} s on two: "
              f"{ratios[-1]:.2f} times as fast")  # fmt: skip
    one.close()

    seen = Watched(line, tmp_path / "out", two)
    print(f"1000 campaigns on two workers: {seen.wall_s:.0f} s, "
          f"{1e3 * seen.each_s(1, 100):.0f} ms a campaign to the 100th, "
          f"{1e3 * seen.each_s(900, 1000):.0f} ms from the 900th on")  # fmt: skip
    for name, memory in seen.memory.items():
        print(f"memory of {name}: {memory[99]:.0f} MB at 100, {memory[-1]:.0f} MB at 1000")
    here = Watched(line, tmp_path / "here", None)
    print(f"1000 campaigns on this machine's {cores.usable_cores()} cores: {here.wall_s:.0f} s")
    tables = [(tmp_path / name / "fleet.parquet").read_bytes() for name in ("out", "here")]
    _a_million(tmp_path, seen)

    assert tables[0] == tables[1] and seen.fleet.failed == 0
    assert seen.memory["workers"][-1] < 1.05 * seen.memory["workers"][99]
    assert seen.memory["host"][-1] < 1.05 * seen.memory["host"][99]
    if cores.usable_cores() < 2 or os.getloadavg()[0] > 4:
        pytest.skip("the rest needs two cores without other work")
    assert median(ratios) >= 1.8
    assert seen.each_s(900, 1000) < 1.2 * seen.each_s(10, 110)


def _made(folder: Path) -> list[Path]:
    schedule = {"name": "cylinder test", "bench": str(CONFIGS / "bench-aau.yaml")}
    schedule["experiments"] = [
        {"kind": "steady", "direction": "extend", "p_lr": "15 bar", **CYLINDER_TEST},
        {"kind": "steady", "direction": "retract", "p_lr": "110 bar"}
        | {**CYLINDER_TEST, "loads": ["-2000 N"]},
    ]
    (folder / "cylinder.yaml").write_text(yaml.safe_dump(schedule))
    workflow.measure_seeds(
        workflow.load_experiment(folder / "cylinder.yaml", None),
        folder / "made",
        seeds=range(SEEDS),
        plant=None,
        resume=False,
        clock=partial(datetime.fromtimestamp, 0, UTC),
        report=lambda done: None,
    )
    return [folder / "made" / str(seed) for seed in range(SEEDS)]


def _a_million(folder: Path, seen: Watched) -> None:
    """Print what a million would take: from the thousand, and from the page of 30 000 rows."""
    each = seen.each_s(10, 1000) * 2  # of one worker
    out = folder / "out"
    table = (out / "fleet.parquet").stat().st_size / 1000
    rows = (out / "fleet.sqlite").stat().st_size / 1000
    made_table(folder / "rows", 30_000)
    before, memory = time.perf_counter(), _rss_mb(os.getpid())
    summarize(folder / "rows")
    took, more = time.perf_counter() - before, _rss_mb(os.getpid()) - memory
    print(f"a million, from this: {each * MILLION / 3600:.0f} h of one worker; fleet.parquet "
          f"{table * MILLION / 1e6:.0f} MB, fleet.sqlite {rows * MILLION / 1e6:.0f} MB; the page's "
          f"numbers of 30 000 rows took {took:.1f} s and {more:.0f} MB")  # fmt: skip
