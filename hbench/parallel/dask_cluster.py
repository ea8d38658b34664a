"""Dask cluster: one function with many arguments, on the workers of a scheduler."""

import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from itertools import islice
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from hbench.errors import ConfigError, DeviceError
from hbench.parallel.process_pool import ProcessDied

if TYPE_CHECKING:
    from distributed import Client, Future

_QUEUED = 3  # arguments per thread of the cluster, so that no thread waits for the next one
_CONNECT_S = 10.0
_PATIENCE_S = 60.0  # without any worker, or without the scheduler
_CHECK_S = 1.0  # interval between checks of the workers
_PLUGIN = "hbench: no profiles"
_PROFILES = ("profile", "profile-cycle")  # of a worker's periodic callbacks


@contextmanager
def connected(address: str) -> "Iterator[Client]":
    """Connect to the scheduler at ``address``, such as ``tcp://host:8786``.

    While connected, its workers record no profiles, which would fill their memory.
    Raises ``ConfigError`` for missing Dask or an invalid address, ``DeviceError`` if no scheduler
    answers.
    """
    try:
        import dask
        from distributed import Client
        from distributed.comm import get_address_host_port
    except ImportError as error:
        raise ConfigError(
            f"--scheduler needs dask.distributed, which is not installed: {error}",
            "Run pip install 'hbench[cluster]', or omit --scheduler to use this machine's cores.",
        ) from None
    try:
        get_address_host_port(address)
    except ValueError as error:
        raise ConfigError(
            f"--scheduler {address}: is not an address: {error}",
            "Give an address such as tcp://127.0.0.1:8786.",
        ) from None
    limits = {
        "distributed.comm.timeouts.connect": _CONNECT_S,
        "distributed.comm.retry.count": 0,
    }
    with dask.config.set(limits), _quiet():
        try:
            client = Client(address, timeout=_CONNECT_S, set_as_default=False)
        except (OSError, TimeoutError) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise DeviceError(
                f"--scheduler {address}: no scheduler answers: {reason}",
                "Start one with 'dask scheduler', which prints its address.",
            ) from None
        try:
            with suppress(Exception):  # the first task reports any fault of the workers
                client.register_plugin(_without_profiles(), _PLUGIN)
            yield client
        finally:
            with suppress(Exception):  # a scheduler that is gone
                client.unregister_worker_plugin(_PLUGIN)
            with suppress(Exception):
                client.close(timeout=5)


def _without_profiles() -> Any:
    """Return a plugin that stops the workers' profiling, whose data is kept for an hour."""
    from distributed import WorkerPlugin

    class WithoutProfiles(WorkerPlugin):
        def setup(self, worker):
            periodic = worker.periodic_callbacks
            self.stopped = {name: periodic.pop(name) for name in _PROFILES if name in periodic}
            for callback in self.stopped.values():
                callback.stop()

        def teardown(self, worker):
            worker.periodic_callbacks |= self.stopped
            for callback in self.stopped.values():
                callback.start()

    return WithoutProfiles()


def map_on_cluster(
    client: "Client",
    work: Callable[[Any], Any],
    arguments: Iterable[Any],
    note: Callable[[str], None],
) -> Iterator[Any]:
    """Call ``work`` with each argument on a cluster, and yield results as they come.

    ``work``, arguments and results must be picklable. Arguments are taken on demand, and the
    cluster releases finished results; the end of this generator cancels the others. ``note`` gets
    messages for the user. Raises ``ProcessDied`` if an argument has killed workers, after all
    started work has ended, and ``DeviceError`` if the scheduler is lost, no worker is left, or
    ``work`` can't be called there.
    """
    from distributed import KilledWorker

    taken = iter(arguments)
    running: dict[Future, Any] = {}
    ended: SimpleQueue[Future] = SimpleQueue()
    killers: list[Any] = []  # arguments
    workers = _Workers(client, note)
    try:
        while True:
            room = 0 if killers else _QUEUED * max(workers.threads(), 1) - len(running)
            for argument in islice(taken, max(room, 0)):
                future = client.submit(work, argument, pure=False)
                running[future] = argument
                future.add_done_callback(ended.put)
            if not running:
                break
            try:
                future = ended.get(timeout=_CHECK_S)
            except Empty:
                workers.check()
                continue
            argument = running.pop(future)
            try:
                result = future.result()
            except KilledWorker:
                killers.append(argument)
                continue
            except CancelledError:
                raise workers.scheduler_lost() from None
            except Exception as error:
                raise DeviceError(
                    f"a task failed on a worker: {error}",
                    "Install the same hbench, Python and packages on each worker as here.",
                ) from None
            future.release()
            yield result
    finally:
        with suppress(Exception):  # a scheduler that is gone
            client.cancel(list(running), force=True)
    if killers:
        raise ProcessDied(killers, "several workers have died from the same task", "")


class _Workers:
    """The cluster's workers: their number of threads, and the wait for them."""

    def __init__(self, client: "Client", note: Callable[[str], None]):
        self._client = client
        self._note = note
        self._address = client.scheduler.address
        self._checked = -1e9
        self._threads = 0
        self._none_since: float | None = None

    def threads(self) -> int:
        """Return the number of threads at the last check."""
        if time.monotonic() - self._checked > _CHECK_S:
            self.check()
        return self._threads

    def check(self) -> None:
        """Count the workers' threads. Raises ``DeviceError`` after too long without workers."""
        if self._client.status in ("closed", "closing"):
            raise self.scheduler_lost()
        self._checked = time.monotonic()
        try:
            self._threads = self._client.scheduler_info(n_workers=0)["total_threads"]
        except (OSError, TimeoutError, ValueError):
            self._threads = 0
        if self._threads:
            self._none_since = None
        elif self._none_since is None:
            self._none_since = self._checked
            self._note(f"{self._address} has no workers; waiting for {_PATIENCE_S:.0f} s")
        elif self._checked - self._none_since > _PATIENCE_S:
            raise DeviceError(
                f"{self._address}: no workers for {_PATIENCE_S:.0f} s",
                "Start workers with 'dask worker ADDRESS', then give the same command again to "
                "continue.",
            )

    def scheduler_lost(self) -> DeviceError:
        """Return the error of a lost scheduler."""
        return DeviceError(
            f"{self._address}: connection to the scheduler lost",
            "Start the scheduler again, then give the same command again to continue.",
        )


@contextmanager
def _quiet() -> Iterator[None]:
    """Suppress Dask's log of its attempts to connect."""
    import logging

    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)
