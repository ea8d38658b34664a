"""What several test rooms share: the shipped bench and a short schedule."""

import copy
import gc
import os
import pickle
import resource
import shutil
import signal
import sys
from base64 import b64decode
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path
from unittest import mock

import pytest
import yaml
from hypothesis import settings

from hbench import workflow
from hbench.parallel.one_thread import ONE_THREAD
from tests.support.rig_campaign import measure_on_rig

ROOT = Path(__file__).parents[1]
sys.path.append(str(ROOT))  # for ``tests.support``; behind the installed hbench

# A busy machine is no failure. CI draws the same examples each time, runs by hand draw others.
settings.register_profile("patient", deadline=None, derandomize="HBENCH_CI" in os.environ)
settings.load_profile("patient")

os.environ |= ONE_THREAD  # before numpy is imported; xdist has a process on each core

yaml.SafeLoader = yaml.CSafeLoader  # ten times as fast

SHORT = {
    "name": "short",
    "bench": "bench.yaml",
    "experiments": [
        {
            "kind": "steady",
            "direction": "extend",
            "p_lr": "15 bar",
            "loads": ["2000 N"],
            "velocities": ["60 mm/s", "120 mm/s"],
            "trials": 2,
            "travel": {"start": "100 mm", "end": "300 mm"},
            "acceleration": "1 m/s^2",
            "hold": "0.2 s",
            "window": "0.6 s",
        }
    ],
}


gc.disable()  # while tests are collected, most of which stays


def pytest_collection_finish():
    """Let the garbage collector pass over what stays, and look for garbage less often."""
    gc.freeze()
    gc.set_threshold(100_000)
    gc.enable()


@pytest.fixture
def wide_terminal(monkeypatch):
    """Leave lines of paragraphs and tables unbroken, for tests of their content."""
    for module in ("terminal_text", "terminal_table"):
        monkeypatch.setattr(f"hbench.report.render.{module}.WIDE", 1000)


@pytest.fixture(scope="session")
def require_tool():
    """Return a function that gives a program's path; one that is missing skips the test.

    Not in CI, which sets HBENCH_CI and installs them all: there it fails the test.
    """

    def find(name: str) -> str:
        path = shutil.which(name)
        if path is None:
            (pytest.fail if os.environ.get("HBENCH_CI") else pytest.skip)(f"no {name}")
        return path

    return find


@pytest.fixture(scope="session", autouse=True)
def shared_folder(tmp_path_factory):
    """Give all workers of a session one folder for ``tests.support.shared``."""
    from tests.support import shared

    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent
    shared.folder = folder / "shared"
    shared.folder.mkdir(exist_ok=True)


@pytest.fixture(scope="session", autouse=True)
def unflushed():
    """Leave written files in the page cache, where they are as safe: no test cuts the power.

    A flush would take some milliseconds. Its file descriptor is checked. Programs that tests start
    do flush.
    """
    with mock.patch("os.fsync", os.fstat):
        yield


@pytest.fixture(scope="session", autouse=True)
def unforked():
    """Work in the test's process: xdist has one on each core, and forks cost a tenth more.

    Programs that tests start do fork.
    """
    with mock.patch("hbench.parallel.forked._PROCESSES", sys.maxsize):
        yield


NO_SVG = b'<svg xmlns="http://www.w3.org/2000/svg"/>'
NO_PNG = b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAAC0lEQVR4nGP4DwQACfsD/fteaysAAAAASUVORK5CYII="
)


@pytest.fixture
def undrawn(monkeypatch):
    """Leave figures empty, which saves seconds, where a test looks at everything but them.

    Their names, captions and data are made as ever.
    """
    monkeypatch.setattr("hbench.report.render.figures.as_svg", lambda figure: NO_SVG)
    monkeypatch.setattr("hbench.report.render.figures.as_png", lambda figure: NO_PNG)


_FITS: dict[bytes, tuple] = {}  # of a worker, by curve and settings


