"""Export of a campaign's runs and curves for other programs."""

from collections.abc import Iterator
from pathlib import Path

from hbench.errors import ConfigError
from hbench.report.first_sheet import about_rows
from hbench.store.campaign.folder import NOT_INTO_A_CAMPAIGN, load_campaign, refuse_existing
from hbench.store.exporting.mat_curves import mat_curves
from hbench.store.exporting.modelica import modelica_tables
from hbench.store.exporting.replaced import refuse_replacing
from hbench.store.exporting.runs import FORMATS
from hbench.store.exporting.settings import exported_settings
from hbench.store.exporting.spreadsheets import (
    in_practical_units,
    with_decimal_comma,
    with_rows,
    workbook,
)
from hbench.store.files.atomic import write_atomic
from hbench.workflow.results import derive, result_tables, screened_runs


def export(
    folder: Path,
    destination: Path,
    kind: str,
    *,
    practical_units: bool = False,
    decimal_comma: bool = False,
) -> int:
    """Write a campaign's runs, or its results for Excel or Modelica; return the number of files.

    All runs are exported, rejected ones with the reason, in SI unless ``practical_units`` (mm, bar,
    l/min, degC) are asked for, in CSV or Excel alone; ``decimal_comma`` is for CSV. Raises
    ``ConfigError``, ``DataError``.
    """
    for option, wanted, kinds in (
        ("--units practical", practical_units, ("csv", "excel")),
        ("--decimal comma", decimal_comma, ("csv",)),
    ):
        if wanted and kind not in kinds:
            raise ConfigError(
                f"{option}: is for --format {' and '.join(kinds)}; the format is {kind}",
                "Other formats contain SI numbers.",
            )
    refuse_existing(destination, NOT_INTO_A_CAMPAIGN)
    changes = [in_practical_units] * practical_units + [with_decimal_comma] * decimal_comma

    def changed(text: str) -> str:
        for change in changes:
            text = change(text)
        return text

    campaign = load_campaign(folder)
    if kind == "excel":
        results = derive(campaign)
        tables = with_rows(result_tables(results))
        changed_tables = {name: changed(text) for name, text in tables.items()}
        book = workbook(about_rows(results, tables), changed_tables)
        write_atomic(destination / "results.xlsx", book)
        return 1
    if kind == "modelica":
        write_atomic(destination / "friction.txt", modelica_tables(derive(campaign).curves))
        return 1
    known = {"bench.yaml": campaign.bench_content, "settings.yaml": exported_settings(campaign)}
    beside = {name: content for name, content in known.items() if content}

    def files() -> Iterator[tuple[str, bytes]]:
        if kind == "mat":
            results = derive(campaign)
            yield "curves.mat", mat_curves(results.curves, results.joint_fits)
        runs = ((screened.run, "; ".join(screened.reasons)) for screened in screened_runs(campaign))
        for name, data in FORMATS[kind](runs, beside):
            is_text = changes and name.endswith(".csv")
            yield name, changed(data.decode()).encode() if is_text else data

    if destination.is_dir() and any(destination.iterdir()):
        for name, data in files():
            refuse_replacing(destination / name, data)
    count = 0
    for name, data in files():
        write_atomic(destination / name, data)
        count += 1
    return count
