"""From a campaign and a model to where they disagree, and a model that disagrees less."""

from collections.abc import Callable
from pathlib import Path

from hbench.errors import ConfigError
from hbench.records import Diagnosis
from hbench.report.diagnosis.all_figures import draw_diagnosis
from hbench.report.diagnosis.diagnosis_document import diagnosis_json
from hbench.report.diagnosis.page import diagnosis_page
from hbench.report.diagnosis.revised_yaml import revised_yaml, schedule_yaml
from hbench.report.diagnosis.run_gaps import run_gaps_csv
from hbench.report.render.figures import figure_files
from hbench.store.campaign.folder import load_campaign
from hbench.store.campaign.stored_diagnosis import NAME
from hbench.store.files.atomic import remove_files, write_files

_ONCE = ("next.yaml", "gaps_by_run.csv")  # that not every diagnosis has


def reconcile(
    folder: Path,
    model_file: Path,
    report: Callable[[int, int], None],
    series: str | None = None,
) -> Diagnosis:
    """Find where a campaign and a model disagree, and which effect the model lacks.

    The model is a bench file, or a plant file that is laid over the campaign's bench. ``report`` is
    told how many of how many simulations are done. No simulation can make an imported campaign's
    motion: its steady strokes are compared, those of one ``series``, which must be told where there
    are several. Raises ``ConfigError``, ``DataError``.
    """
    # Compiles; only who reconciles waits for it.
    from hbench.workflow import closed_loop_diagnosis
    from hbench.workflow.stroke_diagnosis import diagnosed_strokes

    campaign = load_campaign(folder)
    if campaign.imported:
        return diagnosed_strokes(campaign, model_file, series)
    if series is not None:
        raise ConfigError(f"{folder}: has no series; only imported campaigns have")
    bench = campaign.bench()
    assert bench is not None  # only imported campaigns may lack one
    return closed_loop_diagnosis.diagnosed(campaign, bench, model_file, report)


def write_diagnosis(folder: Path, found: Diagnosis) -> None:
    """Write the page, its figures, the numbers as JSON, the revised model and the next schedule.

    What an earlier diagnosis left in ``folder`` goes: no schedule or figure stands beside a verdict
    that is not its own.
    """
    drawings = draw_diagnosis(found)
    files = figure_files(drawings)
    files["model.yaml"] = revised_yaml(found).encode()
    if found.next_schedule:
        files["next.yaml"] = schedule_yaml(found).encode()
    if found.gap_runs:
        files["gaps_by_run.csv"] = run_gaps_csv(found).encode()
    files["diagnosis.json"] = diagnosis_json(found).encode()
    files["report.html"] = diagnosis_page(found, drawings).encode()
    if (folder / NAME).is_file():
        remove_files(folder, {*_ONCE, *_figures(folder)} - files.keys())
    write_files(folder, files)


def _figures(folder: Path) -> set[str]:
    found = (
        path for path in (folder / "figures").glob("*") if path.suffix in (".svg", ".png", ".csv")
    )
    return {f"figures/{path.name}" for path in found}
