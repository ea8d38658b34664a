"""Flashing over JTAG by an external programmer, with the command of the bench file.

Written for tools such as TI's DSLite and OpenOCD, and tested with dummy programs; never run with
hardware.
"""

import os
import signal
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

from hbench.errors import ConfigError, DeviceError
from hbench.rig.client import Identity
from hbench.rig.flash.identity import verified_identity
from hbench.rig.ports import Port

IMAGE = "{image}"


def flash_through(
    command: Sequence[str],
    timeout_s: float,
    image: Path,
    open_port: Callable[[int], Port],
    baud: int,
) -> Identity:
    """Flash ``image`` (the linker's output) with ``command``; return the identity at ``baud``.

    The image must contain the firmware's id and the board's name, one character per octet, or per
    16-bit word with the low octet first, as in the linker's files for the C28x. Raises
    ``ConfigError``, ``DeviceError``.
    """
    try:
        content = image.read_bytes()
    except OSError as error:
        raise ConfigError(f"{image}: {error.strerror or error}", "Check the path.") from None
    run_programmer(command, timeout_s, image)
    return verified_identity(
        open_port(baud),
        str(image),
        lambda text: text.encode() in content or text.encode("utf-16-le") in content,
        "Let the programmer start the program; on an F28335, set the boot pins to flash (1111).",
    )


def run_programmer(command: Sequence[str], timeout_s: float, image: Path) -> Path:
    """Run ``command`` with ``{image}`` replaced; return the file with its output.

    The file is written beside the image in any case. Raises ``ConfigError`` if the program can't be
    started, ``DeviceError`` if it fails or takes longer than ``timeout_s``.
    """
    arguments = [argument.replace(IMAGE, str(image)) for argument in command]
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
            "Check 'programmer.command' in the bench file, and that the image's folder is "
            "writable for the log.",
        ) from None
    try:
        code = process.wait(timeout_s)
    except subprocess.TimeoutExpired:
        raise DeviceError(
            f"programmer {arguments[0]}: timeout after {timeout_s:g} s{_last_line(log)}",
            f"Read its output in {log}.",
        ) from None
    finally:
        _end(process)
    if code != 0:
        raise DeviceError(
            f"programmer {arguments[0]}: failed with code {code}{_last_line(log)}",
            f"Read its output in {log}.",
        )
    return log


def _end(process: subprocess.Popen) -> None:
    """Kill a programmer that still runs, and its child processes."""
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
