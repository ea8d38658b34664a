"""The rig's compiled loop is kept on disk until a source file that it is made of changes."""

import inspect
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import hbench
from hbench import workflow
from hbench.model import compiled
from hbench.rig import firmware, virtual
from hbench.rig.virtual import VirtualRig

DEMO = Path(__file__).parents[2] / "configs" / "demo.yaml"
START = """
import sys
from pathlib import Path
from hbench import workflow
from hbench.rig.virtual import VirtualRig, _advance

rig = VirtualRig(workflow.load_experiment(Path(sys.argv[1]), None).bench)
rig.read(1.0)
stats = _advance.stats
print(sum(stats.cache_hits.values()), sum(stats.cache_misses.values()), rig._bench.state[0])
"""


def start(folder, **environment):
    """Start a rig in a new process; return the cache's hits and misses, and x after a second."""
    done = subprocess.run(
        [sys.executable, "-c", START, str(DEMO)],
        capture_output=True,
        text=True,
        check=True,
        cwd=folder,
        env=os.environ | environment,
    )
    hits, misses, x = done.stdout.split()
    return int(hits), int(misses), float(x)


def edit(path, old, new):
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))


MODEL = Path(hbench.__file__).parent / "model"
SOURCES = sorted(path.relative_to(MODEL) for path in MODEL.rglob("*.py"))


@pytest.fixture(scope="module")
def model_copy(tmp_path_factory):
    """A copy of the model's sources, and of the files outside that they are compiled with."""
    folder = tmp_path_factory.mktemp("copy")
    shutil.copytree(MODEL, folder / "model", ignore=shutil.ignore_patterns("__pycache__"))
    others = [Path(shutil.copy(other, folder)) for other in compiled._OTHERS]
    return folder / "model", others


def changes_the_key(path, model, others, own_effects=""):
    """Whether an edit of a file changes the cache's key, and taking it back restores the key."""
    before, text = compiled.cache_key(model, others, own_effects), path.read_bytes()
    path.write_bytes(text + b"#\n")
    edited = compiled.cache_key(model, others, own_effects)
    path.write_bytes(text)
    return compiled.cache_key(model, others, own_effects) == before != edited


@pytest.mark.parametrize("source", SOURCES, ids=str)
def test_an_edit_of_any_file_of_the_model_changes_the_key(model_copy, source):
    model, others = model_copy
    assert changes_the_key(model / source, model, others)


def test_an_edit_of_the_table_of_laws_or_of_own_effects_changes_the_key(model_copy, tmp_path):
    model, others = model_copy
    assert others and all(changes_the_key(other, model, others) for other in others)
    effects, beside = tmp_path / "effects.py", tmp_path / "beside.py"
    for path in (effects, beside):
        path.write_text("")
    assert all(changes_the_key(path, model, others, str(effects)) for path in (effects, beside))


def test_what_is_compiled_comes_from_files_of_the_key(virtual_rig_loop):
    """Every function of the package that the rig's loop inlines, nested folders included."""
    files = {Path(function.__code__.co_filename) for function in virtual_rig_loop}
    hashed = {MODEL / source for source in SOURCES}
    assert {"friction", "effects"} <= {path.parent.name for path in files & hashed}
    assert files - hashed == {Path(virtual.__file__)}  # numba checks the caller's own file


def test_a_second_process_compiles_nothing(tmp_path):
    VirtualRig(workflow.load_experiment(DEMO, None).bench).read(1e-3)
    assert start(tmp_path)[:2] == (1, 0)


@pytest.fixture
def virtual_rig_loop():
    """The compiled functions that the rig's loop calls, at any depth."""
    found, waiting = set(), [virtual._advance.py_func]
    while waiting:
        function = waiting.pop()
        if function not in found:
            found.add(function)
            called = inspect.getclosurevars(function)
            values = [*called.globals.values(), *called.nonlocals.values()]
            functions = [getattr(value, "py_func", value) for value in values]
            waiting += [each for each in functions if inspect.isfunction(each)]
    return found


@pytest.mark.slow
def test_an_edit_of_the_model_or_of_the_rig_is_compiled(tmp_path):
    package = tmp_path / "hbench"
    ignore = shutil.ignore_patterns("__pycache__")
    shutil.copytree(Path(hbench.__file__).parent, package, ignore=ignore)
    library = Path(firmware.load_library()._name)
    shutil.copy(library, package / "rig" / library.name)

    def start_copy():
        return start(tmp_path, PYTHONPATH=str(tmp_path))

    middle = pytest.approx(0.2)
    assert start_copy() == (0, 1, middle)
    assert start_copy() == (1, 0, middle)
    edit(package / "model" / "plant.py", "out[X] = v\n", "out[X] = v + 0.1\n")
    assert start_copy() == (0, 1, pytest.approx(0.3, abs=0.01))
    edit(package / "model" / "friction" / "formulas.py", "force * np.exp", "2.0 * force * np.exp")
    assert start_copy()[:2] == (0, 1)
    edit(package / "rig" / "virtual.py", "while tick < last:", "while tick < 0:")
    assert start_copy() == (0, 1, middle)
