"""The example files that come with hbench."""

from importlib.resources import files
from pathlib import Path

_IN_A_CHECKOUT = Path(__file__).parents[3] / "configs"


def example_path(name: str) -> Path:
    """Return the path of an example file, in the installation or a checkout."""
    installed = Path(str(files("hbench.config"))) / "examples" / name
    return installed if installed.is_file() else _IN_A_CHECKOUT / name


def example(name: str) -> bytes:
    """Return the content of an example file, from the installation or a checkout."""
    return example_path(name).read_bytes()
