"""``acceptance.json``: the layout of its keys, from which the text and its JSON Schema are made."""

from hbench.records.conformity.acceptance import Acceptance
from hbench.report.json_documents.layout import Constant, Layouts, json_document, keys
from hbench.report.json_documents.schema import Schema, schema
from hbench.report.json_documents.values import json_text

NAME = "acceptance/1"
_ABOUT = (
    "`hbench accept` writes this to results/acceptance.json. SI; a name ends in its unit, but for "
    "values and limits of a requirement: N, Pa, m^3/s, or 1 for a share. Names stay as they are "
    "within hbench.acceptance/1; keys may be added. A number that does not exist is null."
)

LAYOUTS: Layouts = {
    Acceptance: {
        "schema": Constant(f"hbench.{NAME}"),
        **keys("decision", "provenance", "serial", "product", "limits", "limits_sha256", "rule"),
        **keys("largest_uncertainty", "checks", "data", "notes"),
    },
}


def acceptance_json(acceptance: Acceptance) -> str:
    """Return the text of ``acceptance.json``."""
    return json_text(json_document(acceptance, LAYOUTS))


def acceptance_schema() -> Schema:
    """Return the JSON Schema of ``acceptance.json``."""
    return schema(NAME, "hbench acceptance", _ABOUT, Acceptance, LAYOUTS)
