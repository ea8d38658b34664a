"""A diagnosis as ``diagnosis.json``.

Its names (schema "hbench.diagnosis/1") are read by other programs and don't change. A number that
does not exist is null. Gaps are in trial scatters; a parameter's numbers are in its ``unit``.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from hbench.records import AddedEffect, Candidate, Diagnosis, FitParameter, Gap, GapTable, RunGap
from hbench.report.render.json_values import plain

SCHEMA = "hbench.diagnosis/1"


def diagnosis_json(found: Diagnosis) -> str:
    """Return the text of ``diagnosis.json``: all but maps and overlays."""
    document = {
        "schema": SCHEMA,
        "provenance": asdict(found.provenance),
        "model": found.model,
        "verdict": found.verdict,
        "why": found.why,
        "where": [_gap(one) for one in found.where],
        "effects": [_effect(one) for one in found.effects],
        "alternatives": [_candidate(one) for one in found.alternatives],
        "rest": [_gap(one) for one in found.rest],
        "next_experiment": found.next_experiment,
        "next_schedule": found.next_schedule,
        "gap": {
            "heldout": _gap_table(found.gap_heldout),
            "train": _gap_table(found.gap_train),
            "runs": [_run_gap(one) for one in found.gap_runs],
        },
        "ranking": [_candidate(one) for one in found.ranking],
        "threshold": found.threshold,
        "refitted": _parameters(found.refitted),
        "regions": [asdict(one) for one in found.regions],
        "heldout_runs": found.heldout_runs,
        "not_tried": found.not_tried,
        "missing": found.missing,
        "left_out": found.left_out,
        "notes": found.notes,
    }
    return json.dumps(plain(document), indent=1, allow_nan=False) + "\n"


def _gap(one: Gap) -> dict[str, Any]:
    return {
        "balance": one.name,
        "score": one.gap,
        "p_value": one.p_value,
        "structured": one.structured,
        "scatter": one.scatter,
        "windows": one.windows,
    }


def _effect(one: AddedEffect) -> dict[str, Any]:
    return {
        "name": one.name,
        "says": one.says,
        "of_sensor": one.of_sensor,
        "parameters": _parameters(one.parameters),
        "gap_before": one.gap_before,
        "gap_after": one.gap_after,
        "score": one.score,
        "runner_up": one.runner_up and asdict(one.runner_up),
        "shape": one.shape or None,
    }


def _parameters(parameters: Mapping[str, FitParameter]) -> dict[str, dict[str, Any]]:
    return {
        name: {
            "value": one.value,
            "se": one.se,
            "ci95": one.ci95,
            "at_bound": one.at_bound,
            "unit": one.unit,
        }
        for name, one in parameters.items()
    }


def _candidate(one: Candidate) -> dict[str, Any]:
    numbers = {name: value for name, value in asdict(one).items() if name != "parameters"}
    return numbers | {"parameters_si": one.parameters}


def _run_gap(one: RunGap) -> dict[str, Any]:
    names = ("run", "kind", "label", "direction", "v_ref_m_s", "f_load_n", "p_lr_ref_pa", "trial")
    about = {name: getattr(one.plan, name) for name in names}
    return {**about, "held_out": one.held_out, **_gap_table(one.gap)}


def _gap_table(table: GapTable) -> dict[str, Any]:
    parts = {
        part: {name: asdict(one) for name, one in getattr(table, part).items()}
        for part in ("signals", "balances", "open_loop")
    }
    return asdict(table.total) | parts
