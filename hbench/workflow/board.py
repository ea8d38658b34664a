"""The board itself: flashed, found, or stood in for by the virtual rig."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from hbench.config.bench import Bench, Plant, parse_bench, parse_plant
from hbench.config.files.loading import read_yaml
from hbench.errors import ConfigError
from hbench.model.sensors import sensor_gains
from hbench.rig.client import Identity
from hbench.rig.discovery import Found, Listed, look, system_ports
from hbench.rig.flash import boot_rom
from hbench.rig.flash.boot_image import BootImage, read_boot_image
from hbench.rig.flash.programmer import flash_through
from hbench.rig.lines import open_line
from hbench.rig.ports import BAUD, Port, SerialPort
from hbench.rig.serve import FlatOut, WallClock, serve
from hbench.units import from_si

_SHARE_OF_HEARTBEAT = 0.5  # of a rig flat out: the rest is for the client's next word


def load_image(image_file: Path) -> BootImage:
    """Read and check a firmware image. Raises ``ConfigError``, ``DataError``."""
    return read_boot_image(image_file)


def flash(image: BootImage, port: str, boot_baud: int, baud: int) -> Identity:
    """Load ``image`` into the board at ``port``; return the firmware that then answers.

    Raises ``ConfigError``, ``DeviceError``.
    """
    return boot_rom.flash(image, _line_to_board(port), boot_baud, baud)


def flash_through_programmer(image_file: Path, bench_file: Path, port: str, baud: int) -> Identity:
    """Flash with the outside programmer of a bench file; return the firmware that then answers.

    Raises ``ConfigError``, ``DeviceError``.
    """
    programmer = parse_bench(read_yaml(bench_file), str(bench_file)).programmer
    if programmer is None:
        raise ConfigError(
            f"{bench_file}: names no programmer", "Add 'programmer' with 'command' and 'timeout'."
        )
    line = _line_to_board(port)
    return flash_through(programmer.command, programmer.timeout, image_file, line, baud)


def _line_to_board(port: str) -> Callable[[int], Port]:
    if port == "sim":
        raise ConfigError("The virtual rig can't be flashed", "Give --port a serial device.")
    return lambda rate: SerialPort(port, rate)


def find_boards(names: Sequence[str]) -> tuple[Found, ...]:
    """Look for boards on the ports named, or on all that the system lists.

    It opens each port, which may toggle its control lines.
    """
    return look([Listed(name, "") for name in names] or system_ports())


def serve_rig(
    bench_file: Path,
    *,
    plant: Path | None,
    seed: int,
    image: Path | None,
    address: str | None,
    flat_out: bool,
    announce: Callable[[str], None],
    baud: int | None = None,
) -> None:
    """Serve the virtual rig on a socket's address ``HOST:PORT``, or else a pseudo-terminal.

    With ``baud`` its octets take their time on the line, as a real board's do. Where there is an
    ``image``, its firmware runs in an emulator, instead of the host's library.

    ``announce`` is given the name of the port once the rig is ready for clients; they come and
    go, one at a time, until the process is interrupted. Raises ``ConfigError``, ``DeviceError``.
    """
    bench_data = read_yaml(bench_file)
    bench = parse_bench(bench_data, str(bench_file))
    physics = physics_of(bench_data, plant)
    if image is None:
        rig = _virtual_rig(bench, physics, seed, baud)
    elif baud is None:
        rig = _emulated_rig(image, bench, physics, seed)
    else:
        raise ConfigError("--baud is not for --emulate: the emulated UART has no baud rate")
    try:
        line = open_line(address)
        try:
            rig.read(0.0)  # compiles, before a client waits for it
            share_s = _SHARE_OF_HEARTBEAT * bench.limits.heartbeat
            announce(line.name)
            serve(rig, line, FlatOut(share_s) if flat_out else WallClock(), lambda: False)
        finally:
            line.close()
    finally:
        rig.close()


def open_port(name: str, bench: Bench, physics: Plant | None, seed: int, baud: int | None) -> Port:
    """Open the port of a name; ``sim`` is a virtual rig of ``bench`` with its own ``physics``."""
    if name != "sim":
        return SerialPort(name, baud or BAUD)
    return _virtual_rig(bench, physics, seed, baud)


def physics_of(bench_data: dict[str, Any], plant: Path | None) -> Plant | None:
    """Read the file of another plant for the virtual rig, if one is named."""
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
    """Check that no sensor is at its converter's end in use. Raises ``ConfigError``."""
    top = 2**bench.sensors.adc.bits - 1
    for key, si, channel, sensor, unit in (
        ("limits.travel_max", bench.limits.travel_max, "x", "position", "mm"),
        ("supply.pressure", bench.supply.pressure, "p_s", "pressure", "bar"),
    ):
        gain, offset = sensor_gains(bench.sensors)[channel]
        most = gain * top + offset
        if si >= most:
            raise ConfigError(
                f"{file}: {key} = {from_si(si, unit):.6g} {unit} is beyond what its sensor shows, "
                f"{from_si(most, unit):.4g} {unit}",
                f"Give sensors.{sensor} the span and the amplifier of yours.",
            )


def _virtual_rig(bench: Bench, physics: Plant | None, seed: int, baud: int | None) -> Port:
    from hbench.rig.virtual import VirtualRig  # compiles; only who simulates waits for it

    return VirtualRig(bench, physics, seed, baud or 0)


def _emulated_rig(image: Path, bench: Bench, physics: Plant | None, seed: int) -> Port:
    from hbench.rig.emulator import EmulatedFirmware
    from hbench.rig.stepped import SteppedRig

    return SteppedRig("emulated", EmulatedFirmware(image), bench, physics, seed)
