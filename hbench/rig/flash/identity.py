"""After loading: who answers, and is it the firmware that was loaded?"""

from collections.abc import Callable

from hbench.errors import DeviceError
from hbench.rig.client import BoardClient, Identity, NoAnswer
from hbench.rig.ports import Port


def identify_loaded(
    port: Port, image: str, holds_text: Callable[[str], bool], silence_hint: str
) -> Identity:
    """Return who answers on ``port``, if its firmware id stands in the image; closes the port.

    ``holds_text`` tells whether a string stands in the image. Raises ``DeviceError``.
    """
    try:
        identity = BoardClient(port).identify()
    except NoAnswer as error:
        raise DeviceError(
            f"{port.name}: {image} is loaded, but no firmware identifies itself ({error.message})",
            silence_hint,
        ) from None
    finally:
        port.close()
    if not holds_text(identity.firmware):
        raise DeviceError(
            f"{port.name}: firmware '{identity.firmware}' answers, an id that does not stand in "
            f"{image}: the board runs another program than the one loaded",
            "Was the board reset into an older program? Check the boot pins and the image.",
        )
    return identity
