"""From a campaign and a model to where they disagree, and a model that disagrees less."""

from pathlib import Path

from hbench.records import Diagnosis
from hbench.report.diagnosis_json import diagnosis_json
from hbench.report.diagnosis_page import diagnosis_page
from hbench.report.draw_diagnosis import draw_diagnosis
from hbench.report.figures import figure_files
from hbench.report.revised_yaml import revised_yaml, schedule_yaml
from hbench.store.atomic import write_files


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
