"""The flow, one function an arrow: schedule -> campaign -> results -> report."""

from hbench.workflow.board import (
    find_boards,
    flash,
    flash_through_programmer,
    load_image,
    serve_rig,
)
from hbench.workflow.campaign import (
    Estimate,
    Experiment,
    Measured,
    estimate,
    import_runs,
    load_experiment,
    measure,
)
from hbench.workflow.comparison import compare, write_comparison
from hbench.workflow.controllers import design, write_design
from hbench.workflow.export import export
from hbench.workflow.identification import identify, write_identification
from hbench.workflow.results import analyze, report
from hbench.workflow.seeds import measure_seeds
from hbench.workflow.simulation import phenomena, simulate, write_phenomenon

__all__ = [
    "Estimate",
    "Experiment",
    "Measured",
    "analyze",
    "compare",
    "design",
    "estimate",
    "export",
    "find_boards",
    "flash",
    "flash_through_programmer",
    "identify",
    "import_runs",
    "load_experiment",
    "load_image",
    "measure",
    "measure_seeds",
    "phenomena",
    "report",
    "serve_rig",
    "simulate",
    "write_comparison",
    "write_design",
    "write_identification",
    "write_phenomenon",
]
