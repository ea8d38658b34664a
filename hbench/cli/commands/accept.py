"""``hbench accept``: a campaign against a file of limits."""

from pathlib import Path

import typer

from hbench.errors import ExitCode


def accept(
    campaign: Path = typer.Argument(help="Campaign folder."),
    limits: Path = typer.Option(..., help="File of limits of the product."),
    fail: bool = typer.Option(False, "--fail", help="Exit with 6 unless every limit is met: PASS."),
    as_json: bool = typer.Option(False, "--json", help="Print acceptance.json instead of a table."),
) -> None:
    """Decide whether CAMPAIGN's cylinder conforms with limits; write acceptance.json and .xml.

    Decisions: PASS; MARGINAL (inside the limit by less than U95); FAIL; NOT TESTED. The rule that
    takes the uncertainty into account is a key of the file. acceptance.xml is JUnit XML.

    Example: hbench accept demo --limits my-bench/limits.yaml
    """
    from hbench import workflow
    from hbench.report.conformity.acceptance_document import acceptance_json
    from hbench.report.conformity.text import acceptance_text

    acceptance = workflow.accept(campaign, limits)
    typer.echo(acceptance_json(acceptance) if as_json else acceptance_text(acceptance))
    if fail and acceptance.decision != "PASS":
        raise typer.Exit(ExitCode.NEGATIVE)
