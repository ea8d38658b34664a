"""Serves the page of ``hbench watch``: to this machine alone, and nothing can be written.

Three fixed addresses, no file of the disk. A request must name this machine as its host: a page
from elsewhere, whose name was made to point here (DNS rebinding), names another.
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
_SILENT_S = 10.0  # that a client may be before it is hung up on
_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class Watched(Protocol):
    """What there is to show."""

    def state(self) -> dict[str, Any]:
        """Return what is told of this moment."""

    def runs(self) -> dict[str, Any]:
        """Return the runs that have ended."""


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    allow_reuse_address = True


def new_server(watched: Watched, port: int) -> ThreadingHTTPServer:
    """Return a server on 127.0.0.1; 0 takes any free port. Raises ``ConfigError``."""
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
            f"--port: {port} can't be used: {error.strerror}",
            "Another page may be served there; give another number, or 0 for any that is free.",
        ) from None


class _Handler(BaseHTTPRequestHandler):
    """Answers GET and HEAD for the known addresses."""

    known: dict[str, tuple[str, Callable[[], bytes]]]
    policy: str
    timeout = _SILENT_S
    server_version, sys_version = "hbench", ""

    def do_GET(self) -> None:
        """Answer with the address's content."""
        if not _HOST.fullmatch(self.headers.get("Host", "")):
            self._answer(HTTPStatus.MISDIRECTED_REQUEST, "text/plain", b"not this machine\n")
        elif self.path not in self.known:
            self._answer(HTTPStatus.NOT_FOUND, "text/plain", b"nothing here\n")
        else:
            kind, content = self.known[self.path]
            self._answer(HTTPStatus.OK, kind, content())

    do_HEAD = do_GET

    def _refuse(self) -> None:
        self.close_connection = True
        self._answer(HTTPStatus.METHOD_NOT_ALLOWED, "text/plain", b"this page only shows\n")

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
        """Say nothing of each request."""

    def handle(self) -> None:
        """Answer a client; one that hangs up early is no error."""
        try:
            super().handle()
        except ConnectionError:
            return


def _policy(page: str) -> str:
    """Allow the page's own style and script, known by their hashes, and asking this server."""
    rules = ["default-src 'none'", "connect-src 'self'", "frame-ancestors 'none'"]
    rules += ["base-uri 'none'", "form-action 'none'", "img-src data:"]
    for tag in ("style", "script"):
        (own,) = re.findall(rf"<{tag}>(.*?)</{tag}>", page, re.DOTALL)
        digest = base64.b64encode(hashlib.sha256(own.encode()).digest()).decode()
        rules.append(f"{tag}-src 'sha256-{digest}'")
    return "; ".join(rules)


def _json(value: dict[str, Any]) -> bytes:
    return json.dumps(value, allow_nan=False).encode()
