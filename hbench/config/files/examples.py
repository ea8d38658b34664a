"""The example files that come with hbench."""

from importlib.resources import files
from pathlib import Path

_IN_A_CHECKOUT = Path(__file__).parents[3] / "configs"


def example(name: str) -> bytes:
    """Return the content of an example file, from the installation or a checkout."""
    installed = files("hbench.config") / "examples" / name
    return (installed if installed.is_file() else _IN_A_CHECKOUT / name).read_bytes()
