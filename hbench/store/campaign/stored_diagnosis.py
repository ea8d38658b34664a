"""Diagnoses that ``hbench reconcile`` wrote into a campaign folder."""

import json
from pathlib import Path
from typing import Any

from hbench.errors import DataError
from hbench.store.files.bounded_read import LARGEST_JOURNAL, read_file

FILE_NAME = "diagnosis.json"
SCHEMA = "hbench.diagnosis/1"


def diagnoses(folder: Path) -> list[tuple[str, dict[str, Any] | str]]:
    """Return the diagnoses in a campaign's folders, each with its folder's name.

    For an unreadable file, the reason is returned as text. A link out of the campaign is not
    followed.
    """
    return [
        (path.parent.name, read_document(path, SCHEMA))
        for path in sorted(folder.glob(f"*/{FILE_NAME}"))
        if path.resolve().is_relative_to(folder.resolve())
    ]


def read_document(path: Path, schema: str, largest: int = LARGEST_JOURNAL) -> dict[str, Any] | str:
    """Return the content of a JSON document of this ``schema``; the reason if it has none.

    A file of more than ``largest`` bytes is not read.
    """
    try:
        content = json.loads(read_file(path, largest))
    except DataError as error:
        return error.message
    except (ValueError, RecursionError) as error:
        return f"{path}: is not JSON: {error}"
    if not isinstance(content, dict) or content.get("schema") != schema:
        return f"{path}: schema is not {schema}"
    return content
