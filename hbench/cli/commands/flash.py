"""``hbench flash``: loading of firmware into a board."""

from pathlib import Path

import typer

from hbench.cli.printed import AS_JSON, as_object
from hbench.rig.ports import BAUD

_BOOT_BAUD = 57_600
_MAX_BOOT_BAUD = 100_000  # above it the boot ROM's measurement is unreliable (TI SPRUI07)


def flash(
    image: Path = typer.Argument(help="Firmware; for RAM, the output of `hex2000 -boot -sci8 -a`."),
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
    """Load IMAGE into an F28335's RAM through its serial boot ROM, start it and identify it.

    Set the boot pins to SCI-A and reset the board first. With --bench, the external programmer of
    the bench file flashes IMAGE, the linker's output. Not yet tried on hardware.

    Example: hbench flash firmware.txt --port /dev/ttyUSB0
    """
    from hbench import workflow

    if bench is not None:
        identity = workflow.flash_through_programmer(image, bench, port, baud)
    else:
        loaded = workflow.load_image(image)
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
