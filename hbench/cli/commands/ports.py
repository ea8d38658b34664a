"""``hbench ports``: list of serial ports and hbench boards."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import typer

from hbench.cli.printed import AS_JSON, as_object

if TYPE_CHECKING:
    from hbench.rig.discovery import ProbedPort


def ports(
    names: list[str] = typer.Argument(
        None,
        metavar="[PORT]...",
        help="Probe only these ports; needed for pseudo-terminals and socket://host:port.",
    ),
    as_json: bool = AS_JSON,
) -> None:
    """List the serial ports, and identify the hbench boards on them.

    Each port is opened for about half a second. Opening may toggle its control lines (DTR, RTS),
    which resets some boards: do not use this command while a bench is moving.

    Example: hbench ports
    """
    from hbench import workflow

    probed = workflow.find_boards(names or ())
    typer.echo(_json(probed) if as_json else _table(probed))


def _json(probed: Sequence["ProbedPort"]) -> str:
    rows = [
        {
            "port": f.port.name,
            "description": f.port.description,
            "state": f.state,
            "firmware": f.board.firmware if f.board else None,
            "board": f.board.board if f.board else None,
            "why": f.why,
        }
        for f in probed
    ]
    return as_object("ports", ports=rows)


def _table(probed: Sequence["ProbedPort"]) -> str:
    if not probed:
        return "no serial ports"
    rows = [(port.port.name, _answer(port), port.port.description) for port in probed]
    wide = [max(len(row[column]) for row in rows) for column in range(2)]
    return "\n".join(
        f"{name:{wide[0]}}  {answer:{wide[1]}}  {description}".rstrip()
        for name, answer, description in rows
    )


def _answer(probed: "ProbedPort") -> str:
    if probed.board:
        return f"board '{probed.board.board}', firmware '{probed.board.firmware}'"
    return f"error: {probed.why}" if probed.why else probed.state
