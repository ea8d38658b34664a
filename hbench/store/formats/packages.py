"""Optional packages, imported when a format needs them."""

from importlib import import_module

from hbench.errors import ConfigError


def require_package(package: str, name: str, extra: str) -> None:
    """Import the optional package that reads the format ``name``.

    Raises ``ConfigError`` that names hbench's ``extra`` if it is not installed.
    """
    try:
        import_module(package)
    except ImportError:
        raise ConfigError(
            f"{name} needs the package {package}, which is not installed",
            f"Run pip install 'hbench[{extra}]'.",
        ) from None
