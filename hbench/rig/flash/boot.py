"""Loading through a boot ROM of any chip: image, start, identity of the firmware."""

from collections.abc import Callable
from typing import Any, NamedTuple

from hbench.rig.client import Identity
from hbench.rig.flash.identity import NotInBoot, running_firmware_error, verified_identity
from hbench.rig.flash.image import Image
from hbench.rig.ports import Port


class BootRom(NamedTuple):
    """A boot ROM: what loads and starts an image, and what the user can do."""

    send_image: Callable[[Port, Any], None]
    reset_hint: str
    silence_hint: str  # where the started program does not answer


def flash(
    rom: BootRom,
    image: Image,
    open_boot: Callable[[int], Port],
    open_firmware: Callable[[int], Port],
    boot_baud: int,
    baud: int,
) -> Identity:
    """Load ``image`` at ``boot_baud``, start it, and return its identity, read at ``baud``.

    The functions open the ROM's line and the firmware's at a rate. Raises ``DeviceError``.
    """
    port = open_boot(boot_baud)
    try:
        rom.send_image(port, image)
    except NotInBoot as error:
        port.close()
        raise running_firmware_error(open_firmware(baud), rom.reset_hint) or error from None
    finally:
        port.close()
    return verified_identity(open_firmware(baud), image.name, image.contains_text, rom.silence_hint)
