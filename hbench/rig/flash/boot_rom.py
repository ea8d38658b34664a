"""The host's end of the F28335's serial boot ROM: loads an image into RAM and starts it.

The host sends ``A``; the ROM measures the baud rate from it and echoes it. From then on it echoes
each octet of the image (TI SPRUI07). The ROM itself waits for ever, so the timeouts are here.
Octets go out in a window, since an echo through a USB adapter takes some 16 ms, and each echo is
compared before more is sent: at a wrong key the ROM would run whatever the flash holds.

An echo shows that the ROM took an octet, not that its word reached RAM (the code security module
drops writes to protected RAM silently). So in the end the started program must identify itself,
with an id that stands in the image.

Written from the documents and run against a stand-in of the ROM only, never on hardware.
"""

from collections.abc import Callable

from hbench.errors import DeviceError
from hbench.rig.client import BoardClient, Identity, NoAnswer
from hbench.rig.flash.boot_image import BootImage
from hbench.rig.flash.identity import identify_loaded
from hbench.rig.ports import Port

WINDOW = 48  # octets on the way
_AUTOBAUD = b"A"
_AUTOBAUD_ATTEMPTS = 10
_AUTOBAUD_TIMEOUT_S = 0.5
_QUIET_S = 0.1  # after the first echo: were there more than one, the ROM has a stray octet
_ECHO_TIMEOUT_S = 1.0

_RESET = "Set the boot pins GPIO87, 86, 85, 84 to 1110 (SCI-A), reset the board and try again"
_LINE = f"{_RESET}, at a lower --boot-baud if it comes back. Nothing was sent after it."
_SILENT_PROGRAM = (
    "Is it hbench firmware linked for RAM, that stops the watchdog first and talks at --baud? "
    "Where the chip is locked (CSM), writes to L0-L3 are lost in spite of the echo."
)


class NotInBoot(DeviceError):
    """What is on the line, if anything, is not the boot ROM waiting for its ``A``."""


def flash(
    image: BootImage, open_port: Callable[[int], Port], boot_baud: int, baud: int
) -> Identity:
    """Load ``image`` at ``boot_baud``, start it, and return who then answers at ``baud``.

    ``open_port`` opens the line at a rate. Raises ``DeviceError``.
    """
    port = open_port(boot_baud)
    try:
        load(port, image)
    except NotInBoot as error:
        port.close()
        raise _told_by_program(open_port, baud) or error from None
    finally:
        port.close()
    return identify_loaded(open_port(baud), image.name, image.holds_text, _SILENT_PROGRAM)


def load(port: Port, image: BootImage) -> None:
    """Load ``image``; the boot ROM then jumps to its entry. Raises ``DeviceError``."""
    _autobaud(port)
    _send(port, image.stream)


def _autobaud(port: Port) -> None:
    for _ in range(_AUTOBAUD_ATTEMPTS):
        port.write(_AUTOBAUD)
        echo = port.read(_AUTOBAUD_TIMEOUT_S)
        if not echo:
            continue
        echo += port.read(_QUIET_S)
        if echo == _AUTOBAUD:
            return
        raise NotInBoot(
            f"{port.name}: answers the 'A' of the boot ROM's autobaud with "
            f"{echo[:16].hex(' ').upper()}, not with its echo 41",
            f"A program runs, or the rate is too high. {_RESET}.",
        )
    raise NotInBoot(
        f"{port.name}: no board: no echo to {_AUTOBAUD_ATTEMPTS} times the 'A' of the boot ROM's "
        "autobaud, nor an answer of a running hbench firmware",
        f"Check power, cable (crossed?) and port. {_RESET}.",
    )


def _send(port: Port, stream: bytes) -> None:
    """Send the octets of an image and compare their echoes.

    The echo of the last one is waited for but not judged: with that octet the ROM jumps, and the
    program may set up the serial line anew while the echo is still going out.
    """
    judged = len(stream) - 1
    sent = echoed = 0
    while echoed < judged:
        upto = min(echoed + WINDOW, len(stream))
        if sent < upto:
            port.write(stream[sent:upto])
            sent = upto
        echo = port.read(_ECHO_TIMEOUT_S)
        if not echo:
            raise DeviceError(
                f"{port.name}: silence at byte {echoed + 1} of {len(stream)}: no echo in "
                f"{_ECHO_TIMEOUT_S:g} s",
                f"Was the board reset, or the cable pulled? {_LINE}",
            )
        _compare(port.name, stream, range(echoed, sent), echo[: judged - echoed])
        echoed += len(echo)
    if sent < len(stream):
        port.write(stream[sent:])
    if echoed == judged:
        port.read(_ECHO_TIMEOUT_S)


def _compare(name: str, stream: bytes, on_the_way: range, echo: bytes) -> None:
    """Raise ``DeviceError`` unless ``echo`` is what is on the way, from its first octet on."""
    total = len(stream)
    for at, got in enumerate(echo, on_the_way.start):
        if at not in on_the_way:
            raise DeviceError(
                f"{name}: 0x{got:02X} came at byte {at + 1} of {total}, before it was sent",
                f"Something else talks on the line. {_LINE}",
            )
        if got != stream[at]:
            raise DeviceError(
                f"{name}: echo mismatch at byte {at + 1} of {total}: "
                f"sent 0x{stream[at]:02X}, got 0x{got:02X}",
                f"The line is disturbed or the rate too high. {_LINE}",
            )


def _told_by_program(open_port: Callable[[int], Port], baud: int) -> DeviceError | None:
    """Ask for a running firmware where the boot ROM is silent: then the boot pins are wrong."""
    port = open_port(baud)
    try:
        firmware = BoardClient(port).identify().firmware
        running = f"firmware '{firmware}' is running and answers"
    except NoAnswer:
        return None
    except DeviceError as error:
        running = error.message.removeprefix(f"{port.name}: ")
    finally:
        port.close()
    return NotInBoot(
        f"{port.name}: wrong boot pins or no reset: not the boot ROM but a program has the line: "
        f"{running}",
        f"{_RESET}.",
    )
