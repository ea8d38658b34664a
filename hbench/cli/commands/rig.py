"""``hbench rig``: serves the virtual rig to other programs."""

from enum import StrEnum
from pathlib import Path

import typer


class Speed(StrEnum):
    """How simulated time passes."""

    WALL = "1"
    MAX = "max"


def rig(
    bench: Path = typer.Option(None, help="Bench file; by default the one that 'init' writes."),
    plant: Path = typer.Option(None, help="Physics other than the bench's."),
    seed: int = typer.Option(1, help="Seed of noise and scatter."),
    emulate: Path = typer.Option(
        None,
        metavar="IMAGE",
        help="Run the firmware's image for the Cortex-M4 in an emulator (QEMU) instead.",
    ),
    socket: str = typer.Option(
        None, metavar="HOST:PORT", help="Serve on a TCP socket, not on a pseudo-terminal."
    ),
    baud: int = typer.Option(
        None, min=19200, help="Pace octets as a serial line of this rate does."
    ),
    speed: Speed = typer.Option(
        Speed.WALL,
        help="'1' follows the clock on the wall. 'max': time runs at full speed for half the "
        "bench's heartbeat limit after each word of the client, then waits for the next.",
    ),
) -> None:
    """Serve the virtual rig; print the name to give to 'hbench run --port'. Ctrl-C ends it.

    One client at a time. When it leaves, the rig goes on, and stops itself by its heartbeat limit.

    Example: hbench rig --socket localhost:7000
    """
    from importlib.resources import files

    from hbench import workflow

    try:
        workflow.serve_rig(
            bench or files("hbench.config") / "examples" / "bench-aau.yaml",
            plant=plant,
            seed=seed,
            image=emulate,
            address=socket,
            baud=baud,
            flat_out=speed is Speed.MAX,
            announce=_announce,
        )
    except KeyboardInterrupt:
        return


def _announce(name: str) -> None:
    print(name, flush=True)  # a pipe's reader waits for it
