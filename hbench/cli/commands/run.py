"""``hbench run``: measurement of a schedule on a bench or on the virtual rig."""

import re
import shlex
import sys
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from hbench.cli.printed import AS_JSON, as_object, remark
from hbench.sentences import counted

if TYPE_CHECKING:
    from hbench.experiment.steady_demand import SteadyDemand
    from hbench.workflow.campaign import Experiment, ScheduleEstimate

_MOST_NOTES = 3


def run(
    schedule: Path = typer.Argument(help="Schedule file, such as configs/demo.yaml."),
    output: Path = typer.Option(None, "-o", "--output", help="Campaign folder to write."),
    specimen: str = typer.Option(
        None,
        help="Serial number of the cylinder under test; '?' asks for it, and a barcode scanner may "
        "answer. Without -o the campaign folder is named after it, with date and time.",
    ),
    bench: Path = typer.Option(None, help="Bench file; by default the schedule's own."),
    port: str = typer.Option(
        "sim", help="'sim' for the virtual rig, a serial device, or socket://host:port."
    ),
    baud: int = typer.Option(
        None,
        min=19200,
        help="Baud rate of the line; by default 115200 for a serial device. On the virtual rig, "
        "octets take no time by default.",
    ),
    plant: Path = typer.Option(
        None, help="Plant file for the virtual rig, with physics that differs from the bench's."
    ),
    seed: int = typer.Option(1, help="Seed of the virtual rig's noise and scatter."),
    campaigns: int = typer.Option(
        None,
        min=1,
        help="Number of campaigns to make on virtual rigs, on all cores: with seeds from --seed "
        "on, each in a folder named after its seed.",
    ),
    check: bool = typer.Option(
        False, "--check", help="Only check the schedule and estimate its time; nothing moves."
    ),
    effects: bool = typer.Option(
        False,
        "--effects",
        help="With --check: simulate the runs, and list the effects that hbench reconcile would "
        "detect in them, from which size on, and the pairs that it would not distinguish.",
    ),
    resume: bool = typer.Option(False, "--resume", help="Continue an interrupted campaign."),
    take_over: bool = typer.Option(
        False, "--take-over", help="Stop a board that still runs, and clear a latched fault."
    ),
    retry: int = typer.Option(
        0,
        min=0,
        max=9,
        help="Repeat a rejected run at once, up to this many times; the log of every attempt is "
        "kept.",
    ),
    as_json: bool = AS_JSON,
) -> None:
    """Run SCHEDULE, and write every run's log to a campaign folder.

    Example: hbench run configs/demo.yaml -o demo
    """
    from hbench import workflow
    from hbench.cli.bench_display import BenchDisplay

    serial = _serial(specimen)
    experiment = workflow.load_experiment(schedule, bench, serial)
    estimate = workflow.estimate(experiment)
    most = "at most " if estimate.at_most else ""
    remark(
        f"{experiment.schedule.name}: {most}{counted(estimate.runs, 'run')}, about "
        f"{_minutes(estimate.seconds)} on the bench, {estimate.bytes / 1e6:.1f} MB of logs"
        f"{'; adaptive velocities: the measured friction determines how many' if most else ''}"
    )
    if effects and not check:
        raise typer.BadParameter("needs --check", param_hint="'--effects'")
    doubts = workflow.doubts(experiment, plant)
    for words in doubts:
        remark(f"note: {words}")
    if check:
        _check(experiment, estimate, plant, effects, doubts, as_json)
        return
    if output is None:
        if serial is None or resume:
            raise typer.BadParameter("missing: give a campaign folder", param_hint="'-o'")
        name = re.sub(r"[^A-Za-z0-9.-]+", "_", serial).lstrip("-.")  # no option, not hidden
        output = Path(f"{name}_{_now():%Y-%m-%d_%H%M%S}")
    line = workflow.Line(port, baud, plant, seed)
    display = BenchDisplay(sys.stderr)
    common = {"resume": resume, "clock": _now, "retry": retry}
    try:
        if campaigns is None:
            summary = workflow.measure(
                experiment, output, line, take_over=take_over, report=display, **common
            )
        else:
            if port != "sim":
                raise typer.BadParameter("needs --port sim", param_hint="'--campaigns'")
            summary = workflow.measure_seeds(
                experiment,
                output,
                line,
                campaigns,
                report=lambda done: typer.echo(f"{done}/{campaigns} campaigns", err=True),
                **common,
            )
    except KeyboardInterrupt:
        display.close("interrupted; give the same command with --resume to continue")
        raise
    finally:
        display.close()
    for run_id, found in summary.made_again.items():
        typer.echo(f"note: run {run_id} was made again, its log was damaged: {found}", err=True)
    if as_json:
        typer.echo(as_object("run", campaign=output, **vars(summary)))
    else:
        typer.echo(
            f"{output}: {counted(summary.runs, 'run')} in {_minutes(summary.seconds)} of bench time"
        )
        if campaigns is None:
            typer.echo(f"next: hbench report {shlex.quote(str(output))}", err=True)


