"""``hbench run``: makes the runs of a schedule on a bench or on the virtual rig."""

from contextlib import contextmanager
from pathlib import Path

import typer


def run(
    schedule: Path = typer.Argument(help="Schedule file, e.g. configs/demo.yaml."),
    output: Path = typer.Option(..., "-o", "--output", help="Campaign folder to write."),
    bench: Path = typer.Option(None, help="Bench file; by default the schedule's own."),
    port: str = typer.Option("sim", help="'sim', a serial device, or socket://host:port."),
    plant: Path = typer.Option(None, help="Physics of the virtual rig other than the bench's."),
    seed: int = typer.Option(1, help="Seed of the virtual rig's noise and scatter."),
    check: bool = typer.Option(False, "--check", help="Check and estimate only; nothing moves."),
    resume: bool = typer.Option(False, "--resume", help="Go on with an interrupted campaign."),
) -> None:
    """Run SCHEDULE and pull every run's log into a campaign folder.

    Example: hbench run configs/demo.yaml -o demo
    """
    from hbench import workflow

    experiment = workflow.load_experiment(schedule, bench)
    estimate = workflow.estimate(experiment)
    typer.echo(
        f"{experiment.schedule.name}: {len(experiment.plans)} runs, about "
        f"{_minutes(estimate.seconds)} on the bench, {estimate.bytes / 1e6:.1f} MB of logs",
        err=True,
    )
    if check:
        return
    with _progress(estimate) as report:
        summary = workflow.measure(
            experiment, output, port=port, plant=plant, seed=seed, resume=resume, report=report
        )
    typer.echo(f"{output}: {summary.runs} runs in {_minutes(summary.seconds)} of bench time")


@contextmanager
def _progress(estimate):
    """Show runs done, the current reference and the time left; plain lines off a terminal."""
    with typer.progressbar(
        length=estimate.runs,
        label="runs",
        show_pos=True,
        file=typer.get_text_stream("stderr"),
        item_show_func=lambda plan: plan and _reference(plan),
    ) as bar:

        def report(progress) -> None:
            bar.update(progress.runs_done - bar.pos, progress.plan)

        yield report
        bar.update(estimate.runs - bar.pos)


def _reference(plan) -> str:
    return f"{1e3 * plan.v_ref_m_s:+.1f} mm/s, {plan.f_load_n:+.0f} N, trial {plan.trial}"


def _minutes(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"
