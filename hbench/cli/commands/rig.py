"""``hbench rig``: server of the virtual rig for other programs."""

from enum import StrEnum
from pathlib import Path

import typer


class RigSpeed(StrEnum):
    """Speed of simulated time."""

    WALL = "1"
    MAX = "max"


def rig(
    bench: Path = typer.Option(None, help="Bench file; by default that of 'hbench init'."),
    plant: Path = typer.Option(None, help="Plant file with physics that differs from the bench's."),
    seed: int = typer.Option(1, help="Seed of noise and scatter."),
    emulate: Path = typer.Option(
        None,
        metavar="IMAGE",
        help="Firmware image for the Cortex-M4, to run in an emulator (QEMU).",
    ),
    socket: str = typer.Option(
        None, metavar="HOST:PORT", help="TCP socket to serve on, instead of a pseudo-terminal."
    ),
    baud: int = typer.Option(
        None, min=19200, help="Simulated baud rate of the line; by default octets take no time."
    ),
    speed: RigSpeed = typer.Option(
        RigSpeed.WALL,
        help="'1': simulated time follows wall time. 'max': it runs at full speed for half the "
        "bench's heartbeat limit after each message of the client, then waits for the next.",
    ),
) -> None:
    """Serve the virtual rig; print the name for 'hbench run --port'. Ctrl-C ends it.

    It serves one client at a time. Without a client, the rig runs on and stops its motion by its
    heartbeat limit.

    Example: hbench rig --socket localhost:7000
    """
    from hbench import workflow
    from hbench.config.files.examples import example_path

    try:
        workflow.serve_rig(
            bench or example_path("bench-aau.yaml"),
            plant=plant,
            seed=seed,
            image=emulate,
            address=socket,
            baud=baud,
            full_speed=speed is RigSpeed.MAX,
            announce=_announce,
        )
    except KeyboardInterrupt:
        return


def _announce(name: str) -> None:
    print(name, flush=True)  # for a reader of a pipe
