"""``hbench export``: export of a campaign's runs and curves for other programs."""

from enum import StrEnum
from pathlib import Path

import typer

from hbench.cli.printed import AS_JSON, as_object
from hbench.sentences import counted


class ExportFormat(StrEnum):
    """File format of the export."""

    CSV = "csv"
    PARQUET = "parquet"
    MAT = "mat"
    EXCEL = "excel"
    MODELICA = "modelica"


class Units(StrEnum):
    """Units of exported tables."""

    SI = "si"
    PRACTICAL = "practical"


class Decimal(StrEnum):
    """Decimal sign of exported CSV files."""

    POINT = "point"
    COMMA = "comma"


def export(
    campaign: Path = typer.Argument(help="Campaign folder."),
    output: Path = typer.Option(..., "-o", "--output", help="Folder to write into."),
    format_: ExportFormat = typer.Option(
        ExportFormat.CSV,
        "--format",
        help="csv: runs in SI, which 'hbench import' reads. parquet: the same tables in Parquet. "
        "mat: campaign.mat and curves.mat for MATLAB. excel: the tables of results. modelica: "
        "friction over velocity, for Modelica's tables.",
    ),
    units: Units = typer.Option(
        Units.SI, help="practical: mm, bar, l/min and degC, in CSV and Excel."
    ),
    decimal: Decimal = typer.Option(
        Decimal.POINT, help="comma: for CSV; cells are then separated by semicolons."
    ),
    as_json: bool = AS_JSON,
) -> None:
    """Write CAMPAIGN's runs in SI (rejected ones with the reason), or its results.

    Example: hbench export demo --format mat -o demo-mat
    """
    from hbench import workflow

    count = workflow.export(
        campaign,
        output,
        format_.value,
        practical_units=units is Units.PRACTICAL,
        decimal_comma=decimal is Decimal.COMMA,
    )
    if as_json:
        typer.echo(as_object("export", folder=output, format=format_.value, files=count))
    else:
        typer.echo(f"{output}: {counted(count, 'file')}")
