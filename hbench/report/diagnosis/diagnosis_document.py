"""``diagnosis.json``: the layout of its keys, from which the text and its JSON Schema are made.

Other programs read the names (schema "hbench.diagnosis/1"), which don't change. A number that does
not exist is null. Gaps are in trial scatters; a parameter's numbers are in its ``unit``.
"""

from hbench.records import (
    AddedEffect,
    Candidate,
    Diagnosis,
    FitParameter,
    Gap,
    GapTable,
    RunGap,
    UnnamedLaw,
)
from hbench.report.json_documents.layout import (
    Constant,
    Layouts,
    NullIfEmpty,
    all_fields,
    json_document,
    keys,
)
from hbench.report.json_documents.schema import Schema, schema
from hbench.report.json_documents.values import json_text

NAME = "diagnosis/1"
_ABOUT = (
    "`hbench reconcile` writes this to diagnosis.json. Gaps are in trial scatters. Names stay as "
    "they are within hbench.diagnosis/1; keys may be added. A number that does not exist is null."
)
_STAGES = ("before", "refitted", "after", "floor")
_PARTS = ("signals", "balances", "open_loop")
_PLAN = ("run", "kind", "label", "direction", "v_ref_m_s", "f_load_n", "p_lr_ref_pa", "trial")

LAYOUTS: Layouts = {
    Diagnosis: {
        "schema": Constant(f"hbench.{NAME}"),
        **keys("provenance", "model", "verdict", "why", "working_point", "practice"),
        **keys("where", "effects", "alternatives", "rest", "small_effects"),
        **keys("next_experiment", "next_schedule"),
        "gap": {"heldout": "gap_heldout", "train": "gap_train", "runs": "gap_runs"},
        **keys("ranking", "threshold", "refitted", "refit_priors", "delays"),
        "refit_refused": NullIfEmpty("refit_refused"),
        **keys("regions", "regions_after", "heldout_runs", "not_tried", "ruled_out"),
        **keys("missing", "left_out", "notes", "unnamed", "separability", "errors"),
        **keys("held_out_loads", "zero_tolerances"),
    },
    Gap: {
        "balance": "name",
        "score": "gap",
        **keys("p_value", "structured", "scatter", "windows"),
    },
    AddedEffect: {
        "name": "name",
        "says": "description",
        **keys("of_sensor", "parameters", "gap_before", "gap_after", "score"),
        "runner_up": "runner_up",
        "shape": NullIfEmpty("shape"),
        "law": NullIfEmpty("law"),
    },
    UnnamedLaw: all_fields(UnnamedLaw),
    FitParameter: keys("value", "se", "ci95", "at_bound", "unit"),
    Candidate: {**all_fields(Candidate, without=("parameters",)), "parameters_si": "parameters"},
    GapTable: {**{name: f"total.{name}" for name in _STAGES}, **keys(*_PARTS)},
    RunGap: {
        **{name: f"plan.{name}" for name in _PLAN},
        "held_out": "held_out",
        **{name: f"gap.total.{name}" for name in _STAGES},
        **{name: f"gap.{name}" for name in _PARTS},
    },
}


def diagnosis_json(diagnosis: Diagnosis) -> str:
    """Return the text of ``diagnosis.json``: all but maps and overlays."""
    return json_text(json_document(diagnosis, LAYOUTS))


def diagnosis_schema() -> Schema:
    """Return the JSON Schema of ``diagnosis.json``."""
    return schema(NAME, "hbench diagnosis", _ABOUT, Diagnosis, LAYOUTS)
