"""The flow, one function an arrow: schedule -> campaign -> results -> report."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from hbench.analysis.average import curves
from hbench.analysis.bands import bands
from hbench.analysis.calibrate import calibrate
from hbench.analysis.efficiency import efficiency
from hbench.analysis.fit import fits, left_out
from hbench.analysis.screen import screen
from hbench.config.bench import Bench, Plant, parse_bench, parse_plant
from hbench.config.loading import file_sha256, read_yaml
from hbench.config.schedule import Schedule, parse_schedule
from hbench.errors import ConfigError, DataError
from hbench.experiment.header import campaign_header, refuse_another, session_seed, software
from hbench.experiment.parts import over_all_parts, parts
from hbench.experiment.plan import Plan, estimate_seconds, plan_runs
from hbench.experiment.runner import Progress, bring_to_rest, run_campaign
from hbench.model.parameters import plant_parameters
from hbench.protocol.dictionary import RECORD
from hbench.records import Design, Phenomenon, Results, RunPlan
from hbench.report.design_page import design_page
from hbench.report.design_text import design_json
from hbench.report.draw_control import draw_design
from hbench.report.draw_phenomena import draw_phenomenon
from hbench.report.figures import draw_all
from hbench.report.page import page_html
from hbench.report.phenomenon_page import phenomenon_page
from hbench.report.phenomenon_text import panel_csv
from hbench.report.tables import TABLES
from hbench.rig import boot_rom
from hbench.rig.boot_image import BootImage, read_boot_image
from hbench.rig.client import BoardClient, Identity
from hbench.rig.find import Found, Listed, look, system_ports
from hbench.rig.lines import open_line
from hbench.rig.ports import BAUD, Port, SerialPort
from hbench.rig.programmer import flash_through
from hbench.rig.serve import FlatOut, WallClock, serve
from hbench.store.atomic import write_atomic
from hbench.store.campaign import Campaign, CampaignWriter, load_campaign, write_results
from hbench.store.foreign import ImportSummary, import_folder
from hbench.store.hold import only_host

_SHARE_OF_HEARTBEAT = 0.5  # of a rig flat out: the rest is for the client's next word


@dataclass(frozen=True)
class Experiment:
    """A checked schedule with its bench, as read and as written."""

    schedule: Schedule
    bench: Bench
    plan: Plan  # before anything is measured
    files: dict[str, dict[str, Any]]  # bench, schedule: {file, content}

    @property
    def plans(self) -> tuple[RunPlan, ...]:
        """All runs; with adaptive velocities the most that there can be."""
        return self.plan.runs + self.plan.rest


@dataclass(frozen=True)
class Estimate:
    """What a schedule will take."""

    runs: int
    seconds: float  # on the bench
    bytes: int  # of raw logs
    at_most: bool  # adaptive velocities: how many runs it takes shows while they are made


@dataclass(frozen=True)
class Measured:
    """What ``measure`` did."""

    runs: int
    seconds: float  # on the bench's clock


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


def load_experiment(schedule_file: Path, bench_file: Path | None) -> Experiment:
    """Read and check a schedule and its bench. Raises ``ConfigError``."""
    schedule_data = read_yaml(schedule_file)
    schedule = parse_schedule(schedule_data, str(schedule_file))
    if bench_file is None:
        if schedule.bench is None:
            raise ConfigError(f"{schedule_file}: names no bench", "Add 'bench: FILE' or --bench.")
        bench_file = schedule_file.parent / schedule.bench
    bench_data = read_yaml(bench_file)
    bench = parse_bench(bench_data, str(bench_file))
    return Experiment(
        schedule=schedule,
        bench=bench,
        plan=plan_runs(schedule, bench, str(schedule_file)),
        files={
            "bench": {"file": bench_file.name, "content": bench_data},
            "schedule": {"file": schedule_file.name, "content": schedule_data},
        },
    )


def estimate(experiment: Experiment) -> Estimate:
    """Return the runs, the time on the bench and the size of the raw logs."""
    plans, rate = experiment.plans, experiment.bench.controllers.log_rate
    words = sum(plan.motion.duration_s for plan in plans) * rate * len(RECORD)
    seconds = estimate_seconds(plans, experiment.bench)
    return Estimate(len(plans), seconds, round(5 * words), bool(experiment.plan.rest))


def measure(
    experiment: Experiment,
    folder: Path,
    *,
    port: str,
    plant: Path | None,
    seed: int,
    resume: bool,
    clock: Callable[[], datetime],
    report: Callable[[Progress], None],
    baud: int | None = None,
    take_over: bool = False,
) -> Measured:
    """Make the runs on ``port`` and journal them in the campaign ``folder``.

    A board that still runs, or that has stopped itself, is taken over only with ``take_over`` or
    ``resume``. ``baud`` is the line's rate: by default 115200, and on the virtual rig octets take
    no time. ``plant`` is the file of another plant for the virtual rig; the campaign keeps only its
    hash.
    Raises ``ConfigError``, ``DeviceError``, ``DataError``.
    """
    if plant is not None and port != "sim":
        raise ConfigError("--plant is for the virtual rig, and --port is not 'sim'")
    bench = experiment.bench
    with only_host(folder):
        campaign = load_campaign(folder) if resume else None
        line = _open_port(experiment, port, plant, session_seed(seed, campaign), baud)
        try:
            client = BoardClient(line)
            identity = client.identify()
            bring_to_rest(client, resume or take_over)  # before there is a folder
            header = campaign_header(
                experiment.schedule.name, experiment.files, identity, bench, port, clock()
            )
            if port == "sim":  # a rig that is served elsewhere keeps its seed and plant to itself
                header["seed"] = seed
            if plant is not None:
                header["plant"] = {"sha256": file_sha256(plant)}
            if campaign is not None:
                refuse_another(campaign, header)
                journal = CampaignWriter.resume(folder)
                done = {plan for plan in campaign.plans if plan.run in campaign.done}
            else:
                journal = CampaignWriter.create(folder, header)
                done = set()
            start, made = line.now(), 0
            for part in parts(experiment.plan, experiment.schedule, bench, folder, done):
                progress = over_all_parts(report, made, part)
                first = resume and not made
                run_campaign(part.runs, bench, client, journal, clock, progress, first)
                made += len(part.runs)
            return Measured(made, line.now() - start)
        finally:
            line.close()


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
    physics = _physics(bench_data, plant)
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


def find_boards(names: Sequence[str]) -> tuple[Found, ...]:
    """Look for boards on the ports named, or on all that the system lists.

    It opens each port, which may toggle its control lines.
    """
    return look([Listed(name, "") for name in names] or system_ports())


def import_runs(
    source: Path, folder: Path, map_file: Path | None, clock: Callable[[], datetime]
) -> ImportSummary:
    """Bring another bench's logs in as a campaign. Raises ``ConfigError``, ``DataError``."""
    return import_folder(source, folder, map_file, software(), clock())


