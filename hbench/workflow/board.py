"""The board: flashing, discovery, and the virtual rig in its place."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hbench.config.bench import Bench, Plant, parse_bench, parse_plant
from hbench.config.files.loading import read_yaml
from hbench.errors import ConfigError
from hbench.model.sensors import sensor_gains
from hbench.rig.client import Identity
from hbench.rig.discovery import ListedPort, ProbedPort, probe_ports, system_ports
from hbench.rig.flash import boot
from hbench.rig.flash.f28335 import boot_rom as f28335
from hbench.rig.flash.f28335.boot_image import BootImage
from hbench.rig.flash.image import Image, read_image
from hbench.rig.flash.programmer import flash_through
from hbench.rig.flash.stm32f4 import boot_rom as stm32f4
from hbench.rig.lines import open_line
from hbench.rig.ports import BAUD, Port, SerialPort
from hbench.rig.serve import FullSpeed, WallClock, serve
from hbench.units import from_si

_INTERVAL_OF_HEARTBEAT = 0.5  # at full speed; the rest is for the client's next message


@dataclass(frozen=True)
class Line:
    """Line to a board, or the virtual rig in its place."""

    port: str = "sim"  # a serial device, socket://host:port, or sim for the virtual rig
    baud: int | None = None  # None: 115200; on the virtual rig octets then take no time
    plant: Path | None = None  # file of another plant for the virtual rig
    seed: int = 1  # of the virtual rig's noise and scatter


def load_image(image_file: Path) -> Image:
    """Read and check a firmware image. Raises ``ConfigError``, ``DataError``."""
    return read_image(image_file)


def flash(
    image: Image, port: str, boot_baud: int, baud: int, firmware_port: str | None = None
) -> Identity:
    """Load ``image`` into the board at ``port``; return the board's identity.

    ``firmware_port`` is the line on which the firmware answers, if not that of the boot ROM. Raises
    ``ConfigError``, ``DeviceError``.
    """
    firmware = _line_to_board(firmware_port or port)
    if isinstance(image, BootImage):
        return boot.flash(f28335.ROM, image, _line_to_board(port), firmware, boot_baud, baud)
    return boot.flash(stm32f4.ROM, image, _line_to_board(port, "E"), firmware, boot_baud, baud)


def flash_through_programmer(image_file: Path, bench_file: Path, port: str, baud: int) -> Identity:
    """Flash with the external programmer of a bench file; return the board's identity.

    Raises ``ConfigError``, ``DeviceError``.
    """
    programmer = parse_bench(read_yaml(bench_file), str(bench_file)).programmer
    if programmer is None:
        raise ConfigError(
            f"{bench_file}: key 'programmer' is missing", "Add it with 'command' and 'timeout'."
        )
    line = _line_to_board(port)
    return flash_through(programmer.command, programmer.timeout, image_file, line, baud)


def _line_to_board(port: str, parity: str = "N") -> Callable[[int], Port]:
    if port == "sim":
        raise ConfigError(
            "--port sim: the virtual rig can't be flashed", "Give a serial device as --port."
        )
    return lambda rate: SerialPort(port, rate, parity)


def find_boards(names: Sequence[str]) -> tuple[ProbedPort, ...]:
    """Look for boards on the named ports, or on all ports of the system.

    Each port is opened, which may toggle its control lines.
    """
    return probe_ports([ListedPort(name, "") for name in names] or system_ports())


def serve_rig(
    bench_file: Path,
    *,
    plant: Path | None,
    seed: int,
    image: Path | None,
    address: str | None,
    full_speed: bool,
    announce: Callable[[str], None],
    baud: int | None = None,
) -> None:
    """Serve the virtual rig on a socket's address ``HOST:PORT``, or else a pseudo-terminal.

    ``baud`` is the simulated rate of the line. With an ``image``, its firmware runs in an emulator
    instead of the host library.

    ``announce`` gets the name of the port once the rig is ready; it then serves one client at a
    time, until the process is interrupted. Raises ``ConfigError``, ``DeviceError``.
    """
    bench_data = read_yaml(bench_file)
    bench = parse_bench(bench_data, str(bench_file))
    physics = physics_of(bench_data, plant)
    if image is None:
        rig = _virtual_rig(bench, physics, seed, baud)
    elif baud is None:
        rig = _emulated_rig(image, bench, physics, seed)
    else:
        raise ConfigError(
            "--baud: the emulated UART has no baud rate", "Remove --baud or --emulate."
        )
    try:
        line = open_line(address)
        try:
            rig.read(0.0)  # compiles before the first client
            interval_s = _INTERVAL_OF_HEARTBEAT * bench.limits.heartbeat
            announce(line.name)
            pace = FullSpeed(interval_s) if full_speed else WallClock()
            serve(rig, line, pace, lambda: False)
        finally:
            line.close()
    finally:
        rig.close()


def open_port(line: Line, bench: Bench, physics: Plant | None, seed: int) -> Port:
    """Open a line's port; ``sim`` is a virtual rig of ``bench``, with ``physics`` if given.

    ``seed`` is that of the session, which differs from the line's in a resumed campaign.
    """
    if line.port != "sim":
        return SerialPort(line.port, line.baud or BAUD)
    return _virtual_rig(bench, physics, seed, line.baud)


def physics_of(bench_data: dict[str, Any], plant: Path | None) -> Plant | None:
    """Read another plant's file for the virtual rig; None without a file."""
    if plant is None:
        return None
    physics = parse_plant(bench_data, read_yaml(plant), str(plant))
    check_effects(physics, plant)
    return physics


def check_effects(plant: Plant, file: Path) -> None:
    """Check the section ``effects`` against the catalogue. Raises ``ConfigError``."""
    if not plant.effects:
        return
    from hbench.model.build import plant_parameters

    try:
        plant_parameters(plant)
    except ConfigError as error:
        faults = (f"{file}: {fault}" for fault in error.message.splitlines())
        raise ConfigError("\n".join(faults), error.hint) from None


def check_sensors(bench: Bench, file: Path) -> None:
    """Check that the converters cover the sensors' working ranges. Raises ``ConfigError``."""
    top = 2**bench.sensors.adc.bits - 1
    for key, si, channel, sensor, unit in (
        ("limits.travel_max", bench.limits.travel_max, "x", "position", "mm"),
        ("supply.pressure", bench.supply.pressure, "p_s", "pressure", "bar"),
    ):
        gain, offset = sensor_gains(bench.sensors)[channel]
        largest = gain * top + offset
        if si >= largest:
            raise ConfigError(
                f"{file}: {key} = {from_si(si, unit):.6g} {unit}; limit of its sensor "
                f"{from_si(largest, unit):.4g} {unit}",
                f"Set sensors.{sensor} to the span and the amplifier of your sensor.",
            )


def _virtual_rig(bench: Bench, physics: Plant | None, seed: int, baud: int | None) -> Port:
    from hbench.rig.virtual import VirtualRig  # slow import: it compiles

    return VirtualRig(bench, physics, seed, baud or 0)


def _emulated_rig(image: Path, bench: Bench, physics: Plant | None, seed: int) -> Port:
    from hbench.rig.emulator import EmulatedFirmware
    from hbench.rig.stepped import SteppedRig

    return SteppedRig("emulated", EmulatedFirmware(image), bench, physics, seed)
