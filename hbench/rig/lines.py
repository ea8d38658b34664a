"""The rig's end of a line to its client: a pseudo-terminal or a TCP socket."""

import os
import select
import socket
import time
from typing import Protocol
from urllib.parse import urlsplit

from hbench.errors import ConfigError, DeviceError

_CHUNK = 4096  # octets; as much as the board's queue holds


class Line(Protocol):
    """The rig's end of a line to one client at a time."""

    name: str  # what the client gives as its port

    @property
    def connected(self) -> bool:
        """Whether a client is there, as the last ``read`` saw it."""

    def read(self, timeout_s: float) -> bytes:
        """Return what the client sent, at once if there is something; empty after the timeout."""

    def write(self, data: bytes) -> None:
        """Send octets; as on a UART, those that nobody takes are lost."""

    def close(self) -> None:
        """Take the line down."""


def open_line(address: str | None) -> Line:
    """Return a socket's line for an address ``HOST:PORT``, else a pseudo-terminal's.

    Raises ``ConfigError`` for an address that is none, ``DeviceError`` where it can't be opened.
    """
    return PtyLine() if address is None else SocketLine(address)


class PtyLine:
    """A pseudo-terminal; whoever opens its other end is the client."""

    def __init__(self):
        try:
            import tty
        except ImportError:
            raise DeviceError(
                "this system has no pseudo-terminals", "Use --socket HOST:PORT."
            ) from None
        self._master, terminal = os.openpty()
        tty.setraw(terminal)
        self.name = os.ttyname(terminal)
        os.close(terminal)  # so that the client's leaving shows as a hang-up
        os.set_blocking(self._master, False)
        self._poll = select.poll()
        self._poll.register(self._master, select.POLLIN)
        self.connected = False

    def read(self, timeout_s: float) -> bytes:
        """Return what the client sent."""
        events = dict(self._poll.poll(1e3 * timeout_s)).get(self._master, 0)
        self.connected = not events & select.POLLHUP
        if events & select.POLLIN:
            return os.read(self._master, _CHUNK)
        if not self.connected:
            time.sleep(timeout_s)  # a hang-up ends the poll at once
        return b""

    def write(self, data: bytes) -> None:
        """Send to the client, if there is one and it reads."""
        if data and self.connected:
            try:
                os.write(self._master, data)
            except OSError:  # full, or the client has just left
                return

    def close(self) -> None:
        """Take the terminal away."""
        os.close(self._master)


class SocketLine:
    """A TCP socket that listens; a second client is turned away while the first is there."""

    def __init__(self, address: str):
        try:
            parts = urlsplit(f"//{address}")
            host, port = parts.hostname, parts.port
        except ValueError:
            host = port = None
        if host is None or port is None:
            raise ConfigError(f"'{address}' is not HOST:PORT, e.g. localhost:7000")
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        try:
            self._listener = socket.create_server((host, port), family=family)
        except OSError as error:
            raise DeviceError(f"{address}: can't listen: {error.strerror or error}") from None
        self._listener.setblocking(False)
        shown = f"[{host}]" if ":" in host else host
        self.name = f"socket://{shown}:{self._listener.getsockname()[1]}"
        self._client: socket.socket | None = None

    @property
    def connected(self) -> bool:
        """Whether a client is there."""
        return self._client is not None

    def read(self, timeout_s: float) -> bytes:
        """Return what the client sent; let one in or turn it away."""
        ends = [self._listener] if self._client is None else [self._listener, self._client]
        ready, _, _ = select.select(ends, [], [], timeout_s)
        data = b""
        if self._client is not None and self._client in ready:
            data = self._receive(self._client)
        if self._listener in ready:
            self._accept()
        return data

    def write(self, data: bytes) -> None:
        """Send to the client, if there is one and it reads."""
        if data and self._client is not None:
            try:
                self._client.send(data)
            except BlockingIOError:
                return
            except OSError:
                self._hang_up()

    def close(self) -> None:
        """Stop listening and hang up."""
        self._hang_up()
        self._listener.close()

    def _accept(self) -> None:
        try:
            client, _ = self._listener.accept()
        except OSError:  # it has left again
            return
        if self._client is not None:
            client.close()
            return
        client.setblocking(False)
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._client = client

    def _receive(self, client: socket.socket) -> bytes:
        try:
            data = client.recv(_CHUNK)
        except OSError:
            data = b""
        if not data:
            self._hang_up()
        return data

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None
