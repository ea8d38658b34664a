"""The decision that ``hbench accept`` wrote into a campaign folder."""

import json
from pathlib import Path
from typing import get_args

from hbench.errors import DataError
from hbench.records.conformity.acceptance import Conformity
from hbench.store.files.bounded_read import LARGEST_JOURNAL, read_file

FILE_NAME = "acceptance.json"
SCHEMA = "hbench.acceptance/1"


def stored_decision(folder: Path) -> str:
    """Return the decision of the campaign's last acceptance; empty if there is none.

    A link out of the campaign is not followed.
    """
    path = folder / "results" / FILE_NAME
    if not path.is_file() or not path.resolve().is_relative_to(folder.resolve()):
        return ""
    try:
        content = json.loads(read_file(path, LARGEST_JOURNAL))
    except (DataError, ValueError, RecursionError):
        return ""
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        return ""
    decision = str(content.get("decision"))
    return decision if decision in get_args(Conformity) else ""
