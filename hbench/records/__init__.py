"""Records: the products of every command, as frozen dataclasses.

Modules are imported on first use, so that a command makes only the classes it needs.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hbench.records.curves import *
    from hbench.records.design import *
    from hbench.records.differences import *
    from hbench.records.fits import *
    from hbench.records.fleet.campaigns import *
    from hbench.records.fleet.population import *
    from hbench.records.fleet.precision import *
    from hbench.records.fleet.process_control import *
    from hbench.records.fleet.summary import *
    from hbench.records.identification import *
    from hbench.records.import_preview import *
    from hbench.records.kinds import *
    from hbench.records.motions import *
    from hbench.records.phenomenon import *
    from hbench.records.reconcile.diagnosis import *
    from hbench.records.reconcile.gaps import *
    from hbench.records.reconcile.separability import *
    from hbench.records.results import *
    from hbench.records.runs import *
    from hbench.records.summary import *

_MODULES = {
    "curves": (
        "Band",
        "BandTrend",
        "Curve",
        "CurvePoint",
        "EfficiencyCurve",
        "EfficiencyPoint",
        "MeanEfficiency",
        "MotionBalance",
        "PressureLine",
    ),
    "design": (
        "Check",
        "ControlLoop",
        "Design",
        "DesignBasis",
        "LoopMerits",
        "MarginRange",
        "PointMargins",
        "Proposal",
        "Reproduced",
        "RootLocus",
    ),
    "reconcile.diagnosis": (
        "AddedEffect",
        "Candidate",
        "Change",
        "Diagnosis",
        "EffectInPractice",
        "HeldOutError",
        "HeldOutLoad",
        "Lookalike",
        "Overlay",
        "Rival",
        "UnnamedLaw",
        "Verdict",
        "WorkingPoint",
    ),
    "differences": (
        "BandDifference",
        "BandTrendDifference",
        "BreakawayDifference",
        "CampaignDifferences",
        "CurveDifference",
        "Difference",
        "DriftEffect",
        "FitDifference",
        "FrictionDifference",
        "MeanAtSpeed",
        "MeanOfCurves",
    ),
    "fits": (
        "Fit",
        "HeldOut",
        "JointFit",
        "Selection",
    ),
    "fleet.campaigns": (
        "QUANTITIES",
        "FleetCampaign",
        "FleetNumber",
        "FleetRow",
        "Quantity",
        "Side",
    ),
    "fleet.population": (
        "FEWEST_CAMPAIGNS",
        "Block",
        "Deviation",
        "Spread",
        "Suspect",
        "Trend",
        "WearTrend",
    ),
    "fleet.precision": (
        "CYLINDER",
        "Estimate",
        "Precision",
        "VarianceSource",
    ),
    "fleet.process_control": (
        "Capability",
        "ChartSignal",
        "ChartStep",
        "ControlChart",
    ),
    "fleet.summary": ("Fleet",),
    "reconcile.gaps": (
        "BeforeAfter",
        "Gap",
        "GapTable",
        "Region",
        "ResidualMap",
        "RunGap",
    ),
    "identification": (
        "Followed",
        "Identification",
        "IdentifiedLaw",
        "LackOfFit",
        "LawsAlongCurve",
        "ModelErrors",
        "RampComparison",
        "Replay",
        "SignalError",
        "Trace",
    ),
    "import_preview": (
        "ImportPreview",
        "PreviewedChannel",
        "PreviewedFile",
        "PreviewedLog",
        "PreviewedRun",
    ),
    "kinds": (
        "KINDS",
        "ExperimentKind",
        "kind_names",
    ),
    "motions": (
        "Breakaway",
        "Comparison",
        "Decay",
        "DistanceTrend",
        "DwellLaw",
        "Leak",
        "Leakage",
        "LeakCoefficient",
        "Level",
        "Loop",
        "LoopWidth",
        "Motions",
        "Surface",
        "Zero",
        "ZeroCheck",
    ),
    "numbers": ("FitParameter", "ParameterPair"),
    "phenomenon": (
        "Finding",
        "Line",
        "Panel",
        "Phenomenon",
        "WordTable",
    ),
    "results": ("Results",),
    "runs": (
        "DIRECTIONS",
        "DIRECTION_WORDS",
        "RUN_FLAGS",
        "SERIES_FIELDS",
        "SIGNS",
        "TEMPERATURES",
        "Direction",
        "Factors",
        "LevelReference",
        "LogChannel",
        "Motion",
        "Outcome",
        "Provenance",
        "RawRun",
        "Run",
        "RunPlan",
        "ScreenedRun",
        "Segment",
        "Series",
        "Specimen",
        "SteadyMeans",
    ),
    "reconcile.separability": (
        "DetectableSize",
        "EffectPair",
        "PlannedEffects",
        "Separability",
    ),
    "summary": (
        "Basis",
        "Completeness",
        "Drift",
        "FitVerdicts",
        "Grade",
        "Headline",
        "HeadlineNumber",
        "HeadlineSeries",
        "ImplausiblePoint",
        "OilTemperature",
        "PointTrials",
        "Quality",
        "QualityCheck",
        "Reduction",
        "ViscosityEffect",
    ),
}
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}
__all__ = sorted(_MODULE_OF)


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
