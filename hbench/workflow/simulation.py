"""Simulation of the model alone: phenomena of friction and bench, replay of measured commands."""

from dataclasses import replace
from pathlib import Path

from hbench.config.files.loading import read_yaml
from hbench.errors import ConfigError, DataError
from hbench.records import KINDS, Phenomenon, Replay, Run
from hbench.report.render.figures import figure_files
from hbench.report.simulation.figures import draw_phenomenon
from hbench.report.simulation.page import phenomenon_page
from hbench.report.simulation.replay_text import replay_json
from hbench.store.campaign.folder import NOT_INTO_A_CAMPAIGN, load_campaign, refuse_existing
from hbench.store.exporting.runs import csv_files
from hbench.store.files.atomic import write_files
from hbench.workflow.board import physics_of
from hbench.workflow.results import calibrated_runs

_ADD_A_BENCH = (
    "Export the campaign with `hbench export`, add a bench file 'bench.yaml' to the exported "
    "folder, and import that folder."
)


def phenomena() -> tuple[str, ...]:
    """Return the names of the phenomena that ``simulate`` offers."""
    from hbench.studies.catalogue import PHENOMENA  # compiles

    return tuple(PHENOMENA)


def simulate_phenomenon(name: str, bench_file: Path) -> Phenomenon:
    """Simulate a phenomenon by its name, on a bench if it needs one.

    Raises ``ConfigError``.
    """
    from hbench.studies.catalogue import PHENOMENA

    if name not in PHENOMENA:
        raise ConfigError(
            f"--phenomenon: unknown {name!r}", f"Choose one of: {', '.join(PHENOMENA)}."
        )
    return PHENOMENA[name](read_yaml(bench_file))


def write_phenomenon(folder: Path, phenomenon: Phenomenon) -> None:
    """Write a phenomenon's page and figures, with each figure's data as CSV."""
    drawings = draw_phenomenon(phenomenon)
    page = phenomenon_page(phenomenon, drawings)
    files = figure_files(drawings) | {f"{phenomenon.name}.html": page.encode()}
    write_files(folder, files)


def replay(folder: Path, model_file: Path) -> Replay:
    """Simulate a campaign's runs in open loop: a model under the measured valve commands.

    The model is a bench file, or a plant file applied to the campaign's bench. Raises
    ``ConfigError``, ``DataError``.
    """
    from hbench.reconcile.measured.replay import replay_runs, signal_errors  # compiles

    campaign = load_campaign(folder)
    bench = campaign.bench()
    if bench is None:
        raise DataError(f"{folder}: contains no bench, which the model needs", _ADD_A_BENCH)
    content = campaign.bench_content
    plant = physics_of(content, model_file) or bench
    measured = tuple(r for r in calibrated_runs(campaign) if KINDS[r.plan.kind].is_reconciled)
    simulated, left_out = replay_runs(measured, bench, plant)
    if not simulated:
        raise DataError(f"{folder}: no run can be simulated: {'; '.join(left_out[:3])}")
    off = signal_errors(measured, simulated)
    return Replay(
        provenance=campaign.provenance(),
        model=model_file.name,
        bench=content | {"name": f"{content['name']}, SIMULATED by {model_file.name}"},
        runs=tuple(_labelled(run, f"SIMULATED by {model_file.name}") for run in simulated),
        off=off,
        left_out=left_out,
    )


def _labelled(run: Run, addition: str) -> Run:
    label = ", ".join(filter(None, (run.plan.label, addition)))
    return replace(run, plan=replace(run.plan, label=label))


def write_replay(destination: Path, replay: Replay) -> None:
    """Write the runs as ``hbench export`` does, each labelled as simulated, and the numbers.

    Raises ``ConfigError`` if ``destination`` contains a campaign.
    """
    refuse_existing(destination, NOT_INTO_A_CAMPAIGN)
    files = dict(csv_files(((run, "") for run in replay.runs), {"bench.yaml": replay.bench}))
    write_files(destination, files | {"replay.json": replay_json(replay).encode()})
