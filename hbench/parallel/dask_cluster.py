"""The same work with many arguments, on the workers of a Dask cluster."""

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

_AHEAD = 3  # arguments a thread of the cluster: the next ones are there when one ends
_CONNECT_S = 10.0
_PATIENCE_S = 60.0  # without any worker, or without the scheduler
_LOOK_S = 1.0  # how often that is looked at
_PLUGIN = "hbench: no profiles"
_PROFILES = ("profile", "profile-cycle")  # of a worker's periodic callbacks


@contextmanager
def connected(address: str) -> "Iterator[Client]":
    """Connect to the scheduler at ``address``, such as ``tcp://host:8786``.

    Meanwhile its workers make no profiles, which would fill their memory.
    Raises ``ConfigError`` where Dask is missing or no address is given, ``DeviceError`` where
    nobody answers.
    """
    try:
        import dask
        from distributed import Client
        from distributed.comm import get_address_host_port
    except ImportError as error:
        raise ConfigError(
            f"--scheduler needs dask.distributed, which is not installed: {error}",
            "pip install 'hbench[cluster]', or leave --scheduler out to use this machine's cores.",
        ) from None
    try:
        get_address_host_port(address)
    except ValueError as error:
        raise ConfigError(
            f"--scheduler {address}: is no address: {error}", "Such as tcp://127.0.0.1:8786."
        ) from None
    limits = {
        "distributed.comm.timeouts.connect": _CONNECT_S,
        "distributed.comm.retry.count": 0,
    }
    with dask.config.set(limits), _quiet():
        try:
            client = Client(address, timeout=_CONNECT_S, set_as_default=False)
        except (OSError, TimeoutError) as error:
            words = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise DeviceError(
                f"--scheduler {address}: nobody answers there: {words}",
                "Start one with 'dask scheduler', which prints its address.",
            ) from None
        try:
            with suppress(Exception):  # what is wrong with the workers is told of the first work
                client.register_plugin(_without_profiles(), _PLUGIN)
            yield client
        finally:
            with suppress(Exception):  # a scheduler that is gone
                client.unregister_worker_plugin(_PLUGIN)
            with suppress(Exception):
                client.close(timeout=5)


def _without_profiles() -> Any:
    """Return what ends the workers' profiles, of which each second's is kept for an hour."""
    from distributed import WorkerPlugin

    class WithoutProfiles(WorkerPlugin):
        def setup(self, worker):
            periodic = worker.periodic_callbacks
            self.ended = {name: periodic.pop(name) for name in _PROFILES if name in periodic}
            for each in self.ended.values():
                each.stop()

        def teardown(self, worker):
            worker.periodic_callbacks |= self.ended
            for each in self.ended.values():
                each.start()

    return WithoutProfiles()


def on_cluster(
    client: "Client",
    work: Callable[[Any], Any],
    arguments: Iterable[Any],
    tell: Callable[[str], None],
) -> Iterator[Any]:
    """Call ``work`` with each argument on a cluster, and give results as they come.

    ``work``, arguments and results must be picklable. Arguments are taken as they are needed, and
    what has ended is forgotten by the cluster; what ends this generator cancels the rest. ``tell``
    is given what a user should know. Raises ``ProcessDied`` where workers died over an argument,
    after what was begun has ended, and ``DeviceError`` where the scheduler is lost, no worker is
    left, or ``work`` can't be called there.
    """
    from distributed import KilledWorker

    taken = iter(arguments)
    running: dict[Future, Any] = {}
    ended: SimpleQueue[Future] = SimpleQueue()
    killed: list[Any] = []
    watch = _Watch(client, tell)
    try:
        while True:
            room = 0 if killed else _AHEAD * max(watch.threads(), 1) - len(running)
            for argument in islice(taken, max(room, 0)):
                future = client.submit(work, argument, pure=False)
                running[future] = argument
                future.add_done_callback(ended.put)
            if not running:
                break
            try:
                future = ended.get(timeout=_LOOK_S)
            except Empty:
                watch.look()
                continue
            argument = running.pop(future)
            try:
                result = future.result()
            except KilledWorker:
                killed.append(argument)
                continue
            except CancelledError:
                raise watch.lost() from None
            except Exception as error:
                raise DeviceError(
                    f"the workers can't do this work: {error}",
                    "Each needs the same hbench, Python and packages as this machine.",
                ) from None
            future.release()
            yield result
    finally:
        with suppress(Exception):  # a scheduler that is gone
            client.cancel(list(running), force=True)
    if killed:
        raise ProcessDied(killed, "workers have died over the same work", "")


class _Watch:
    """Knows how many threads the cluster has, and when to give up."""

    def __init__(self, client: "Client", tell: Callable[[str], None]):
        self._client = client
        self._tell = tell
        self._address = client.scheduler.address
        self._looked = -1e9
        self._threads = 0
        self._alone_since: float | None = None

    def threads(self) -> int:
        """Return how many there were when they were counted last."""
        if time.monotonic() - self._looked > _LOOK_S:
            self.look()
        return self._threads

    def look(self) -> None:
        """Count the workers' threads. Raises ``DeviceError`` when there were none for too long."""
        if self._client.status in ("closed", "closing"):
            raise self.lost()
        self._looked = time.monotonic()
        try:
            self._threads = self._client.scheduler_info(n_workers=0)["total_threads"]
        except (OSError, TimeoutError, ValueError):
            self._threads = 0
        if self._threads:
            self._alone_since = None
        elif self._alone_since is None:
            self._alone_since = self._looked
            self._tell(f"{self._address} has no workers; waiting for {_PATIENCE_S:.0f} s")
        elif self._looked - self._alone_since > _PATIENCE_S:
            raise DeviceError(
                f"{self._address}: no worker for {_PATIENCE_S:.0f} s",
                "Start some with 'dask worker ADDRESS', and give the same command again: what is "
                "done is kept.",
            )

    def lost(self) -> DeviceError:
        """Return the error of a scheduler that has gone."""
        return DeviceError(
            f"{self._address}: the scheduler is lost",
            "Start it again, and give the same command again: what is done is kept.",
        )


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep the log of Dask's own attempts to connect off the terminal."""
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
