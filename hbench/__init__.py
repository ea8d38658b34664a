"""hbench: friction and efficiency of hydraulic cylinders, from a bench to a data sheet.

From Python: ``load`` a campaign as data frames, ``fit`` a friction law to points, ``simulate`` the
bench. They are imported on first use.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hbench.api import Campaign, fit, load, simulate

__version__ = "0.1.0"
__all__ = ["Campaign", "fit", "load", "simulate"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'hbench' has no attribute {name!r}")
    from hbench import api

    return getattr(api, name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
