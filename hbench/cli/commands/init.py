"""``hbench init``: example files of a bench, schedules and others."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from hbench.cli.printed import AS_JSON, as_object, remark

if TYPE_CHECKING:
    from hbench.config.files.sized_examples import Size

_FILES = (
    "bench-aau.yaml",
    "stribeck.yaml",
    "adaptive.yaml",
    "dynamics.yaml",
    "breakaway.yaml",
    "discriminate.yaml",
    "warm-up.yaml",
    "acceptance-test.yaml",
    "run-in.yaml",
    "endurance.yaml",
    "demo.yaml",
    "fit.yaml",
    "limits.yaml",
    "acceptance-limits.yaml",
    "certificate.yaml",
    "import-csv.yaml",
)
# In SI; the example's physics is no guide to others.
_LEAST_LOAD = 0.05  # of the force on the rod side: a smaller load is lost in the friction
_OTHER_RODS = (
    "For a rod on both sides edit the files of another size: piston_diameter is the root of "
    "bore^2 - rod^2, and rod_diameter 0 mm."
)
_RANGES = {
    "bore": (0.016, 0.3),
    "rod": (0.003, 0.28),
    "stroke": (0.06, 2.0),
    "supply": (40e5, 350e5),
}


def init(
    directory: Path = typer.Argument(help="Folder to write into."),
    bore: str | None = typer.Option(None, help="Bore of the cylinder under test, in mm."),
    rod: str | None = typer.Option(None, help="Diameter of its rod, in mm."),
    stroke: str | None = typer.Option(None, help="Its stroke, in mm."),
    supply: str | None = typer.Option(None, help="Supply pressure, in bar."),
    as_json: bool = AS_JSON,
) -> None:
    """Write commented example files to edit: a bench, schedules, a fit file, limits, a map.

    With --bore, --rod, --stroke and --supply they are scaled for a cylinder of that size, which the
    virtual rig then simulates: travel, limits, loads and pressures fit each other.

    Example: hbench init my-bench
    """
    from hbench.config.files.examples import example
    from hbench.config.files.sized_examples import BENCH_FILE
    from hbench.errors import ConfigError, HbenchError
    from hbench.store.files.atomic import remove_files, write_files

    size = _size(bore=bore, rod=rod, stroke=stroke, supply=supply)
    contents = {name: example(name) for name in _FILES}
    bench = BENCH_FILE if size else _FILES[0]
    taken = [name for name in (bench, *_FILES[1:]) if (directory / name).exists()]
    if taken:
        raise ConfigError(f"{directory / taken[0]}: exists already", "Choose another folder.")
    if size is not None:
        from hbench import workflow

        texts = {name: content.decode() for name, content in contents.items()}
        made = workflow.sized_files(texts, size)
        contents = {name: text.encode() for name, text in made.files.items()}
    try:
        write_files(directory, contents)
    except HbenchError:
        remove_files(directory, contents)  # a repetition would refuse them
        raise
    paths = [str(directory / name) for name in contents]
    if as_json:
        typer.echo(as_object("init", files=paths))
        return
    typer.echo("\n".join(paths))
    schedule, bench_file = (shlex.quote(str(directory / name)) for name in ("demo.yaml", bench))
    if size is not None:
        remark(f"gains: {made.gains}")
    remark(f"for measurements, first enter your bench's data in {bench_file}")
    if size is not None:
        typer.echo(f"then: hbench design {bench_file} --propose --write", err=True)
    typer.echo(f"next: hbench run {schedule} --check", err=True)


def _size(**given: str | None) -> "Size | None":
    """Return the size of ``--bore`` and the others; None without. Raises ``ConfigError``."""
    from hbench.config.files.sized_examples import Size
    from hbench.errors import ConfigError
    from hbench.units import from_si, to_si

    if all(value is None for value in given.values()):
        return None
    si = {}
    for name, value in given.items():
        unit = "bar" if name == "supply" else "mm"
        if value is None:
            raise ConfigError(
                f"--{name}: is missing", "Give --bore, --rod, --stroke and --supply together."
            )
        try:
            si[name] = to_si(f"{value} {unit}" if value.strip()[-1:].isdigit() else value, unit)
        except ValueError as error:
            raise ConfigError(f"--{name}: {value!r} {error}") from None
        low, high = _RANGES[name]
        if not low <= si[name] <= high:
            limits = " to ".join(f"{from_si(limit, unit):g}" for limit in (low, high))
            other = "10 MPa" if unit == "bar" else "2 in"
            hint = f"A number without a unit is in {unit}; write for example '{other}' for another."
            nearest = "For a size beyond the limits take the nearest one, then edit the files."
            raise ConfigError(
                f"--{name}: is {from_si(si[name], unit):.4g} {unit}; limits {limits} {unit}",
                f"{hint} {_OTHER_RODS if name == 'rod' and not si[name] else nearest}",
            )
    if not 0.1 * si["bore"] <= si["rod"] <= 0.95 * si["bore"]:
        rod_mm, bore_mm = 1e3 * si["rod"], 1e3 * si["bore"]
        raise ConfigError(
            f"--rod: is {rod_mm:.4g} mm; limits {0.1 * bore_mm:.4g} to {0.95 * bore_mm:.4g} mm "
            f"(10 to 95 % of --bore, {bore_mm:.4g} mm)",
            f"Give the diameter of the rod. {_OTHER_RODS}",
        )
    size = Size(si["bore"], si["rod"], si["stroke"], si["supply"])
    load_n, least_n = min(size.moved_n, size.held_n), _LEAST_LOAD * size.rod_force_n
    if load_n < least_n:
        raise ConfigError(
            f"--rod: is {1e3 * size.rod_m:g} mm: the supply gives {size.rod_force_n:.0f} N on "
            f"the rod side; friction and back pressure leave {max(load_n, 0.0):.0f} N for a load; "
            f"limit {least_n:.0f} N",
            "Give a thinner rod or a higher supply pressure, or edit the files of another size.",
        )
    return size
