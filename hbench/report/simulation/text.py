"""A phenomenon in words and numbers: tables for the terminal and the page, and its data."""

import json
from dataclasses import asdict

from hbench.records import Finding, Phenomenon, WordTable
from hbench.report.json_documents.values import json_value
from hbench.report.render.numbers import NONE, significant
from hbench.report.render.terminal_table import table_lines

FINDINGS_HEAD = ("quantity", "unit", "simulated", "expected", "formula or source")


def phenomenon_text(phenomenon: Phenomenon) -> str:
    """Return the title and every table in aligned columns."""
    blocks = [phenomenon.title]
    for table in phenomenon_tables(phenomenon):
        blocks.append("\n".join(table_lines(table)))
    return "\n\n".join(blocks)


def phenomenon_json(phenomenon: Phenomenon) -> str:
    """Return the explanation and the numbers as one object; the curves are in CSV files."""
    document = {
        "schema": "hbench.phenomenon/1",
        "name": phenomenon.name,
        "title": phenomenon.title,
        "text": phenomenon.text,
        "findings": [asdict(finding) for finding in phenomenon.findings],
        "tables": [asdict(table) for table in phenomenon.tables],
    }
    return json.dumps(json_value(document), indent=1, allow_nan=False)


def phenomenon_tables(phenomenon: Phenomenon) -> tuple[WordTable, ...]:
    """Return the table of the phenomenon's findings, then its own tables."""
    rows = tuple(_finding(finding) for finding in phenomenon.findings)
    findings = WordTable("Defining numbers", FINDINGS_HEAD, rows)
    return (findings, *phenomenon.tables) if rows else phenomenon.tables


def _finding(finding: Finding) -> tuple[str, ...]:
    expected = NONE if finding.expected is None else significant(finding.expected, 5)
    return (
        finding.quantity,
        finding.unit,
        significant(finding.simulated, 5),
        expected,
        finding.note,
    )
