"""Flash over JTAG: an outside programmer, called as the bench file says.

Written for tools such as TI's DSLite and tested with stand-ins; never run with hardware.
"""

import os
import signal
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

from hbench.errors import ConfigError, DeviceError
from hbench.rig.client import Identity
from hbench.rig.flash.identity import identify_loaded
from hbench.rig.ports import Port

IMAGE = "{image}"


def flash_through(
    command: Sequence[str],
    timeout_s: float,
    image: Path,
    open_port: Callable[[int], Port],
    baud: int,
) -> Identity:
    """Let ``command`` flash ``image`` (the linker's output); return who then answers at ``baud``.

    The firmware's id must stand in the image, a character a 16-bit word with the low octet
    first, as the linker's files for the C28x hold text. Raises ``ConfigError``, ``DeviceError``.
    """
    try:
        content = image.read_bytes()
    except OSError as error:
        raise ConfigError(f"{image}: {error.strerror or error}", "Check the path.") from None
    run_programmer(command, timeout_s, image)
    return identify_loaded(
        open_port(baud),
        str(image),
        lambda text: text.encode("utf-16-le") in content,
        "Does the programmer leave the board running, with the boot pins at flash (1111)?",
    )


def run_programmer(command: Sequence[str], timeout_s: float, image: Path) -> Path:
    """Run ``command`` with ``{image}`` replaced; return the file that keeps its output.

    The file stands beside the image, whatever the outcome. Raises ``ConfigError`` where the
    program can't be started, ``DeviceError`` where it fails or takes longer than ``timeout_s``.
    """
    arguments = [part.replace(IMAGE, str(image)) for part in command]
    log = image.with_name(f"{image.name}.programmer.log")
    try:
        with log.open("wb") as output:
            process = subprocess.Popen(
                arguments,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
    except OSError as error:
        raise ConfigError(
            f"{error.filename or arguments[0]}: {error.strerror or error}",
            "Check 'programmer.command' of the bench file, and that the image's folder is "
            "writable for the log.",
        ) from None
    try:
        code = process.wait(timeout_s)
    except subprocess.TimeoutExpired:
        raise DeviceError(
            f"programmer {arguments[0]}: not done after {timeout_s:g} s{_last_line(log)}",
            f"Its output is in {log}.",
        ) from None
    finally:
        _end(process)
    if code != 0:
        raise DeviceError(
            f"programmer {arguments[0]}: failed with code {code}{_last_line(log)}",
            f"Its output is in {log}.",
        )
    return log


def _end(process: subprocess.Popen) -> None:
    """End a programmer that still runs, and what it has started."""
    if process.poll() is None:
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
        process.wait()


def _last_line(log: Path) -> str:
    lines = log.read_text(encoding="utf-8", errors="replace").split("\n")
    last = next((line.strip() for line in reversed(lines) if line.strip()), "")
    return f": {last[:120]}" if last else ""