@pytest.fixture
def fitted_once(monkeypatch):
    """Fit the same curve once for all tests, where a test looks at something else than the fits."""
    from hbench.analysis.fitting.fit import fits

    def once(*arguments):
        key = pickle.dumps(arguments)
        if key not in _FITS:
            _FITS[key] = fits(*arguments)
        return _FITS[key]

    monkeypatch.setattr("hbench.analysis.fitting.joint.fits", once)


@pytest.fixture
def one_process(monkeypatch):
    """Analyze the campaigns of a fleet in the test's process: others take seconds to start."""
    monkeypatch.setattr("hbench.workflow.fleet.map_on_cores", map)


QUICK = {  # runs of a third of a second
    "velocities": ["80 mm/s", "120 mm/s"],
    "trials": 2,
    "travel": {"start": "180 mm", "end": "260 mm"},
    "acceleration": "2 m/s^2",
    "hold": "0.05 s",
    "window": "0.2 s",
}
SCREENING = {"settle_time": "0.01 s", "settle_travel": "1 mm", "min_window": "0.12 s"}


@pytest.fixture
def short_schedule(tmp_path):
    """Return a function that writes the short schedule (two speeds, two trials) and its bench.

    Keyword arguments replace keys of its only experiment; ``bench`` replaces keys of the bench.
    """

    def write(bench: dict | None = None, **changes) -> Path:
        data = copy.deepcopy(SHORT)
        data["experiments"][0] |= changes
        bench_data = yaml.safe_load((ROOT / "configs" / "bench-aau.yaml").read_text())
        for section, values in (bench or {}).items():
            bench_data[section] |= values
        (tmp_path / "bench.yaml").write_text(yaml.dump(bench_data, Dumper=yaml.CSafeDumper))
        path = tmp_path / "short.yaml"
        path.write_text(yaml.dump(data, Dumper=yaml.CSafeDumper))
        return path

    return write


@pytest.fixture
def clock():
    """Return a clock that goes on by a second each time it is read."""
    ticks = iter(range(10**6))
    start = datetime(2026, 1, 1, tzinfo=UTC)
    return lambda: start + timedelta(seconds=next(ticks))


@pytest.fixture
def quick_schedule(short_schedule):
    """Return a function that writes a schedule of four runs of a third of a second each.

    Its arguments are those of ``short_schedule``.
    """

    def write(bench: dict | None = None, **changes) -> Path:
        path = short_schedule(bench, **(copy.deepcopy(QUICK) | changes))
        path.write_text(yaml.safe_dump(yaml.safe_load(path.read_text()) | {"screening": SCREENING}))
        return path

    return write


@pytest.fixture
def quick_experiment(quick_schedule):
    """Return the quick schedule, read and checked."""
    return workflow.load_experiment(quick_schedule(), None)


@pytest.fixture(scope="session")
def on_the_rig():
    """Return a function that makes a schedule's runs on the virtual rig and loads the campaign."""
    from hbench import workflow
    from hbench.store.campaign.folder import load_campaign

    def make(schedule: Path, folder: Path, **options):
        measure_on_rig(workflow.load_experiment(schedule, None), folder, **options)
        return load_campaign(folder)

    return make


_LIMIT_S, _LIMIT_BYTES = 120, 700_000_000


@pytest.fixture
def limited():
    """Return a context manager: what runs in it has two minutes (or so many s) and 700 MB more."""
    return _limited


@contextmanager
def _limited(seconds=_LIMIT_S):
    """Hold what runs in here to so much time and more memory."""

    def late(*_):
        raise AssertionError(f"takes longer than {seconds} s")

    pages = int(Path("/proc/self/statm").read_text().split()[0])
    before = resource.getrlimit(resource.RLIMIT_AS)
    handler = signal.signal(signal.SIGALRM, late)
    signal.alarm(seconds)
    most = pages * resource.getpagesize() + _LIMIT_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (most, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)
        signal.alarm(0)
        signal.signal(signal.SIGALRM, handler)