def analyze(folder: Path) -> Results:
    """Screen, average and fit a campaign; write its tables to ``results/``."""
    results = _derive(load_campaign(folder))
    write_results(folder, _tables(results))
    return results


def report(folder: Path) -> Results:
    """Analyze a campaign and write tables, figures and the page to ``results/``."""
    results = _derive(load_campaign(folder))
    drawings = draw_all(results)
    figures = {f"figures/{d.name}.svg": d.svg for d in drawings}
    figures |= {f"figures/{d.name}.png": d.png for d in drawings}
    page = {"report.html": page_html(results, drawings).encode()}
    write_results(folder, _tables(results) | figures | page)
    return results


def design(
    bench_file: Path,
    *,
    point: Mapping[str, float],
    source: bool,
    ratio: float | None,
    report: Callable[[Progress], None],
) -> Design:
    """Judge the controllers of a bench at an operating point, and propose others.

    ``point`` may give v_m_s, f_load_n, x_m and p_lr_pa; the rest is the middle of the bench's
    range. With ``source`` the source's numbers are compared, and without a ``point`` its own
    operating point is taken. With ``ratio``, of neighbouring bandwidths, gains are proposed, and
    checked with the firmware. Raises ``ConfigError``, ``ConvergenceError``.
    """
    from hbench.control.grid import operating_point  # scipy.signal; only who designs waits for it
    from hbench.control.loops import design_at
    from hbench.control.source import POINT, reproduce
    from hbench.experiment.verify import proposal

    bench = parse_bench(read_yaml(bench_file), str(bench_file))
    control, par = bench.controllers, plant_parameters(bench)
    loops = control.velocity, control.rod_pressure, control.piston_pressure
    nominal = operating_point(bench, par, point)
    found = design_at(
        bench.name,
        par,
        POINT if source and not point else nominal,
        [(loop.gain, loop.time_constant) for loop in loops],
        (control.velocity_filter, control.pressure_filter),
        reproduce(par) if source else (),
    )
    if ratio is None:
        return found
    return replace(found, proposal=proposal(bench, ratio, nominal, report))


