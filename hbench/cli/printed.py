"""What ``--json`` prints where no file has the same: one object, its kind under ``schema``."""

import json
from pathlib import Path
from typing import Any

import typer

AS_JSON: bool = typer.Option(False, "--json", help="Print one object instead of words.")


def as_object(kind: str, **values: Any) -> str:
    """Return ``{"schema": "hbench.KIND/1", ...}``; paths become text."""
    plain = {name: str(one) if isinstance(one, Path) else one for name, one in values.items()}
    return json.dumps({"schema": f"hbench.{kind}/1", **plain}, indent=2)
