"""Optional packages that a format needs."""

from importlib.util import find_spec

from hbench.errors import ConfigError


def require_package(package: str, name: str, extra: str) -> None:
    """Raise ``ConfigError`` if the package that reads the format ``name`` is not installed.

    ``extra`` is hbench's that contains it.
    """
    if find_spec(package) is None:
        raise ConfigError(
            f"{name} needs the package {package}, which is not installed",
            f"Run pip install 'hbench[{extra}]'.",
        )
