"""From a campaign and a model to where they disagree, and a model that disagrees less."""

from collections.abc import Callable
from pathlib import Path

from hbench.errors import DataError
from hbench.records import Diagnosis
from hbench.report.diagnosis_json import diagnosis_json
from hbench.report.diagnosis_page import diagnosis_page
from hbench.report.draw_diagnosis import draw_diagnosis
from hbench.report.figures import figure_files
from hbench.report.revised_yaml import revised_yaml, schedule_yaml
from hbench.store.atomic import write_files
from hbench.store.campaign import load_campaign


def reconcile(folder: Path, model_file: Path, report: Callable[[int, int], None]) -> Diagnosis:
    """Find where a campaign and a model disagree, and which effect the model lacks.

    The model is a bench file, or a plant file that is laid over the campaign's bench. ``report`` is
    told how many of how many simulations are done. Raises ``ConfigError``, ``DataError``.
    """
    from hbench.workflow.modelled import diagnosed  # compiles; only who reconciles waits for it

    campaign = load_campaign(folder)
    bench = campaign.bench()
    if bench is None:
        raise DataError(
            f"{folder}: tells no bench, whose controllers and sensors the comparison needs",
            "Lay a bench file 'bench.yaml' beside the logs and import them again.",
        )
    return diagnosed(campaign, bench, model_file, report)


def write_diagnosis(folder: Path, found: Diagnosis) -> None:
    """Write the page, its figures, the numbers as JSON, the revised model and the next schedule."""
    drawings = draw_diagnosis(found)
    files = figure_files(drawings)
    files["model.yaml"] = revised_yaml(found).encode()
    if found.next_schedule:
        files["next.yaml"] = schedule_yaml(found).encode()
    files["diagnosis.json"] = diagnosis_json(found).encode()
    files["report.html"] = diagnosis_page(found, drawings).encode()
    write_files(folder, files)
