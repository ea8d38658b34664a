"""Read-only server of the page of ``hbench watch``, for this machine only.

It serves three fixed addresses and no files. The request's host must be this machine: a foreign
page whose name resolves to this machine (DNS rebinding) has another host.
"""

import base64
import hashlib
import json
import re
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from typing import Any, Protocol

from hbench.errors import ConfigError

_HOST = re.compile(r"(127\.0\.0\.1|localhost)(:\d{1,5})?", re.IGNORECASE | re.ASCII)
_TIMEOUT_S = 10.0  # of a silent client
_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class Watched(Protocol):
    """Source of the page's data."""

    def state(self) -> dict[str, Any]:
        """Return the present state."""

    def runs(self) -> dict[str, Any]:
        """Return the finished runs."""


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    allow_reuse_address = True


def new_server(watched: Watched, port: int) -> ThreadingHTTPServer:
    """Return a server on 127.0.0.1; port 0 means any free port. Raises ``ConfigError``."""
    page = (files("hbench.cli") / "watch_page.html").read_bytes()
    answers: dict[str, tuple[str, Callable[[], bytes]]] = {
        "/": ("text/html; charset=utf-8", lambda: page),
        "/state.json": ("application/json", lambda: _json(watched.state())),
        "/runs.json": ("application/json", lambda: _json(watched.runs())),
    }

    class Handler(_Handler):
        known = answers
        policy = _policy(page.decode())

    try:
        return _Server(("127.0.0.1", port), Handler)
    except OSError as error:
        raise ConfigError(
            f"--port: can't listen at {port}: {error.strerror}",
            "Give another number, or 0 for any free port.",
        ) from None


class _Handler(BaseHTTPRequestHandler):
    """Handler of GET and HEAD requests for the known addresses."""

    known: dict[str, tuple[str, Callable[[], bytes]]]
    policy: str
    timeout = _TIMEOUT_S
    server_version, sys_version = "hbench", ""

    def do_GET(self) -> None:
        """Send the address's content."""
        if not _HOST.fullmatch(self.headers.get("Host", "")):
            self._answer(HTTPStatus.MISDIRECTED_REQUEST, "text/plain", b"not this machine\n")
        elif self.path not in self.known:
            self._answer(HTTPStatus.NOT_FOUND, "text/plain", b"not found\n")
        else:
            kind, content = self.known[self.path]
            self._answer(HTTPStatus.OK, kind, content())

    do_HEAD = do_GET

    def _refuse(self) -> None:
        self.close_connection = True
        self._answer(HTTPStatus.METHOD_NOT_ALLOWED, "text/plain", b"this page is read-only\n")

    do_POST = do_PUT = do_DELETE = do_PATCH = do_OPTIONS = _refuse

    def _answer(self, status: HTTPStatus, kind: str, content: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Content-Security-Policy", self.policy)
        if status == HTTPStatus.METHOD_NOT_ALLOWED:
            self.send_header("Allow", "GET, HEAD")
        for name, value in _HEADERS.items():
            self.send_header(name, value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)

    def log_message(self, *_: Any) -> None:
        """Log nothing."""

    def handle(self) -> None:
        """Serve a client; an early disconnection is not an error."""
        try:
            super().handle()
        except ConnectionError:
            return


def _policy(page: str) -> str:
    """Return a policy that permits the page's style and script, by hash, and this server's data."""
    rules = ["default-src 'none'", "connect-src 'self'", "frame-ancestors 'none'"]
    rules += ["base-uri 'none'", "form-action 'none'", "img-src data:"]
    for tag in ("style", "script"):
        (content,) = re.findall(rf"<{tag}>(.*?)</{tag}>", page, re.DOTALL)
        digest = base64.b64encode(hashlib.sha256(content.encode()).digest()).decode()
        rules.append(f"{tag}-src 'sha256-{digest}'")
    return "; ".join(rules)


def _json(value: dict[str, Any]) -> bytes:
    return json.dumps(value, allow_nan=False).encode()
