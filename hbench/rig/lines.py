"""The virtual rig's end of a line: a pseudo-terminal or a TCP socket."""

import os
import select
import socket
import time
from typing import Protocol
from urllib.parse import urlsplit

from hbench.errors import ConfigError, DeviceError

_CHUNK = 4096  # octets; capacity of the board's queue


class ServerLine(Protocol):
    """The rig's end of a line to one client at a time."""

    name: str  # the client's --port

    @property
    def connected(self) -> bool:
        """Whether a client was connected at the last ``read``."""

    def read(self, timeout_s: float) -> bytes:
        """Return the octets received, as soon as there are any; empty after the timeout."""

    def write(self, data: bytes) -> None:
        """Send octets; as on a UART, they are lost if the client does not read."""

    def close(self) -> None:
        """Close the line."""


def open_line(address: str | None) -> ServerLine:
    """Open a socket at ``HOST:PORT``; without an address, a pseudo-terminal.

    Raises ``ConfigError`` for an invalid address, ``DeviceError`` if it can't be opened.
    """
    return PtyLine() if address is None else SocketLine(address)


class PtyLine:
    """Pseudo-terminal, whose other end is opened by the client."""

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
        os.close(terminal)  # so that a leaving client causes a hang-up
        os.set_blocking(self._master, False)
        self._poll = select.poll()
        self._poll.register(self._master, select.POLLIN)
        self.connected = False

    def read(self, timeout_s: float) -> bytes:
        """Return the octets received."""
        events = dict(self._poll.poll(1e3 * timeout_s)).get(self._master, 0)
        self.connected = not events & select.POLLHUP
        if events & select.POLLIN:
            return os.read(self._master, _CHUNK)
        if not self.connected:
            time.sleep(timeout_s)  # a hang-up ends the poll at once
        return b""

    def write(self, data: bytes) -> None:
        """Send octets to a connected client."""
        if data and self.connected:
            try:
                os.write(self._master, data)
            except OSError:  # full, or the client has just left
                return

    def close(self) -> None:
        """Close the terminal."""
        os.close(self._master)


class SocketLine:
    """Listening TCP socket; a second client is refused while the first is connected."""

    def __init__(self, address: str):
        try:
            url = urlsplit(f"//{address}")
            host, port = url.hostname, url.port
        except ValueError:
            host = port = None
        if host is None or port is None:
            raise ConfigError(
                f"--socket: '{address}' is not HOST:PORT", "Give an address as localhost:7000."
            )
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        try:
            self._listener = socket.create_server((host, port), family=family)
        except OSError as error:
            raise DeviceError(
                f"--socket: can't listen at {address}: {error.strerror or error}",
                "Give another address or port.",
            ) from None
        self._listener.setblocking(False)
        shown = f"[{host}]" if ":" in host else host
        self.name = f"socket://{shown}:{self._listener.getsockname()[1]}"
        self._client: socket.socket | None = None

    @property
    def connected(self) -> bool:
        """Whether a client is connected."""
        return self._client is not None

    def read(self, timeout_s: float) -> bytes:
        """Return the octets received; accept or refuse a new client."""
        sockets = [self._listener] if self._client is None else [self._listener, self._client]
        ready, _, _ = select.select(sockets, [], [], timeout_s)
        data = b""
        if self._client is not None and self._client in ready:
            data = self._receive(self._client)
        if self._listener in ready:
            self._accept()
        return data

    def write(self, data: bytes) -> None:
        """Send octets to a connected client."""
        if data and self._client is not None:
            try:
                self._client.send(data)
            except BlockingIOError:
                return
            except OSError:
                self._hang_up()

    def close(self) -> None:
        """Stop listening and disconnect the client."""
        self._hang_up()
        self._listener.close()

    def _accept(self) -> None:
        try:
            client, _ = self._listener.accept()
        except OSError:  # the client has left again
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
