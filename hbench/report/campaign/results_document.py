"""``results.json``: the layout of its keys, from which the text and its JSON Schema are made.

Other programs read the names (schema "hbench.results/1"), which don't change. A number that does
not exist, NaN included, is null.
"""

from typing import Any

from hbench.records import (
    SERIES_FIELDS,
    TEMPERATURES,
    Band,
    BandTrend,
    Breakaway,
    Comparison,
    Curve,
    CurvePoint,
    Decay,
    DistanceTrend,
    Drift,
    DwellLaw,
    EfficiencyCurve,
    EfficiencyPoint,
    Fit,
    Level,
    Loop,
    QualityCheck,
    Results,
    ScreenedRun,
    Selection,
    ViscosityEffect,
)
from hbench.report.json_documents.layout import (
    Constant,
    Layouts,
    NullIfEmpty,
    NullIfNot,
    Source,
    all_fields,
    json_document,
    keys,
)
from hbench.report.json_documents.schema import Schema, schema
from hbench.report.json_documents.values import json_text

NAME = "results/1"
_ABOUT = (
    "`hbench analyze` and `hbench report` write this to results/results.json. SI; a name ends in "
    "its unit. Names stay as they are within hbench.results/1; keys may be added. A number that "
    "does not exist is null."
)
_PLAN = (*SERIES_FIELDS[:3], "v_ref_m_s", "a_ref_m_s2", "f_load_n", "p_lr_ref_pa", "trial")
_MEANS = (
    *("friction_n", "efficiency", "f_test_n", "f_applied_n", "p_tp_pa", "p_tr_pa"),
    *("t_start_s", "t_stop_s", "n"),
    *TEMPERATURES,
    "v_ripple_m_s",
)
_CHANGES = ("change", "change_ci95", "change_percent", "change_percent_ci95")


def _with_series(record: type) -> dict[str, Source]:
    """Return the row of a record with its series' keys first."""
    series = {name: f"series.{name}" for name in ("label", "f_load_n", "p_lr_ref_pa")}
    return series | all_fields(record, without=("series",))


LAYOUTS: Layouts = {
    Results: {
        "schema": Constant(f"hbench.{NAME}"),
        **keys("provenance", "runs", "curves", "joint_fits", "efficiency", "bands", "band_trends"),
        "motion_balances": "motion_balances",
        **{name: f"motions.{name}" for name in ("comparisons", "loops", "levels")},
        "leakage": "motions.leakages",
        **{name: f"motions.{name}" for name in ("breakaways", "dwell_laws", "zero_checks")},
        "surfaces": "motions.surfaces",
        "over_distance": "motions.over_distance",
        **keys("drift", "oil_temperature", "headline", "quality", "fit_verdicts", "notes"),
    },
    ScreenedRun: {
        "run": "run.plan.run",
        **{name: f"run.plan.{name}" for name in _PLAN},
        "factors": "run.plan.factor_values",
        "accepted": "accepted",
        "reason": NullIfEmpty("reason"),
        **keys("reasons", "notes"),
        "v_mean_m_s": "means.v_m_s",
        **{name: f"means.{name}" for name in _MEANS},
        "work_j": "work_j",
    },
    Curve: {
        **keys(*SERIES_FIELDS),
        "factors": "factor_values",
        "temp_range_k": "temp_range_k",
        **keys("specimen", "points", "fits", "selection"),
    },
    CurvePoint: all_fields(CurvePoint, without=("u_steps", "far_shift_n")),
    Fit: all_fields(
        Fit,
        without=("line", "beyond", "covariance", "spread", "held_out_n"),
        covariances="covariances",
        verdict="verdict",
        undetermined="undetermined",
        hardly_determined="hardly_determined",
    ),
    Selection: {
        **keys("laws", "difference_n2", "difference_se_n2"),
        "told_apart": "distinguishable",
        "speeds": "speeds",
    },
    EfficiencyCurve: keys(*SERIES_FIELDS, "points", "mean"),
    EfficiencyPoint: all_fields(EfficiencyPoint, reason=NullIfEmpty("reason")),
    ViscosityEffect: all_fields(ViscosityEffect, determined="determined"),
    Drift: all_fields(Drift, temp_change_k=NullIfNot("temp_change_k", "has_temp_change"))
    | {name: NullIfNot(name, "has_size") for name in _CHANGES},
    QualityCheck: all_fields(QualityCheck, without=("drift",)),
    Band: all_fields(Band, without=("extend", "retract", "factors")),
    BandTrend: {
        **keys("kind", "label", "specimen", "p_lr_ref_pa", "pressures_pa", "half", "middle"),
    },
    Comparison: _with_series(Comparison),
    Loop: _with_series(Loop),
    Level: _with_series(Level),
    Decay: _with_series(Decay),
    Breakaway: _with_series(Breakaway),
    DwellLaw: _with_series(DwellLaw),
    DistanceTrend: _with_series(DistanceTrend),
}


def results_json(results: Results) -> str:
    """Return the text of ``results.json``."""
    return json_text(json_document(results, LAYOUTS))


def results_schema() -> Schema:
    """Return the JSON Schema of ``results.json``."""
    return schema(NAME, "hbench results", _ABOUT, Results, LAYOUTS)


def row(record: Any) -> dict[str, Any]:
    """Return a record of ``results.json`` as its keys and values."""
    return json_document(record, LAYOUTS)
