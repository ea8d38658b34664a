"""``hbench init``: writes a bench file and schedules to edit."""

from pathlib import Path

import typer

from hbench.cli.printed import AS_JSON, as_object

_FILES = (
    "bench-aau.yaml",
    "model-aau.yaml",
    "stribeck.yaml",
    "adaptive.yaml",
    "dynamics.yaml",
    "discriminate.yaml",
    "warm-up.yaml",
    "demo.yaml",
    "fit.yaml",
)


def init(
    directory: Path = typer.Argument(help="Folder to write into."), as_json: bool = AS_JSON
) -> None:
    """Write commented example files to edit: a bench, its model, six schedules and a fit file.

    Example: hbench init my-bench
    """
    from hbench.config.examples import example
    from hbench.errors import ConfigError

    contents = {name: example(name) for name in _FILES}
    taken = [name for name in _FILES if (directory / name).exists()]
    if taken:
        raise ConfigError(f"{directory / taken[0]} exists already", "Choose another folder.")
    try:
        directory.mkdir(parents=True, exist_ok=True)
        for name, content in contents.items():
            (directory / name).write_bytes(content)
    except OSError as error:
        raise ConfigError(f"{directory}: {error.strerror}") from None
    paths = [str(directory / name) for name in _FILES]
    typer.echo(as_object("init", files=paths) if as_json else "\n".join(paths))
