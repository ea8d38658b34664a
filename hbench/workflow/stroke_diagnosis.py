"""Diagnosis of imported campaigns, whose motion can't be simulated, by their steady strokes."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from hbench.config.bench import plant_sections
from hbench.config.files.loading import read_yaml
from hbench.config.stroke_model import parse_strokes, stroke_sections
from hbench.errors import ConfigError
from hbench.reconcile.strokes.stroke_diagnosis import StrokeTask, diagnose_strokes
from hbench.records import Diagnosis, ScreenedRun
from hbench.sentences import listed
from hbench.store.campaign.folder import StoredCampaign
from hbench.workflow.results import screened_runs


def diagnosed_strokes(
    campaign: StoredCampaign, model_file: Path, series: str | None, absent: Sequence[str]
) -> Diagnosis:
    """Diagnose the steady strokes of a ``series``, which is optional if there is only one.

    Without the channels ``absent`` the campaign is not comparable as a whole. The model's file
    needs only test_cylinder and friction.test. Raises ``ConfigError``, ``DataError``.
    """
    chosen = chosen_series(campaign, series, f"Without {listed(absent)} flows are not known")
    data = read_yaml(model_file)
    if campaign.bench_content:
        data = plant_sections(campaign.bench_content, data, str(model_file))
    by_label: dict[str, list[ScreenedRun]] = {chosen: []}
    for screened in screened_runs(_of_the_same_cylinder(campaign, chosen)):
        by_label.setdefault(screened.run.plan.label, []).append(screened)
    return diagnose_strokes(
        StrokeTask(
            provenance=campaign.provenance(),
            model=model_file.name,
            plant=parse_strokes(stroke_sections(data), str(model_file)),
            plant_data=data,
            series=by_label,
            instruments=campaign.setup().instruments,
        )
    )


def chosen_series(campaign: StoredCampaign, series: str | None, why: str) -> str:
    """Return the label of a ``series``, or of the only one; ``why`` one alone is compared.

    Raises ``ConfigError``.
    """
    labels = list(dict.fromkeys(entry.plan.label for entry in campaign.entries))
    names = ", ".join(map(repr, labels))
    if series is None and len(labels) > 1:
        raise ConfigError(
            f"{campaign.folder}: contains several series: {names}",
            f"{why}, so one series is compared: choose it with --series.",
        )
    chosen = labels[0] if series is None else series
    if chosen not in labels:
        raise ConfigError(
            f"--series: {campaign.folder} contains no {chosen!r}", f"Choose one of: {names}."
        )
    return chosen


def _of_the_same_cylinder(campaign: StoredCampaign, label: str) -> StoredCampaign:
    """Return the campaign without the runs of other cylinders than that of a series."""
    specimen = next(e.plan.specimen for e in campaign.entries if e.plan.label == label)
    entries = tuple(e for e in campaign.entries if e.plan.specimen == specimen)
    return replace(campaign, entries=entries)
