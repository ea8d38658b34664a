"""Loads the firmware's host library, which is built when hbench is installed."""

import ctypes
import importlib
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from hbench.errors import DeviceError

POLL_TICKS = 10  # a simulated board's idle loop comes round about once a millisecond

_SUFFIXES = (".so", ".dll")
_REPLY_OCTETS = 4096  # as much as the board's queue holds


@cache
def load_library() -> ctypes.CDLL:
    """Return the installed library. Raises ``DeviceError`` if it is not there."""
    return open_library(_library_path())


def open_library(path: Path) -> ctypes.CDLL:
    """Return the library in a file, its functions declared. Raises ``DeviceError``."""
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise DeviceError(
            f"{path}: can't be loaded: {error}", "Build it for this machine: `pip install .`"
        ) from None
    octets = ctypes.c_char_p
    for name, result, arguments in (
        ("create", ctypes.c_void_p, (ctypes.c_uint16, ctypes.c_uint32)),
        ("destroy", None, (ctypes.c_void_p,)),
        ("tick", None, (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)),
        ("overrun", None, (ctypes.c_void_p,)),
        ("poll", ctypes.c_uint32, (ctypes.c_void_p,)),
        ("receive", ctypes.c_uint32, (ctypes.c_void_p, octets, ctypes.c_uint32)),
        ("transmit", ctypes.c_uint32, (ctypes.c_void_p, octets, ctypes.c_uint32)),
    ):
        function = getattr(library, f"hb_host_{name}")
        function.restype, function.argtypes = result, arguments
    return library


def _library_path() -> Path:
    """Find the library in any of this package's folders (an editable install has two)."""
    folders = [Path(folder) for folder in importlib.import_module(__package__).__path__]
    for folder in folders:
        for suffix in _SUFFIXES:
            path = folder / f"libhbench_firmware{suffix}"
            if path.is_file():
                return path
    raise DeviceError(
        f"the firmware's host library is not in {' or '.join(map(str, folders))}",
        "It is built at install: `pip install .` (a C compiler is needed).",
    )


class HostFirmware:
    """One board: the firmware's core with its own memory, stepped by its caller.

    ``boots`` is what it reports as its number of starts. With ``baud`` octets take their time on
    the line, and ``poll`` must be called once each tick; with 0 they take none.
    """

    def __init__(self, boots: int, baud: int = 0):
        self._library = load_library()
        self._board = self._library.hb_host_create(boots, baud)
        if not self._board:
            raise MemoryError("no memory for the firmware's context")

    @property
    def addresses(self) -> tuple[int, int, int]:
        """Addresses for compiled callers: of ``tick``, of ``poll``, and of the board.

        ``void tick(board, const uint16_t adc[7], int16_t dac[3])``,
        ``uint32_t poll(board)``, which returns the number of octets that wait for the host, 0
        until a frame has ended among them. They hold until ``close``.
        """
        functions = (self._library.hb_host_tick, self._library.hb_host_poll)
        tick, poll = (ctypes.cast(function, ctypes.c_void_p).value or 0 for function in functions)
        return tick, poll, self._board

    def receive(self, data: bytes) -> int:
        """Send octets to the board; returns how many found room in its queue (4096)."""
        return self._library.hb_host_receive(self._board, data, len(data))

    def transmit(self) -> bytes:
        """Take the octets that wait for the host."""
        octets = ctypes.create_string_buffer(_REPLY_OCTETS)
        count = self._library.hb_host_transmit(self._board, octets, _REPLY_OCTETS)
        return octets.raw[:count]

    def poll(self) -> int:
        """Run the idle loop once; returns the number of octets whose frame has ended, or 0."""
        return self._library.hb_host_poll(self._board)

    def tick(self, adc: Sequence[int]) -> tuple[int, int, int]:
        """Run one control tick: converter words (7, in 1/16 count) to DAC codes (3)."""
        words = (ctypes.c_uint16 * 7)(*adc)
        codes = (ctypes.c_int16 * 3)()
        self._library.hb_host_tick(self._board, words, codes)
        return tuple(codes)

    def overrun(self) -> None:
        """Tell the board that its control interrupt came late."""
        self._library.hb_host_overrun(self._board)

    def close(self) -> None:
        """Free the board's memory; it can't be used any more."""
        self._library.hb_host_destroy(self._board)
        self._board = None
