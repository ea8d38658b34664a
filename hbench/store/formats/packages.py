"""Optional packages, imported when a format needs them."""

from importlib import import_module
from types import ModuleType

from hbench.errors import ConfigError


def optional_package(module: str, name: str, extra: str) -> ModuleType:
    """Return a module of an optional package, which reads the format ``name``.

    Raises ``ConfigError`` that names hbench's ``extra`` if the package is not installed.
    """
    try:
        return import_module(module)
    except ImportError:
        package = module.partition(".")[0]
        raise ConfigError(
            f"{name} needs the package {package}, which is not installed",
            f"Run pip install 'hbench[{extra}]'.",
        ) from None
