"""The wheel works in another environment, where there is no compiler."""

import os
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    command = ["-m", "pip", "wheel", "-q", "--no-deps", "-w", folder, ROOT]
    subprocess.run([sys.executable, *command], check=True)
    (made,) = folder.glob("hbench-*.whl")
    return made


@pytest.mark.slow
def test_the_wheel_holds_what_it_runs_on_and_no_tests(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    beside = {
        "hbench/config/examples/bench-aau.yaml",
        "hbench/report/campaign/results.schema.json",
        "hbench/report/render/document.html.j2",
        "hbench/report/render/page.js",
    }
    assert beside <= names
    assert any(name.startswith("hbench/rig/") and name.endswith(".so") for name in names)
    assert {name.split("/")[0] for name in names} == {"hbench", "hbench-0.1.0.dist-info"}
    assert not [name for name in names if "test_" in name or name.endswith((".c", ".h"))]


@pytest.fixture
def constraints(request, tmp_path):
    """A file for pip, with the ``oldest`` versions that the project states for its packages."""
    stated = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    oldest = [package.replace(">=", "==") for package in stated]
    path = tmp_path / "constraints.txt"
    path.write_text("\n".join(oldest if request.param == "oldest" else []))
    return path


@pytest.mark.parametrize(
    "constraints",
    [
        pytest.param("newest", marks=pytest.mark.slow),
        pytest.param("oldest", marks=pytest.mark.nightly),
    ],
    indirect=True,
)
def test_where_there_is_no_compiler_it_runs_a_campaign_and_reports_it(wheel, constraints, tmp_path):
    """Its dependencies come as wheels too. The first run compiles the plant, by numba."""
    other = tmp_path / "other"
    subprocess.run([sys.executable, "-m", "venv", other], check=True)
    path = str(other / "bin")
    assert not any(shutil.which(tool, path=path) for tool in ("cc", "gcc", "clang", "cmake"))
    pip = {name: value for name, value in os.environ.items() if name.startswith("PIP_")}
    bare = pip | {"PATH": path, "HOME": os.environ["HOME"]}
    install = ["python", "-m", "pip", "install", "-q", "--no-compile", "--only-binary", ":all:"]
    for command in (
        [*install, "-c", constraints, wheel],
        ["hbench", "run", "--help"],
        ["hbench", "init", "bench"],
        ["hbench", "run", "bench/demo.yaml", "-o", "demo"],
        ["hbench", "report", "demo", "--format", "pdf"],
    ):
        subprocess.run(
            [other / "bin" / command[0], *command[1:]], env=bare, cwd=tmp_path, check=True
        )
    assert (tmp_path / "demo" / "results" / "report.pdf").stat().st_size > 100_000
