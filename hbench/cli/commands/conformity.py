"""``hbench accept`` and ``hbench certificate``: limits met, and the document that says so."""

from pathlib import Path

import typer

from hbench.cli.printed import AS_JSON, as_object
from hbench.errors import ExitCode


def accept(
    campaign: Path = typer.Argument(help="Campaign folder."),
    limits: Path = typer.Option(..., help="File of limits of the product."),
    fail: bool = typer.Option(False, "--fail", help="Exit with 6 unless every limit is met: PASS."),
    as_json: bool = typer.Option(False, "--json", help="Print acceptance.json instead of a table."),
) -> None:
    """Decide whether CAMPAIGN's cylinder conforms with limits; write acceptance.json and .xml.

    Decisions: PASS; MARGINAL (inside the limit by less than the expanded uncertainty U); FAIL;
    NOT TESTED. The rule that takes the uncertainty into account is a key of the file.
    acceptance.xml is JUnit XML.

    Example: hbench accept demo --limits my-bench/limits.yaml
    """
    from hbench import workflow
    from hbench.report.conformity.acceptance_document import acceptance_json
    from hbench.report.conformity.text import acceptance_text

    acceptance = workflow.accept(campaign, limits)
    typer.echo(acceptance_json(acceptance) if as_json else acceptance_text(acceptance))
    if fail and acceptance.decision != "PASS":
        raise typer.Exit(ExitCode.NEGATIVE)


def certificate(
    campaign: Path = typer.Argument(help="Campaign folder."),
    with_: Path = typer.Option(
        ..., "--with", help="Certificate file: laboratory, customer, signatories, language, limits."
    ),
    output: Path = typer.Option(
        ...,
        "-o",
        "--output",
        help="File to write; its name gives the form: .html, .pdf, .xml (digital calibration "
        "certificate, PTB's DCC 3.3.0), .zip or a folder (RO-Crate with the raw logs).",
    ),
    as_json: bool = AS_JSON,
) -> None:
    """Write the certificate of CAMPAIGN, with the fields that ISO/IEC 17025, 7.8 asks for.

    A campaign that is incomplete, or whose data is poor, gets none. Simulated campaigns get a
    document that says on each page that it is no certificate.

    Example: hbench certificate demo --with my-bench/certificate.yaml -o certificate.pdf
    """
    from hbench import workflow

    written = workflow.certify(campaign, with_, output)
    if as_json:
        missing = list(written.missing)
        typer.echo(
            as_object(
                "certificate",
                file=output,
                number=written.number,
                simulated=written.simulated,
                missing=missing,
            )
        )
        return
    typer.echo(f"{output}: certificate {written.number}")
    if written.missing:
        typer.echo(
            f"not stated, but asked for by ISO/IEC 17025: {', '.join(written.missing)}", err=True
        )
