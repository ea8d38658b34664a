"""``hbench flash``: loading of firmware into a board."""

from pathlib import Path

import typer

from hbench.cli.printed import AS_JSON, as_object
from hbench.rig.ports import BAUD

_BOOT_BAUD = 57_600
_MAX_BOOT_BAUD = 100_000  # above it the boot ROM's measurement is unreliable (TI SPRUI07)


def flash(
    image: Path = typer.Argument(
        help="Firmware: the ELF file for an STM32F4; for an F28335's RAM, the output of "
        "`hex2000 -boot -sci8 -a`."
    ),
    port: str = typer.Option(..., help="Serial device, or socket://host:port."),
    firmware_port: str = typer.Option(
        None, help="Serial device on which the firmware answers, if not --port."
    ),
    boot_baud: int = typer.Option(
        _BOOT_BAUD, min=1200, max=_MAX_BOOT_BAUD, help="Baud rate of the boot ROM."
    ),
    baud: int = typer.Option(BAUD, min=1200, help="Baud rate of the loaded firmware."),
    bench: Path = typer.Option(
        None, help="Bench file whose 'programmer' flashes IMAGE, instead of the boot ROM."
    ),
    as_json: bool = AS_JSON,
) -> None:
    """Load IMAGE through the serial boot ROM of an STM32F4 or F28335, start and identify it.

    Set the boot pins and reset the board first. With --bench, the external programmer of the bench
    file flashes IMAGE, the linker's output. Not yet tried on hardware.

    Example: hbench flash hbench-stm32f4.elf --port /dev/ttyUSB0 --firmware-port /dev/ttyACM0
    """
    from hbench import workflow

    if bench is not None:
        identity = workflow.flash_through_programmer(image, bench, firmware_port or port, baud)
    else:
        loaded = workflow.load_image(image)
        typer.echo(
            f"{image}: {loaded.size}, about {loaded.seconds(boot_baud):.0f} s at {boot_baud} baud",
            err=True,
        )
        identity = workflow.flash(loaded, port, boot_baud, baud, firmware_port)
    line = firmware_port or port
    if as_json:
        answer = {"firmware": identity.firmware, "board": identity.board}
        typer.echo(as_object("flash", port=line, **answer))
    else:
        typer.echo(f"{line}: firmware '{identity.firmware}' runs on board '{identity.board}'")
