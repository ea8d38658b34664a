"""Verification after flashing: the answering firmware must be the one in the image."""

from collections.abc import Callable

from hbench.errors import DeviceError
from hbench.rig.client import BoardClient, Identity, NoAnswer
from hbench.rig.ports import Port


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
            "Give an image that was built for this board.",
        )
    return identity
