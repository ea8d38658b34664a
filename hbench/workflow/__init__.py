"""Workflow, one function per arrow: schedule -> campaign -> results -> report.

Modules are imported on first use, so that a command imports only the modules it needs.
"""

from importlib import import_module
from typing import Any

_MODULES = {
    "board": (
        "Line",
        "find_boards",
        "flash",
        "flash_through_programmer",
        "load_image",
        "serve_rig",
    ),
    "campaign": (
        "Experiment",
        "MeasurementSummary",
        "demand",
        "doubts",
        "estimate",
        "load_experiment",
        "measure",
    ),
    "imports": ("import_runs", "preview_import", "suggest_import_map", "write_import_preview"),
    "seeds": ("measure_seeds",),
    "watching.watch": ("Watch",),
    "watching.station": ("Station",),
    "results": ("analyze", "report"),
    "conformity.acceptance": ("accept",),
    "conformity.certificate": ("certify",),
    "fleet": ("analyze_fleet", "write_fleet"),
    "comparison": ("compare", "write_comparison"),
    "identification": ("identify", "write_identification"),
    "reconciliation": ("planned_effects", "reconcile", "write_diagnosis"),
    "exports": ("export",),
    "example_files": ("sized_files",),
    "controllers": ("bench_doubts", "design", "write_design", "write_gains"),
    "simulation": (
        "phenomena",
        "replay",
        "simulate_phenomenon",
        "write_phenomenon",
        "write_replay",
    ),
}
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}
__all__ = sorted(_MODULE_OF)


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return import_module(f"{__name__}.{name}")
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
