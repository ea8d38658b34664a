"""Revised model: the effects that held-out runs confirm, and the sections of a plant file."""

import re
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import replace
from typing import Any

import numpy as np

from hbench.config.friction import LuGre
from hbench.reconcile.added_effects import held_out_gaps
from hbench.reconcile.estimates import ParameterEstimates
from hbench.reconcile.gaps.log_map import unexplained_at
from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.search.campaign_search import CampaignSearch
from hbench.reconcile.search_result import SearchResult, Unconfirmed
from hbench.records import FitParameter
from hbench.records.reconcile.diagnosis import LEAST_EXPLAINED, UNEXPLAINED_GAP

_NUMBER = re.compile(r"\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)(.*)$", re.DOTALL)
_REFUTED = "it does not reduce the gap of runs outside the fit"
_MINOR = "it leaves most of the gap of runs outside the fit"
# Nuisances that a file may omit, as it would contain them.
_DEFAULTS = {
    "bristle_stiffness": f"{LuGre.model_fields['bristle_stiffness'].default:g} N/m",
    "stribeck_exponent": LuGre.model_fields["stribeck_exponent"].default,
}


def without_unconfirmed(
    search: CampaignSearch, result: SearchResult, held_out: np.ndarray
) -> SearchResult:
    """Return the result with those effects alone in its final model that held-out points confirm.

    An effect is confirmed if it reduces their gap in the balances that it changes. One that does
    not is no longer named where that gap is too large for an agreement: something else is missing.
    Nor is one that leaves significant gaps and reduces that of all balances by less than a quarter:
    what causes them may have caused its part too.
    """
    unconfirmed: dict[str, Unconfirmed] = {}
    while kept := tuple(name for name in result.names if name not in unconfirmed):
        gaps = {name: held_out_gaps(result.steps, result.final, name, held_out) for name in kept}
        minor = [name for name in kept if _is_minor(result, name, held_out)]
        removed = [
            name for name, (before, after) in gaps.items() if name in minor or not after < before
        ]
        if not removed:
            break
        refuted = {
            name: _MINOR if name in minor else _REFUTED
            for name in removed
            if name in minor or gaps[name][0] > UNEXPLAINED_GAP
        }
        doubtful = [name for name in removed if name not in refuted]
        unconfirmed |= dict.fromkeys(doubtful, Unconfirmed(result.final, kept))
        others = tuple(name for name in kept if name not in removed)
        without = search.without(result.final, removed, others) if others else result.refitted
        result = replace(
            result,
            final=without,
            unconfirmed=dict(unconfirmed),
            ruled_out={**result.ruled_out, **refuted},
        )
    return result


def _is_minor(result: SearchResult, name: str, held_out: np.ndarray) -> bool:
    """Return whether an effect leaves significant gaps, and most of the gap of all balances."""
    final = result.final.gap_map
    if not unexplained_at(final, np.arange(len(final.points))):
        return False
    before = next(step.before for step in result.steps if step.added == name).gap_map
    excess, left = (each.gap(each.names, held_out) ** 2 - 1 for each in (before, final))
    return left > (1 - LEAST_EXPLAINED) * excess


def revision(
    sections: Mapping[str, Any], result: SearchResult, estimates: ParameterEstimates
) -> tuple[dict[str, FitParameter], dict[str, Any]]:
    """Return the factors on the values of a plant's sections, and the revised sections.

    Where the search leaves the model as given, these are no factors and the given sections.
    """
    if result.unchanged:
        return {}, deepcopy(dict(sections))
    factors = estimates.factors()
    return factors, revised(sections, factors, estimates.hypothesis)


def revised(
    sections: Mapping[str, Any], factors: Mapping[str, FitParameter], hypothesis: Hypothesis
) -> dict[str, Any]:
    """Return a plant's sections with factors on values, effects and learned laws."""
    revised_sections = deepcopy(dict(sections))
    for path, factor in factors.items():
        *parents, key = path.split(".")
        section = revised_sections
        for name in parents:
            section = section[name]
        given = section[key] if key in section else _DEFAULTS[key]
        section[key] = _times(given, factor.value)
    if hypothesis.effects:
        effects = revised_sections.get("effects", {})
        revised_sections["effects"] = {**effects, **hypothesis.section()}
    if hypothesis.tables:
        laws = [table.law.section() for table in hypothesis.tables]
        revised_sections["learned"] = [*revised_sections.get("learned", []), *laws]
    return revised_sections


def _times(quantity: str | float, factor: float) -> str | float:
    """Multiply a quantity from a file: a number, or a number with its unit."""
    if not isinstance(quantity, str):
        return float(f"{quantity * factor:.6g}")
    match = _NUMBER.match(quantity)
    assert match is not None  # the file has been parsed
    number, unit = match.groups()
    return f"{float(number) * factor:.6g}{unit}"