def write_design(folder: Path, found: Design) -> None:
    """Write a design's figures, its numbers as JSON and its page."""
    drawings = draw_design(found)
    files = {f"figures/{d.name}.svg": d.svg for d in drawings}
    files |= {f"figures/{d.name}.png": d.png for d in drawings}
    files["design.json"] = design_json(found).encode()
    files["design.html"] = design_page(found, drawings).encode()
    _write(folder, files)


def phenomena() -> tuple[str, ...]:
    """Return the names of what ``simulate`` knows."""
    from hbench.experiment.phenomena import PHENOMENA  # compiles

    return tuple(PHENOMENA)


def simulate(name: str, bench_file: Path) -> Phenomenon:
    """Simulate a phenomenon by its name, on a bench where it needs one.

    Raises ``ConfigError``.
    """
    from hbench.experiment.phenomena import PHENOMENA

    if name not in PHENOMENA:
        raise ConfigError(f"unknown phenomenon {name!r}", f"There are: {', '.join(PHENOMENA)}.")
    return PHENOMENA[name](read_yaml(bench_file))


def write_phenomenon(folder: Path, phenomenon: Phenomenon) -> None:
    """Write a phenomenon's page, its figures, and the data of each as CSV."""
    drawings = draw_phenomenon(phenomenon)
    page = phenomenon_page(phenomenon, drawings, version("hbench"))
    files = {f"{phenomenon.name}.html": page.encode()}
    for drawing, panel in zip(drawings, phenomenon.panels, strict=True):
        files[f"figures/{drawing.name}.svg"] = drawing.svg
        files[f"figures/{drawing.name}.png"] = drawing.png
        files[f"figures/{drawing.name}.csv"] = panel_csv(panel).encode()
    _write(folder, files)


def _write(folder: Path, files: Mapping[str, bytes]) -> None:
    for name, data in files.items():
        write_atomic(folder / name, data)


def _derive(campaign: Campaign) -> Results:
    bench, rules = campaign.bench(), campaign.screening()
    if campaign.imported:
        runs = campaign.runs()
    else:
        runs = (calibrate(raw, bench) for raw in campaign.raw_runs())
    screened = tuple(screen(run, rules) for run in runs)
    if not screened:
        raise DataError(f"{campaign.folder}: holds no runs", "Go on with `hbench run --resume`.")
    found = tuple(replace(curve, fits=fits(curve)) for curve in curves(screened))
    instruments = None if bench is None else bench.instruments
    return Results(
        provenance=campaign.provenance(),
        runs=screened,
        curves=found,
        efficiency=tuple(efficiency(curve, instruments) for curve in found),
        bands=bands(found),
        notes=(*campaign.warnings, *left_out(found)),
    )


def _tables(results: Results) -> dict[str, bytes]:
    return {name: table(results).encode() for name, table in TABLES.items()}


def _open_port(
    experiment: Experiment, name: str, plant: Path | None, seed: int, baud: int | None
) -> Port:
    if name != "sim":
        return SerialPort(name, baud or BAUD)
    physics = _physics(experiment.files["bench"]["content"], plant)
    return _virtual_rig(experiment.bench, physics, seed, baud)


def _physics(bench_data: dict[str, Any], plant: Path | None) -> Plant | None:
    return None if plant is None else parse_plant(bench_data, read_yaml(plant), str(plant))


def _virtual_rig(bench: Bench, physics: Plant | None, seed: int, baud: int | None) -> Port:
    from hbench.rig.virtual import VirtualRig  # compiles; only who simulates waits for it

    return VirtualRig(bench, physics, seed, baud or 0)


def _emulated_rig(image: Path, bench: Bench, physics: Plant | None, seed: int) -> Port:
    from hbench.rig.emulator import EmulatedFirmware
    from hbench.rig.stepped import SteppedRig

    return SteppedRig("emulated", EmulatedFirmware(image), bench, physics, seed)
