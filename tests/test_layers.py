"""A file imports only from layers below its own; siblings in a row never meet."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1] / "hbench"

# Rooms from the ground up; those in one row don't know each other. Layer 0 is one room.
ROWS = (
    {"errors", "units", "records", "config"},
    {"model", "protocol", "store", "report"},
    {"analysis", "control", "rig"},
    {"experiment", "reconcile"},
    {"workflow"},
    {"api", "cli"},
    {"__main__"},
)
OWN_PARTS = {"model/compiled.py"}  # reads the model's own source, for its cache
FILES = sorted(path for path in ROOT.rglob("*.py") if path != ROOT / "__init__.py")


def room(module: str) -> str:
    return module.split(".")[1]


def row(name: str) -> int:
    return next(i for i, rooms in enumerate(ROWS) if name in rooms)


def imported(path: Path) -> set[str]:
    """Modules of this project that a file imports, wherever in the file."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return {name for name in found if name.startswith("hbench.") and name != "hbench.__version__"}


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_a_file_imports_only_from_layers_below_its_own(path):
    own = path.relative_to(ROOT).with_suffix("").parts[0]
    for module in imported(path):
        other = room(module)
        below = row(other) < row(own) or (row(own) == row(other) == 0)
        assert other == own or below, f"{own} (row {row(own)}) imports {module}"


def test_the_check_sees_every_room():
    rooms = {p.relative_to(ROOT).with_suffix("").parts[0] for p in FILES}
    assert rooms <= set().union(*ROWS)
    assert {"model", "rig", "cli"} <= rooms


@pytest.mark.parametrize(
    "forbidden", ["open(", ".write_text", ".write_bytes", ".read_text", ".read_bytes", "serial."]
)
def test_only_config_store_rig_and_cli_touch_files_and_ports(forbidden):
    allowed = {"config", "store", "rig", "cli"}
    for path in FILES:
        name = path.relative_to(ROOT)
        if name.parts[0] in allowed or str(name) in OWN_PARTS:
            continue
        assert forbidden not in path.read_text(), path


def test_the_rooms_agree_on_what_they_write_down_twice():
    """Siblings can't share a name; what both know is compared here."""
    from typing import get_args

    from hbench.config.friction import Friction
    from hbench.model import friction, sensors
    from hbench.protocol import dictionary
    from hbench.rig import settings

    assert sensors.CHANNELS == dictionary.SENSORS
    words = {word.name: word for word in dictionary.RECORD}
    assert {words[name].scale for name in dictionary.SENSORS} == {1 / sensors.FRACTION}
    assert settings._PARTS == sensors.FRACTION
    kinds = get_args(get_args(Friction)[0])
    laws = {get_args(kind.model_fields["law"].annotation)[0] for kind in kinds}
    assert laws == set(friction.LAWS)
    assert 32767 * words["v"].scale > 0.6  # the largest limits.speed_max
