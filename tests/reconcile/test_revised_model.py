"""The revised model has what the search fitted, and is the given one where it used nothing."""

from types import SimpleNamespace

import numpy as np
import pytest

from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.revised_model import revision
from hbench.reconcile.search_result import SearchResult, SearchStep
from hbench.records import FitParameter

GIVEN = {"valve": {"gain": "8e-7 m^2/V"}}
REFUSED = "The refit is refused."


def result_of(added, refused, laws=()):
    steps = (SearchStep(None, (), added, ()),)
    return SearchResult(None, None, steps, None, refused, laws)


def estimates():
    return SimpleNamespace(
        beta=np.zeros(1),
        factors=lambda: {"valve.gain": FitParameter(1.5, 0.1, (1.3, 1.7), None, "1")},
        hypothesis=lambda beta: Hypothesis(),
    )


def test_a_refused_refit_without_an_addition_leaves_the_model_as_given():
    factors, sections = revision(GIVEN, result_of(None, REFUSED), estimates())
    assert factors == {} and sections == GIVEN


@pytest.mark.parametrize(
    "result",
    [
        result_of(None, ""),
        result_of("internal_leakage", REFUSED),
        result_of(None, REFUSED, laws=(object(),)),
    ],
    ids=["refit", "effect", "law"],
)
def test_a_refit_or_what_is_fitted_with_an_addition_is_in_the_model(result):
    factors, sections = revision(GIVEN, result, estimates())
    assert list(factors) == ["valve.gain"]
    assert sections == {"valve": {"gain": "1.2e-06 m^2/V"}}
