"""The board before and after flashing: the right boot ROM, then the firmware of the image."""

from collections.abc import Callable

from hbench.errors import DeviceError
from hbench.rig.client import BoardClient, Identity, NoAnswer
from hbench.rig.ports import Port


class NotInBoot(DeviceError):
    """Absence of a boot ROM that waits for the host."""


def verified_identity(
    port: Port, image: str, contains_text: Callable[[str], bool], silence_hint: str
) -> Identity:
    """Return the identity of the board on ``port``, and close the port.

    ``contains_text`` returns whether the image contains a string. Raises ``DeviceError`` without
    an answer, or if the image does not contain the firmware's id and the board's name.
    """
    try:
        identity = BoardClient(port).identify()
    except NoAnswer as error:
        raise DeviceError(
            f"{port.name}: {image} is loaded, but no firmware answers ({error.message})",
            silence_hint,
        ) from None
    finally:
        port.close()
    if not contains_text(identity.firmware):
        raise DeviceError(
            f"{port.name}: firmware id '{identity.firmware}' not found in {image}: the board runs "
            "another program",
            "Check the boot pins and the image; a reset can start an older program.",
        )
    if not contains_text(identity.board):
        raise DeviceError(
            f"{port.name}: board '{identity.board}' not found in {image}: the image is for another "
            "board",
            "Give the image of this board.",
        )
    return identity


def running_firmware_error(port: Port, reset_hint: str) -> NotInBoot | None:
    """Return the error of wrong boot pins if a firmware runs instead of the boot ROM.

    Closes the port.
    """
    try:
        firmware = BoardClient(port).identify().firmware
        answer = f"firmware '{firmware}' is running and answers"
    except NoAnswer:
        return None
    except DeviceError as error:
        answer = error.message.removeprefix(f"{port.name}: ")
    finally:
        port.close()
    return NotInBoot(
        f"{port.name}: wrong boot pins or no reset: a program runs instead of the boot ROM: "
        f"{answer}",
        reset_hint,
    )
