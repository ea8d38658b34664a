"""The packaged JSON Schemas, generated from the records.

After a change of a record:

    python -m hbench.report.schemas results > hbench/report/campaign/results.schema.json
    python -m hbench.report.schemas diagnosis > hbench/report/diagnosis/diagnosis.schema.json
    python -m hbench.report.schemas acceptance > hbench/report/conformity/acceptance.schema.json
"""

import json
import sys
from collections.abc import Callable
from typing import Any

from hbench.report.campaign.results_document import results_schema
from hbench.report.conformity.acceptance_document import acceptance_schema
from hbench.report.diagnosis.diagnosis_document import diagnosis_schema
from hbench.report.json_documents.schema import Schema

_WIDTH = 100
SCHEMAS: dict[str, Callable[[], Schema]] = {
    "results": results_schema,
    "diagnosis": diagnosis_schema,
    "acceptance": acceptance_schema,
}


def schema_text(name: str) -> str:
    """Return the text of the packaged file of a schema."""
    return _pretty(SCHEMAS[name]()) + "\n"


def _pretty(value: Any, depth: int = 0) -> str:
    """Return JSON text with values on one line where they fit."""
    text = json.dumps(value, ensure_ascii=False)
    if len(text) + depth <= _WIDTH or not isinstance(value, dict | list):
        return text
    inside, outside = "\n" + " " * (depth + 1), "\n" + " " * depth
    if isinstance(value, list):
        return "[" + ",".join(inside + _pretty(item, depth + 1) for item in value) + outside + "]"
    items = (f"{json.dumps(key)}: {_pretty(item, depth + 1)}" for key, item in value.items())
    return "{" + ",".join(inside + item for item in items) + outside + "}"


if __name__ == "__main__":
    print(schema_text(sys.argv[1]), end="")
