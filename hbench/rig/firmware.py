"""The firmware's host library, which is built when hbench is installed."""

import ctypes
import importlib
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from hbench.errors import DeviceError

POLL_TICKS = 10  # control ticks per round of a simulated board's idle loop: 1 ms

_SUFFIXES = (".so", ".dll")
_REPLY_OCTETS = 4096  # capacity of the board's queue


@cache
def load_library() -> ctypes.CDLL:
    """Return the installed library. Raises ``DeviceError`` if it is missing."""
    return open_library(_library_path())


def open_library(path: Path) -> ctypes.CDLL:
    """Return the library in a file, with typed functions. Raises ``DeviceError``."""
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise DeviceError(
            f"{path}: can't be loaded: {error}", "Build it for this machine with pip install ."
        ) from None
    octets = ctypes.c_char_p
    for name, result, arguments in (
        ("create", ctypes.c_void_p, (ctypes.c_uint16, ctypes.c_uint32)),
        ("destroy", None, (ctypes.c_void_p,)),
        ("tick", None, (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)),
        ("overrun", None, (ctypes.c_void_p,)),
        ("poll", ctypes.c_uint32, (ctypes.c_void_p,)),
        ("needs_supply_off", ctypes.c_uint32, (ctypes.c_void_p,)),
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
        f"{' or '.join(map(str, folders))}: the firmware's host library is missing",
        "Install hbench with pip install . and a C compiler, which builds it.",
    )


class HostFirmware:
    """A board: the firmware's core with its own memory, stepped by its caller.

    ``boots`` is the reported number of starts. ``baud`` is the simulated rate of the line, with
    which ``poll`` must be called once each tick; with 0 octets take no time.
    """

    def __init__(self, boots: int, baud: int = 0):
        self._library = load_library()
        self._board = self._library.hb_host_create(boots, baud)
        if not self._board:
            raise MemoryError("no memory for the firmware's context")
        # Addresses of ``tick``, of ``poll`` and of the board, for compiled callers; valid until
        # ``close``. ``void tick(board, const uint16_t adc[8], int16_t dac[3])``,
        # ``uint32_t poll(board)``, which returns the number of octets for the host, or 0 while they
        # contain no complete frame.
        functions = (self._library.hb_host_tick, self._library.hb_host_poll)
        tick, poll = (ctypes.cast(function, ctypes.c_void_p).value or 0 for function in functions)
        self.addresses: tuple[int, int, int] = (tick, poll, self._board)

    def receive(self, data: bytes) -> int:
        """Send octets to the board; return the number that its queue (4096) accepted."""
        return self._library.hb_host_receive(self._board, data, len(data))

    def transmit(self) -> bytes:
        """Return the octets for the host, and remove them from the queue."""
        octets = ctypes.create_string_buffer(_REPLY_OCTETS)
        count = self._library.hb_host_transmit(self._board, octets, _REPLY_OCTETS)
        return octets.raw[:count]

    def poll(self) -> int:
        """Run the idle loop once; return the number of octets for the host, 0 without a frame."""
        return self._library.hb_host_poll(self._board)

    def tick(self, adc: Sequence[int]) -> tuple[int, int, int]:
        """Run one control tick: converter words (8, in 1/16 count) to DAC codes (3)."""
        words = (ctypes.c_uint16 * 8)(*adc)
        codes = (ctypes.c_int16 * 3)()
        self._library.hb_host_tick(self._board, words, codes)
        return tuple(codes)

    @property
    def needs_supply_off(self) -> bool:
        """Whether the uploaded schedule begins with a zero check."""
        return bool(self._library.hb_host_needs_supply_off(self._board))

    def overrun(self) -> None:
        """Report a late control interrupt to the board."""
        self._library.hb_host_overrun(self._board)

    def close(self) -> None:
        """Free the board's memory; no other call is valid afterwards."""
        self._library.hb_host_destroy(self._board)
        self._board = None
