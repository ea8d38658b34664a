"""``hbench ports``: lists serial ports, and which answer as an hbench board."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import typer

from hbench.cli.printed import AS_JSON, as_object

if TYPE_CHECKING:
    from hbench.rig.discovery import Found


def ports(
    names: list[str] = typer.Argument(
        None,
        metavar="[PORT]...",
        help="Look at these alone; pseudo-terminals and socket://host:port aren't listed.",
    ),
    as_json: bool = AS_JSON,
) -> None:
    """List serial ports, and which answer as an hbench board.

    Each port is opened for about half a second and asked who is there. Opening may toggle its
    control lines (DTR, RTS), which resets some boards: don't, while something must not stop.

    Example: hbench ports
    """
    from hbench import workflow

    found = workflow.find_boards(names or ())
    typer.echo(_json(found) if as_json else _table(found))


def _json(found: Sequence["Found"]) -> str:
    rows = [
        {
            "port": f.port.name,
            "description": f.port.description,
            "state": f.state,
            "firmware": f.board.firmware if f.board else None,
            "board": f.board.board if f.board else None,
            "why": f.why,
        }
        for f in found
    ]
    return as_object("ports", ports=rows)


def _table(found: Sequence["Found"]) -> str:
    if not found:
        return "no serial ports"
    rows = [(f.port.name, _answer(f), f.port.description) for f in found]
    wide = [max(len(row[column]) for row in rows) for column in range(2)]
    return "\n".join(
        f"{name:{wide[0]}}  {answer:{wide[1]}}  {description}".rstrip()
        for name, answer, description in rows
    )


def _answer(found: "Found") -> str:
    if found.board:
        return f"board '{found.board.board}', firmware '{found.board.firmware}'"
    return f"error: {found.why}" if found.why else found.state
