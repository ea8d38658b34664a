"""The decision that ``hbench accept`` wrote into a campaign folder."""

from pathlib import Path
from typing import get_args

from hbench.records.conformity.acceptance import Conformity
from hbench.store.campaign.stored_diagnosis import read_document

FILE_NAME = "acceptance.json"
SCHEMA = "hbench.acceptance/1"


def stored_decision(folder: Path) -> str:
    """Return the decision of the campaign's last acceptance; empty if there is none.

    A link out of the campaign is not followed.
    """
    path = folder / "results" / FILE_NAME
    if not path.is_file() or not path.resolve().is_relative_to(folder.resolve()):
        return ""
    content = read_document(path, SCHEMA)
    decision = content.get("decision") if isinstance(content, dict) else None
    return str(decision) if decision in get_args(Conformity) else ""
