"""The structure of the package: layers without circles, and folders that can be surveyed."""

import ast
from collections import Counter
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1] / "hbench"

# Rooms from the bottom up. Rooms of one row do not import each other, except in row 0.
ROWS = (
    {"channels", "errors", "sentences", "units", "untrusted_text"}
    | {"records", "config", "parallel", "motion"},
    {"model", "protocol", "store", "report"},
    {"analysis", "control", "rig"},
    {"experiment"},
    {"reconcile", "studies"},
    {"workflow"},
    {"api", "cli"},
    {"__main__"},
)
LARGEST_FOLDER = 16  # Python files besides __init__.py
MAY_OPEN_FILES = {
    "model/compiled.py",  # hashes the model's own source for its cache
    "model/compiled_cache.py",  # keeps the compiled model
    "protocol/generate.py",  # a developer's tool: writes the firmware's generated sources
}
FILES = sorted(path for path in ROOT.rglob("*.py") if path != ROOT / "__init__.py")


def room(module: str) -> str:
    return module.split(".")[1]


def row(name: str) -> int:
    return next(i for i, rooms in enumerate(ROWS) if name in rooms)


def module_of(name: str) -> str:
    """The module of this project that an imported name belongs to; empty for any other name."""
    while name.startswith("hbench."):
        path = ROOT.parent / name.replace(".", "/")
        if path.with_suffix(".py").exists() or (path / "__init__.py").exists():
            return name
        name = name.rpartition(".")[0]
    return ""


def imported_modules(path: Path) -> set[str]:
    """Modules of this project that a file imports, wherever in the file."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
    return set(map(module_of, names)) - {""}


def own_name(path: Path) -> str:
    return ".".join(path.relative_to(ROOT.parent).with_suffix("").parts).removesuffix(".__init__")


def folder_of(module: str) -> str:
    is_folder = (ROOT.parent / module.replace(".", "/")).is_dir()
    return module if is_folder else module.rpartition(".")[0]


@pytest.fixture(scope="module")
def imports():
    """The modules that each module imports."""
    return {own_name(path): imported_modules(path) - {own_name(path)} for path in FILES}


def test_modules_import_only_from_lower_rows(imports):
    assert {room(module) for module in imports} == set().union(*ROWS)
    wrong = [
        f"{module} imports {other}"
        for module, others in imports.items()
        for other in others
        if room(other) != room(module)
        and not row(room(other)) < row(room(module))
        and not row(room(other)) == row(room(module)) == 0
    ]
    assert not wrong


def test_no_modules_import_each_other_in_a_circle(imports):
    TopologicalSorter(imports).prepare()  # raises CycleError


def test_no_folders_import_each_other_in_a_circle(imports):
    folders: dict[str, set[str]] = {}
    for module, others in imports.items():
        own = folder_of(module)
        for other in map(folder_of, others):
            nested = own.startswith(f"{other}.") or other.startswith(f"{own}.")
            if other != own and not nested:
                folders.setdefault(own, set()).add(other)
    TopologicalSorter(folders).prepare()  # raises CycleError


def test_no_folder_holds_more_files_than_can_be_surveyed():
    sizes = Counter(path.parent for path in FILES if path.name != "__init__.py")
    large = {str(path.relative_to(ROOT)): n for path, n in sizes.items() if n > LARGEST_FOLDER}
    assert not large


@pytest.mark.parametrize(
    "forbidden", ["open(", ".write_text", ".write_bytes", ".read_text", ".read_bytes", "serial."]
)
def test_only_config_store_rig_and_cli_touch_files_and_ports(forbidden):
    allowed = {"config", "store", "rig", "cli"}
    for path in FILES:
        name = path.relative_to(ROOT)
        if name.parts[0] in allowed or str(name) in MAY_OPEN_FILES:
            continue
        assert forbidden not in path.read_text(), path


def test_the_rooms_agree_on_what_they_write_down_twice():
    """Siblings can't share a name; what both know is compared here."""
    from hbench.model import sensors
    from hbench.protocol import dictionary
    from hbench.rig import board_settings

    assert (sensors.SENSORS, sensors.INPUTS) == (dictionary.SENSORS, dictionary.INPUTS)
    words = {word.name: word for word in dictionary.RECORD}
    assert {words[name].scale for name in dictionary.INPUTS} == {1 / sensors.FRACTION}
    assert board_settings.STEPS_PER_COUNT == sensors.FRACTION
    assert 32767 * words["v"].scale > 0.6  # the largest limits.speed_max


def test_every_name_of_the_workflow_exists():
    from hbench import workflow

    assert all(hasattr(workflow, name) for name in workflow.__all__)
