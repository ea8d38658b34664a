"""The flow, one function an arrow: schedule -> campaign -> results -> report.

A function's file is loaded when it is first used, so that each command loads only what it needs.
"""

from importlib import import_module
from typing import Any

_FILES = {
    "board": ("find_boards", "flash", "flash_through_programmer", "load_image", "serve_rig"),
    "campaign": (
        "Estimate",
        "Experiment",
        "Measured",
        "estimate",
        "import_runs",
        "load_experiment",
        "measure",
    ),
    "seeds": ("measure_seeds",),
    "watch": ("Watch",),
    "results": ("analyze", "report"),
    "fleet": ("analyze_fleet", "write_fleet"),
    "comparison": ("compare", "write_comparison"),
    "identification": ("identify", "write_identification"),
    "reconciliation": ("reconcile", "write_diagnosis"),
    "exports": ("export",),
    "controllers": ("design", "write_design"),
    "simulation": ("phenomena", "replay", "simulate", "write_phenomenon", "write_replay"),
}
_HOMES = {name: file for file, names in _FILES.items() for name in names}
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name in _FILES:
        return import_module(f"{__name__}.{name}")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
