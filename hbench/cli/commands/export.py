"""``hbench export``: a campaign's runs and curves for other programs."""

from enum import StrEnum
from pathlib import Path

import typer

from hbench.cli.printed import AS_JSON, as_object


class Format(StrEnum):
    """What is written."""

    CSV = "csv"
    PARQUET = "parquet"
    MAT = "mat"
    MODELICA = "modelica"


def export(
    campaign: Path = typer.Argument(help="Campaign folder."),
    output: Path = typer.Option(..., "-o", "--output", help="Folder to write into."),
    format_: Format = typer.Option(
        Format.CSV,
        "--format",
        help="csv: runs in SI, as 'hbench import' reads them. parquet: the same as tables. mat: "
        "campaign.mat and curves.mat for MATLAB. modelica: friction over velocity, as Modelica's "
        "tables read it.",
    ),
    as_json: bool = AS_JSON,
) -> None:
    """Write CAMPAIGN's runs in SI, each with the reason if it was rejected, or its curves.

    Example: hbench export demo --format mat -o demo-mat
    """
    from hbench import workflow

    count = workflow.export(campaign, output, format_.value)
    if as_json:
        typer.echo(as_object("export", folder=output, format=format_.value, files=count))
    else:
        typer.echo(f"{output}: {count} {'file' if count == 1 else 'files'}")
