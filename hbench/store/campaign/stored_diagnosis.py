"""What ``hbench reconcile`` left in a campaign folder."""

import json
from pathlib import Path
from typing import Any

from hbench.errors import DataError
from hbench.store.files.bounded_read import LARGEST_JOURNAL, read_file

NAME = "diagnosis.json"
SCHEMA = "hbench.diagnosis/1"


def diagnoses(folder: Path) -> list[tuple[str, dict[str, Any] | str]]:
    """Return the diagnoses in the folders of a campaign, by the folder's name.

    In place of one that can't be read stands the reason. A link out of the campaign is not
    followed.
    """
    found = []
    for path in sorted(folder.glob(f"*/{NAME}")):
        if path.resolve().is_relative_to(folder.resolve()):
            found.append((path.parent.name, _read(path)))
    return found


def _read(path: Path) -> dict[str, Any] | str:
    try:
        content = json.loads(read_file(path, LARGEST_JOURNAL))
    except DataError as error:
        return error.message
    except (ValueError, RecursionError) as error:
        return f"{path}: is no JSON: {error}"
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        return f"{path}: is not of the schema {SCHEMA}"
    return content