def _serial(specimen: str | None) -> str | None:
    """Return the serial number, read from standard input for ``?``."""
    if specimen == "?":
        specimen = _answer("serial number of the cylinder")
    if specimen is None:
        return None
    if not specimen.strip(" ._-"):
        raise typer.BadParameter("is empty", param_hint="'--specimen'")
    return specimen.strip()


def _answer(question: str) -> str:
    """Return the first line of standard input with text. Raises ``BadParameter`` without one."""
    while True:
        typer.echo(f"{question}: ", nl=False, err=True)
        line = sys.stdin.readline() if sys.stdin else ""  # None: it was closed
        if line.strip():
            return line
        if not line:
            typer.echo(err=True)
            raise typer.BadParameter(
                "'?' got no answer: standard input has ended", param_hint="'--specimen'"
            )


def _check(
    experiment: "Experiment",
    estimate: "ScheduleEstimate",
    plant: Path | None,
    effects: bool,
    doubts: tuple[str, ...],
    as_json: bool,
) -> None:
    """Print what the runs need of the bench, and with ``effects`` what they would show."""
    from hbench import workflow

    demand = workflow.demand(experiment)
    found = {"effects": _effects(experiment, plant, as_json)} if effects else {}
    if as_json:
        steady = {"steady_demand": None if demand is None else vars(demand)}
        values = vars(estimate) | steady | {"notes": doubts} | found
        typer.echo(as_object("estimate", name=experiment.schedule.name, **values))
        return
    if demand is not None:
        remark(_demand_words(demand))
        for words in demand.not_held[:_MOST_NOTES]:
            remark(f"note: not held: {words}")
    remark(
        "checked: travel, speeds, loads and pressures are within the bench's limits; "
        "nothing has moved"
    )


def _demand_words(demand: "SteadyDemand") -> str:
    return (
        f"steady states ({demand.points}): valves up to {demand.valve_v:.2g} of "
        f"{demand.valve_limit_v:g} V (at {1e3 * demand.v_m_s:g} mm/s, {demand.f_load_n:g} N); "
        f"pressures {demand.p_lowest_pa / 1e5:.3g} to {demand.p_highest_pa / 1e5:.3g} bar; "
        f"flow up to {6e4 * demand.flow_m3_s:.3g} l/min"
    )


def _effects(experiment: "Experiment", plant: Path | None, as_json: bool) -> Any:
    """Return the effects that the runs would show as a JSON object; print them otherwise."""
    from hbench import workflow
    from hbench.report.diagnosis.tables.separability_tables import planned_effects_text
    from hbench.report.json_documents.layout import json_document

    typer.echo("simulating a run of each operating point with the bench's model", err=True)
    planned = workflow.planned_effects(experiment, plant)
    if not as_json:
        typer.echo(planned_effects_text(planned))
    return json_document(planned, {})


def _now() -> datetime:
    return datetime.now().astimezone()


def _minutes(seconds: float) -> str:
    minutes, remaining = divmod(round(seconds), 60)
    return f"{minutes} min {remaining:02d} s" if minutes else f"{remaining} s"
