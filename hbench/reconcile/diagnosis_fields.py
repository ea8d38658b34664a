"""Fields of a diagnosis that the diagnoses of campaigns and of imported strokes share."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hbench.model.effects.catalogue import EFFECTS
from hbench.model.parameters import CylinderParameters
from hbench.reconcile.acceptance import TIE
from hbench.reconcile.estimates import ParameterEstimates
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.hypothesis import Hypothesis, shape_coefficients
from hbench.records import (
    AddedEffect,
    Candidate,
    Diagnosis,
    Provenance,
    ResidualMap,
    Rival,
)
from hbench.sentences import plural

_PLACES = 501  # along the measured positions


@dataclass(frozen=True, kw_only=True)
class ModelledData:
    """Data and a model that a diagnosis compares; each kind of data adds its own fields."""

    provenance: Provenance  # of the data
    model: str  # file name
    plant_data: Mapping[str, Any]  # sections of the model's file


def residual_map(differences: GapMap, held_out: frozenset[Hashable], unit: str = "") -> ResidualMap:
    """Return the residuals of balances; ``held_out`` are operating points.

    They are in scatters, or in the ``unit`` of all balances.
    """
    value = differences.difference
    if not unit:
        with np.errstate(divide="ignore", invalid="ignore"):
            value = value / differences.scatter
    is_held_out = np.array([point in held_out for point in differences.points])
    return ResidualMap(
        differences.names,
        value,
        differences.v_m_s,
        differences.load_n,
        differences.x_m,
        differences.t_s,
        is_held_out[differences.point],
        unit,
    )


def added_effect(
    name: str,
    candidates: Sequence[Candidate],
    estimates: ParameterEstimates,
    gap_before: float,
    gap_after: float,
) -> AddedEffect:
    """Return the effect that was added out of some candidates.

    Its rival is the best candidate that could be named, with a score not above its own: one above
    explained too little, and one of size 0 has no coefficient beyond its tolerance.
    """
    added = next(candidate for candidate in candidates if candidate.name == name)
    others = [
        candidate
        for candidate in candidates
        if candidate.name != name and candidate.size != 0 and candidate.score <= added.score + TIE
    ]
    rival = max(others, key=lambda candidate: candidate.score, default=None)
    row = EFFECTS[name]
    return AddedEffect(
        name=name,
        description=row.description,
        parameters=estimates.of_effect(name),
        of_sensor=row.of_sensor,
        gap_before=gap_before,
        gap_after=gap_after,
        score=added.score,
        runner_up=Rival(rival.name, added.score - rival.score) if rival else None,
        law=row.law,
    )


def with_place(
    effect: AddedEffect, cylinder: CylinderParameters, measured_m: tuple[float, float]
) -> AddedEffect:
    """Return an effect with the position of the largest friction in its description.

    Of position_friction alone, slope s + bow s^2 with s = -1 to 1 along the stroke of ``cylinder``;
    ``measured_m`` are the ends of the positions that were measured.
    """
    if effect.name != "position_friction":
        return effect
    x = np.linspace(*measured_m, _PLACES)
    s = 2 * (x + cylinder.offset_m) / cylinder.stroke_m - 1
    slope, bow = (effect.parameters[key].value for key in ("slope", "bow"))
    largest = x[np.argmax(s * (slope + bow * s))]
    return replace(effect, description=f"{effect.description}, most at {1e3 * largest:.0f} mm")


def fitted_shape(name: str, hypothesis: Hypothesis) -> str:
    """Return the shape coefficients that were fitted; empty for the textbook law."""
    coefficients = hypothesis.effects.get(name, {})
    return ", ".join(key for _, key in shape_coefficients(name) if key in coefficients)


def _left_out_first(left_out: Sequence[str]) -> str:
    """Return what to do about runs that are left out, before others are measured."""
    if not left_out:
        return ""
    runs = plural(len(left_out), "a run is", f"{len(left_out)} runs are")
    return f"First see why {runs} left out. "


def insufficient_data_diagnosis(
    task: ModelledData, missing: tuple[str, ...], left_out: tuple[str, ...], advice: str = ""
) -> Diagnosis:
    """Return the diagnosis of data that do not suffice to name an effect.

    ``missing`` starts with the most important item. ``advice`` ends the next experiment.
    """
    return Diagnosis(
        provenance=task.provenance,
        model=task.model,
        verdict="unknown",
        why=f"The data do not suffice to name an effect. Missing: {missing[0]}.",
        next_experiment=f"{_left_out_first(left_out)}Measure {missing[0]}. {advice}".rstrip(),
        not_tried=dict.fromkeys(EFFECTS, "too few runs"),
        missing=missing,
        left_out=left_out,
        revised=dict(task.plant_data),
    )
