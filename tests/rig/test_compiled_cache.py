"""The rig's compiled loop is kept on disk until a source file that it is made of changes."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import hbench
from hbench import workflow
from hbench.rig import firmware
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


def test_a_second_process_compiles_nothing(tmp_path):
    VirtualRig(workflow.load_experiment(DEMO, None).bench).read(1e-3)
    assert start(tmp_path)[:2] == (1, 0)


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
    edit(package / "rig" / "virtual.py", "while tick < last:", "while tick < 0:")
    assert start_copy() == (0, 1, middle)
