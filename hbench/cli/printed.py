"""Output of commands: JSON objects with a ``schema``, and paragraphs on stderr."""

import json
from pathlib import Path
from typing import Any

import typer

AS_JSON: bool = typer.Option(False, "--json", help="Print a JSON object instead of text.")


def as_object(kind: str, **values: Any) -> str:
    """Return ``{"schema": "hbench.KIND/1", ...}``, with paths as text."""
    plain = {name: str(v) if isinstance(v, Path) else v for name, v in values.items()}
    return json.dumps({"schema": f"hbench.{kind}/1", **plain}, indent=2)


def remark(text: str) -> None:
    """Print a paragraph on stderr, in lines of limited width."""
    from hbench.report.render.terminal_text import WIDE, broken

    for line in broken(text, WIDE, "  "):
        typer.echo(line, err=True)
