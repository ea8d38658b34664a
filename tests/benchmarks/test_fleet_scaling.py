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

from hbench import workflow
from hbench.parallel import process_pool
from hbench.records import QUANTITIES
from tests.support.faults.loopback import Loopback
from tests.support.report.made_fleet import MIDDLE, made_table, summary_of

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
    """A fleet's run: when each campaign was done, and what its processes had used by then.

    ``memory`` [MB] is the largest of a kind, ``cpu`` [s] the sum.
    """

    def __init__(self, places: Path, out: Path, dask: Loopback | None):
        self.done_s: list[float] = []
        self._pids = {"host": [os.getpid()]}
        if dask is not None:
            self._pids["workers"] = [worker.pid for worker in dask.workers]
            self._pids["scheduler"] = [dask.scheduler.pid]
        self.memory: dict[str, list[float]] = {kind: [] for kind in self._pids}
        self.cpu: dict[str, list[float]] = {kind: [] for kind in self._pids}
        self._start = time.perf_counter()
        self.fleet = workflow.analyze_fleet(
            [str(places)],
            out,
            scheduler=dask and dask.address,
            speed_m_s=None,
            report=self._note,
            note=lambda words: None,
        )
        self.wall_s = self.done_s[-1]

    def _note(self, *_):
        self.done_s.append(time.perf_counter() - self._start)
        for kind, pids in self._pids.items():
            self.memory[kind].append(max(map(_rss_mb, pids)))
            self.cpu[kind].append(sum(map(_cpu_s, pids)))

    def each_s(self, first: int, last: int) -> float:
        """Wall time per campaign from the one of number ``first`` to that of number ``last``."""
        return (self.done_s[last - 1] - self.done_s[first - 1]) / (last - first)

    def cpu_ms(self, kind: str, first: int) -> float:
        """CPU time per campaign from the one of number ``first`` on."""
        used = self.cpu[kind]
        return 1e3 * (used[-1] - used[first - 1]) / (len(used) - first)

    def possible(self, first: int) -> float:
        """How many times as fast two workers are as one, on two cores that do nothing else.

        One worker has a core of its own; two share two with host and scheduler.
        """
        worker = self.cpu_ms("workers", first)
        return 2 * worker / sum(self.cpu_ms(kind, first) for kind in self.cpu)


def _cpu_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


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


def test_two_workers_can_be_1_8_times_as_fast_as_one_and_memory_does_not_grow(loopback, tmp_path):
    """The small version: CPU time and memory over 12 campaigns of 72 runs, on one worker.

    They don't depend on what else the machine does, as wall time would.
    """
    dask = loopback(1)
    seen = Watched(many(tmp_path / "line", [SAMPLE], 12), tmp_path / "out", dask)
    workers = seen.memory["workers"]
    print()
    for kind, memory in seen.memory.items():
        print(f"{kind}: {seen.cpu_ms(kind, 5):.0f} ms of CPU time a campaign, "
              f"{memory[4]:.0f} MB at 5, {memory[-1]:.0f} MB at 12")  # fmt: skip
    print(f"two workers can be {seen.possible(5):.2f} times as fast")
    assert seen.possible(5) > 1.8
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
    for kind, memory in seen.memory.items():
        print(f"{kind}: {seen.cpu_ms(kind, 100):.1f} ms of CPU time a campaign, "
              f"{memory[99]:.0f} MB at 100, {memory[-1]:.0f} MB at 1000")  # fmt: skip
    two.close()
    here = Watched(line, tmp_path / "here", None)
    print(
        f"1000 campaigns on this machine's {process_pool.usable_cores()} cores: {here.wall_s:.0f} s"
    )
    tables = [(tmp_path / name / "fleet.parquet").read_bytes() for name in ("out", "here")]
    _a_million(tmp_path, seen)

    assert tables[0] == tables[1] and seen.fleet.failed == 0
    assert seen.memory["workers"][-1] < 1.05 * seen.memory["workers"][99]
    assert seen.memory["host"][-1] < 1.05 * seen.memory["host"][99]
    if process_pool.usable_cores() < 2 or os.getloadavg()[0] > 4:
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
        workflow.Line(seed=0),
        SEEDS,
        resume=False,
        clock=partial(datetime.fromtimestamp, 0, UTC),
        report=lambda done: None,
    )
    return [folder / "made" / str(seed) for seed in range(SEEDS)]


def _a_million(folder: Path, seen: Watched) -> None:
    """Print what a million would take: from the thousand, and from 30 000 rows that are drawn."""
    each = seen.cpu_ms("workers", 100) / 1e3
    out = folder / "out"
    rows = (out / "fleet.sqlite").stat().st_size / 1000
    made_table(folder / "rows", 30_000)
    table = (folder / "rows" / "fleet.parquet").stat().st_size / 30_000
    before, memory = time.perf_counter(), _rss_mb(os.getpid())
    summary_of(folder / "rows")
    took, more = time.perf_counter() - before, _rss_mb(os.getpid()) - memory
    print(f"a million, from this: {each * MILLION / 3600:.0f} h of one core; fleet.parquet "
          f"{table * MILLION / 1e6:.0f} MB with {2 * len(MIDDLE)} of its {2 * len(QUANTITIES)} "
          f"numbers, fleet.sqlite {rows * MILLION / 1e6:.0f} MB; the page's "
          f"numbers of 30 000 rows took {took:.1f} s and {more:.0f} MB")  # fmt: skip
