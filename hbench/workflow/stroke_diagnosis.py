"""Imported campaigns whose motion no simulation can make, reconciled by their steady strokes."""

from collections import defaultdict
from pathlib import Path

from hbench.config.bench import plant_sections
from hbench.config.files.loading import read_yaml
from hbench.config.stroke_model import parse_strokes, stroke_sections
from hbench.errors import ConfigError
from hbench.reconcile.strokes.stroke_diagnosis import StrokeTask, diagnose_strokes
from hbench.records import Diagnosis, ScreenedRun
from hbench.store.campaign.folder import Campaign
from hbench.workflow.results import screened_runs


def diagnosed_strokes(campaign: Campaign, model_file: Path, series: str | None) -> Diagnosis:
    """Diagnose the steady strokes of one ``series``, which must be told where there are several.

    The model's file needs test_cylinder and friction.test alone. Raises ``ConfigError``,
    ``DataError``.
    """
    by_label: dict[str, list[ScreenedRun]] = defaultdict(list)
    for one in screened_runs(campaign):
        by_label[one.run.plan.label].append(one)
    known = ", ".join(map(repr, by_label))
    if series is None and len(by_label) > 1:
        raise ConfigError(
            f"{campaign.folder}: holds several series: {known}", "Choose one with --series."
        )
    asked = next(iter(by_label)) if series is None else series
    if asked not in by_label:
        raise ConfigError(f"{campaign.folder}: has no series {asked!r}; it has {known}")
    bench = (campaign.header.get("bench") or {}).get("content")
    data = read_yaml(model_file)
    if bench:
        data = plant_sections(bench, data, str(model_file))
    others = {label: runs for label, runs in by_label.items() if label != asked}
    return diagnose_strokes(
        StrokeTask(
            provenance=campaign.provenance(),
            model=model_file.name,
            plant=parse_strokes(stroke_sections(data), str(model_file)),
            plant_data=data,
            series={asked: by_label[asked], **others},
        )
    )
