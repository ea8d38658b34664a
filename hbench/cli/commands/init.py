"""``hbench init``: example files of a bench, schedules, a fit and limits."""

import shlex
from pathlib import Path

import typer

from hbench.cli.printed import AS_JSON, as_object

_FILES = (
    "bench-aau.yaml",
    "stribeck.yaml",
    "adaptive.yaml",
    "dynamics.yaml",
    "breakaway.yaml",
    "discriminate.yaml",
    "warm-up.yaml",
    "demo.yaml",
    "fit.yaml",
    "limits.yaml",
)


def init(
    directory: Path = typer.Argument(help="Folder to write into."), as_json: bool = AS_JSON
) -> None:
    """Write commented example files to edit: a bench, seven schedules, a fit file and limits.

    Example: hbench init my-bench
    """
    from hbench.config.files.examples import example
    from hbench.errors import ConfigError

    contents = {name: example(name) for name in _FILES}
    taken = [name for name in _FILES if (directory / name).exists()]
    if taken:
        raise ConfigError(f"{directory / taken[0]}: exists already", "Choose another folder.")
    try:
        directory.mkdir(parents=True, exist_ok=True)
        for name, content in contents.items():
            (directory / name).write_bytes(content)
    except OSError as error:
        raise ConfigError(
            f"{directory}: can't be written: {error.strerror}", "Choose another folder."
        ) from None
    paths = [str(directory / name) for name in _FILES]
    if as_json:
        typer.echo(as_object("init", files=paths))
        return
    typer.echo("\n".join(paths))
    schedule = shlex.quote(str(directory / "demo.yaml"))
    typer.echo(
        f"next: enter your bench's data in {directory / _FILES[0]}, then run "
        f"hbench run {schedule} --check",
        err=True,
    )
