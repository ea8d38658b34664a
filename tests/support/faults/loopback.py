"""A Dask cluster of real processes on loopback, and hosts that use it."""

import os
import re
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

from hbench.parallel.one_thread import ONE_THREAD

DEADLY = Path(__file__).parent / "deadly.py"
LIMIT_S = 300.0  # of a wait; it takes some seconds
_ENV = ONE_THREAD | {"PYTHONPATH": os.pathsep.join(sys.path)}


class Loopback:
    """Its processes, each with a file that it tells what it does.

    A campaign that has killed more workers than ``forgiven`` is given up.
    """

    def __init__(self, folder: Path, workers: int, *, nanny: bool = False, forgiven: int = 1):
        self._folder = folder
        self._env = _ENV | {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": str(forgiven)}
        self._processes: list[subprocess.Popen] = []
        self.scheduler = self._start(
            "-m", "dask", "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard"
        )
        (self.address,) = self._wait_for(self.scheduler, r"Scheduler at:\s+(tcp://\S+)")
        self.workers = [self.worker(nanny) for _ in range(workers)]
        for worker in self.workers:
            self._wait_for(worker, r"Starting established connection")

    def worker(self, nanny: bool = False) -> subprocess.Popen:
        """Start a worker of one thread; without a nanny it is gone for good when it dies."""
        return self._start(
            *("-m", "dask", "worker", self.address, "--nthreads", "1", "--no-dashboard"),
            *("--nanny" if nanny else "--no-nanny", "--memory-limit", "0"),
            *("--local-directory", self._folder, "--preload", DEADLY),
        )

    def hbench(self, *arguments) -> subprocess.Popen:
        """Start hbench, with the same faults as the workers have."""
        return self._start(DEADLY, *arguments)

    def ended(self, process: subprocess.Popen, within_s: float = LIMIT_S) -> tuple[int, str]:
        """Wait for a process; return its exit code and what it told."""
        code = process.wait(within_s)
        return code, self._told(process).read_text()

    def wait_for_campaigns(self, host: subprocess.Popen, least: int) -> None:
        """Wait until a host has told that so many campaigns are done."""
        deadline = time.monotonic() + LIMIT_S
        while True:
            told = self._told(host).read_text()
            done = [int(n) for n in re.findall(r"^(\d+)/\d+ campaigns", told, re.M)]
            if done and done[-1] >= least:
                return
            assert host.poll() is None and time.monotonic() < deadline, told
            time.sleep(0.02)

    def close(self) -> None:
        """End all."""
        for process in reversed(self._processes):
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait(LIMIT_S)

    def _start(self, *arguments) -> subprocess.Popen:
        path = self._folder / f"told-{len(self._processes)}"
        with path.open("w") as told:
            process = subprocess.Popen(
                [sys.executable, *map(str, arguments)],
                stdin=subprocess.DEVNULL,
                stdout=told,
                stderr=told,
                start_new_session=True,
                cwd=self._folder,
                env=os.environ | self._env,
            )
        self._processes.append(process)
        return process

    def _told(self, process: subprocess.Popen) -> Path:
        return self._folder / f"told-{self._processes.index(process)}"

    def _wait_for(self, process: subprocess.Popen, words: str) -> tuple[str, ...]:
        deadline = time.monotonic() + LIMIT_S
        while not (found := re.search(words, self._told(process).read_text())):
            assert process.poll() is None, self._told(process).read_text()
            assert time.monotonic() < deadline, "waited in vain"
            time.sleep(0.05)
        return found.groups()
