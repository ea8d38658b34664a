"""PDF of a page by a browser of this machine, for a laboratory's own template."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from hbench.errors import ConfigError

_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome", "msedge")
_LIMIT_S = 60.0
_OPTIONS = (
    "--headless",
    "--disable-gpu",
    "--no-first-run",
    "--no-pdf-header-footer",
    "--host-resolver-rules=MAP * ~NOTFOUND",  # the page needs no network and gets none
)


def printed_page(page: str, source: str) -> bytes:
    """Return a page as PDF. Raises ``ConfigError`` where no browser prints it.

    ``source`` names the template in messages.
    """
    found = [path for name in _BROWSERS if (path := shutil.which(name))]
    hint = "Write it as .html and print that to a PDF in your browser."
    if not found:
        raise ConfigError(
            f"{source}: a template of your own needs Chromium, Chrome or Edge to become a PDF, and "
            "none of them is in the PATH",
            hint,
        )
    with tempfile.TemporaryDirectory(prefix="hbench-") as name:
        folder = Path(name)
        (folder / "page.html").write_text(page, encoding="utf-8")
        options = [*_OPTIONS, f"--user-data-dir={folder / 'profile'}"]
        if getattr(os, "geteuid", lambda: 1)() == 0:
            options.append("--no-sandbox")  # it runs as root only without
        command = [found[0], *options, f"--print-to-pdf={folder / 'page.pdf'}"]
        try:
            done = subprocess.run(
                [*command, (folder / "page.html").as_uri()],
                capture_output=True,
                text=True,
                timeout=_LIMIT_S,
            )
            return (folder / "page.pdf").read_bytes()
        except subprocess.TimeoutExpired:
            reason = f"it took more than {_LIMIT_S:g} s"
        except FileNotFoundError:
            reason = f"exit code {done.returncode}; {done.stderr.strip()[-200:]}"
    raise ConfigError(f"{source}: {found[0]} did not print the page: {reason}", hint)
