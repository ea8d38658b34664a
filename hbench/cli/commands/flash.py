"""``hbench flash``: loading of firmware into a board."""

from pathlib import Path

import typer

from hbench.cli.printed import AS_JSON, as_object
from hbench.rig.ports import BAUD

_BOOT_BAUD = 57_600
_MAX_BOOT_BAUD = 100_000  # above it the boot ROM's measurement is unreliable (TI SPRUI07)


def flash(
    image: Path = typer.Argument(
        help="Firmware: an .elf file (STM32F4), or the output of `hex2000 -boot -sci8 -a` (F28335)."
    ),
    port: str = typer.Option(..., help="Serial device, or socket://host:port."),
    boot_baud: int = typer.Option(
        _BOOT_BAUD, min=1200, max=_MAX_BOOT_BAUD, help="Baud rate of the boot ROM."
    ),
    baud: int = typer.Option(BAUD, min=1200, help="Baud rate of the loaded firmware."),
    bench: Path = typer.Option(
        None, help="Bench file whose 'programmer' flashes IMAGE, instead of the boot ROM."
    ),
    as_json: bool = AS_JSON,
) -> None:
    """Load IMAGE through the serial boot ROM of the board, and start it.

    An STM32F4's flash is written and read back: set BOOT0 high and reset the board first. An
    F28335's RAM is loaded, and the firmware must identify itself: set the boot pins to SCI-A. With
    --bench, the external programmer of the bench file flashes IMAGE, the linker's output, and the
    firmware must identify itself. Not yet tried on hardware.

    Example: hbench flash firmware.txt --port /dev/ttyUSB0
    """
    from hbench import workflow
    from hbench.rig.flash.stm32_image import Stm32Image

    if bench is not None:
        identity = workflow.flash_through_programmer(image, bench, port, baud)
    else:
        loaded = workflow.load_image(image)
        if isinstance(loaded, Stm32Image):
            chip = workflow.flash_stm32(loaded, port, boot_baud)
            if as_json:
                typer.echo(as_object("flash", port=port, chip=chip, octets=len(loaded.octets)))
            else:
                typer.echo(
                    f"{port}: {len(loaded.octets)} octets written to the {chip}, read back and "
                    "started; the firmware answers on USART2 (PA2, PA3): see `hbench ports`"
                )
            return
        typer.echo(
            f"{image}: {loaded.words} words in {len(loaded.blocks)} blocks, about "
            f"{10 * len(loaded.stream) / boot_baud:.0f} s at {boot_baud} baud",
            err=True,
        )
        identity = workflow.flash(loaded, port, boot_baud, baud)
    if as_json:
        answer = {"firmware": identity.firmware, "board": identity.board}
        typer.echo(as_object("flash", port=port, **answer))
    else:
        typer.echo(f"{port}: firmware '{identity.firmware}' runs on board '{identity.board}'")
