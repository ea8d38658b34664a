"""Client of the F28335's serial boot ROM: loads an image into RAM and starts it.

The host sends ``A``; the ROM measures the baud rate from it and echoes it. It then echoes each
octet of the image (TI SPRUI07). The ROM itself waits for ever, so the host has the timeouts.
Octets are sent in a window, since an echo through a USB adapter takes some 16 ms, and each echo is
compared before more is sent: after a wrong key the ROM would run the program in flash.

An echo confirms reception of an octet, not a write to RAM (the code security module silently drops
writes to protected RAM). Therefore the started program must finally identify itself, with a
firmware id that the image contains.

Written from the documents and tested with a simulated ROM only, never on hardware.
"""

from hbench.errors import DeviceError
from hbench.rig.flash.boot import BootRom
from hbench.rig.flash.f28335.boot_image import BootImage
from hbench.rig.flash.identity import NotInBoot
from hbench.rig.ports import Port

ECHO_WINDOW = 48  # octets without echo yet
_AUTOBAUD = b"A"
_AUTOBAUD_ATTEMPTS = 10
_AUTOBAUD_TIMEOUT_S = 0.5
_QUIET_S = 0.1  # after the first echo; a second one means that the ROM has a stray octet
_ECHO_TIMEOUT_S = 1.0

_RESET = "Set the boot pins GPIO87, 86, 85, 84 to 1110 (SCI-A), reset the board and try again"
_LINE = f"{_RESET}, at a lower --boot-baud if it happens again. Sending has stopped there."
_SILENT_PROGRAM = (
    "Check that the image is hbench firmware linked for RAM, stops the watchdog first and uses "
    "--baud. On a locked chip (CSM), writes to L0-L3 are lost in spite of the echo."
)


def send_image(port: Port, image: BootImage) -> None:
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
            f"{port.name}: answers the boot ROM's autobaud character 'A' with "
            f"{echo[:16].hex(' ').upper()}; expected its echo 41",
            f"{_RESET}, or lower --boot-baud.",
        )
    raise NotInBoot(
        f"{port.name}: no board: no echo of the boot ROM's autobaud character 'A' in "
        f"{_AUTOBAUD_ATTEMPTS} attempts, and no answer of a running hbench firmware",
        f"Check power, cable (crossed?) and port. {_RESET}.",
    )


def _send(port: Port, stream: bytes) -> None:
    """Send the octets of an image and compare their echoes.

    The echo of the last octet is awaited but not compared: after that octet the ROM jumps, and the
    program may reconfigure the serial line during the echo.
    """
    compared = len(stream) - 1
    sent = echoed = 0
    while echoed < compared:
        upto = min(echoed + ECHO_WINDOW, len(stream))
        if sent < upto:
            port.write(stream[sent:upto])
            sent = upto
        echo = port.read(_ECHO_TIMEOUT_S)
        if not echo:
            raise DeviceError(
                f"{port.name}: no echo at byte {echoed + 1} of {len(stream)} in "
                f"{_ECHO_TIMEOUT_S:g} s",
                f"Check the cable. {_LINE}",
            )
        _compare(port.name, stream, range(echoed, sent), echo[: compared - echoed])
        echoed += len(echo)
    if sent < len(stream):
        port.write(stream[sent:])
    if echoed == compared:
        port.read(_ECHO_TIMEOUT_S)


def _compare(name: str, stream: bytes, awaited: range, echo: bytes) -> None:
    """Raise ``DeviceError`` unless ``echo`` equals the octets ``awaited``, from the first on."""
    total = len(stream)
    for at, octet in enumerate(echo, awaited.start):
        if at not in awaited:
            raise DeviceError(
                f"{name}: received 0x{octet:02X} at byte {at + 1} of {total}, before it was sent",
                f"Disconnect other devices from the line. {_LINE}",
            )
        if octet != stream[at]:
            raise DeviceError(
                f"{name}: echo mismatch at byte {at + 1} of {total}: "
                f"sent 0x{stream[at]:02X}, got 0x{octet:02X}",
                f"Check the line for interference. {_LINE}",
            )


ROM = BootRom(send_image, f"{_RESET}.", _SILENT_PROGRAM)
