"""Diagnosis of imported campaigns, whose motion can't be simulated, by their steady strokes."""

from collections import defaultdict
from pathlib import Path

from hbench.config.bench import plant_sections
from hbench.config.files.loading import read_yaml
from hbench.config.stroke_model import parse_strokes, stroke_sections
from hbench.errors import ConfigError
from hbench.reconcile.strokes.stroke_diagnosis import StrokeTask, diagnose_strokes
from hbench.records import Diagnosis, ScreenedRun
from hbench.store.campaign.folder import StoredCampaign
from hbench.workflow.results import screened_runs


def diagnosed_strokes(campaign: StoredCampaign, model_file: Path, series: str | None) -> Diagnosis:
    """Diagnose the steady strokes of a ``series``, which is optional if there is only one.

    The model's file needs only test_cylinder and friction.test. Raises ``ConfigError``,
    ``DataError``.
    """
    by_label: dict[str, list[ScreenedRun]] = defaultdict(list)
    for screened in screened_runs(campaign):
        by_label[screened.run.plan.label].append(screened)
    labels = ", ".join(map(repr, by_label))
    if series is None and len(by_label) > 1:
        raise ConfigError(
            f"{campaign.folder}: contains several series: {labels}", "Choose one with --series."
        )
    chosen = next(iter(by_label)) if series is None else series
    if chosen not in by_label:
        raise ConfigError(
            f"--series: {campaign.folder} contains no {chosen!r}", f"Choose one of: {labels}."
        )
    bench = (campaign.header.get("bench") or {}).get("content")
    data = read_yaml(model_file)
    if bench:
        data = plant_sections(bench, data, str(model_file))
    others = {label: runs for label, runs in by_label.items() if label != chosen}
    return diagnose_strokes(
        StrokeTask(
            provenance=campaign.provenance(),
            model=model_file.name,
            plant=parse_strokes(stroke_sections(data), str(model_file)),
            plant_data=data,
            series={chosen: by_label[chosen], **others},
        )
    )
