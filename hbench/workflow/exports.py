"""Export of a campaign's runs and curves for other programs."""

from pathlib import Path

from hbench.store.campaign.folder import load_campaign
from hbench.store.exporting.mat_curves import mat_curves
from hbench.store.exporting.modelica import modelica_tables
from hbench.store.exporting.runs import FORMATS
from hbench.store.files.atomic import write_atomic
from hbench.workflow.results import derive, screened_runs


def export(folder: Path, destination: Path, kind: str) -> int:
    """Write a campaign's runs in SI, or its curves for Modelica; return the number of files.

    All runs are exported, rejected ones with the reason. Raises ``ConfigError``, ``DataError``.
    """
    campaign = load_campaign(folder)
    if kind == "modelica":
        write_atomic(destination / "friction.txt", modelica_tables(derive(campaign).curves))
        return 1
    if kind == "mat":
        results = derive(campaign)
        write_atomic(destination / "curves.mat", mat_curves(results.curves, results.joint_fits))
    runs = ((screened.run, "; ".join(screened.reasons)) for screened in screened_runs(campaign))
    bench = (campaign.header.get("bench") or {}).get("content")
    files = {"bench.yaml": bench, "settings.yaml": campaign.exported_settings()}
    beside = {name: content for name, content in files.items() if content}
    count = int(kind == "mat")
    for name, data in FORMATS[kind](runs, beside):
        write_atomic(destination / name, data)
        count += 1
    return count
