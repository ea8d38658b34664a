"""The revised model has what the search fitted, and is the given one where it used nothing."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from hbench.config.stroke_model import parse_strokes
from hbench.reconcile import revised_model
from hbench.reconcile.gaps.gap_map import GapMap, RunLevel
from hbench.reconcile.hypothesis import Hypothesis, typical_size
from hbench.reconcile.nuisance import nuisances
from hbench.reconcile.revised_model import revised, revision, without_unconfirmed
from hbench.reconcile.search_result import SearchResult, SearchStep
from hbench.records import FitParameter

GIVEN = {"valve": {"gain": "8e-7 m^2/V"}}
REFUSED = "The refit is refused."


def result_of(added, refused, laws=()):
    steps = (SearchStep(None, (), added, ()),)
    return SearchResult(None, None, steps, None, refused, laws)


def estimates():
    return SimpleNamespace(
        factors=lambda: {"valve.gain": FitParameter(1.5, 0.1, (1.3, 1.7), None, "1")},
        hypothesis=Hypothesis(),
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


def test_a_value_that_a_file_omits_is_written_where_it_was_refitted():
    friction = {
        "law": "lugre",
        "coulomb": "40 N",
        "stiction": "60 N",
        "stribeck_velocity": "10 mm/s",
    }
    sections = {"test_cylinder": {"piston_diameter": "40 mm"}, "friction": {"test": friction}}
    found = nuisances(parse_strokes(sections, "model"))
    factors = dict.fromkeys(found, FitParameter(2.0, None, None, None, "1"))
    written = revised(sections, factors, Hypothesis())["friction"]["test"]
    assert written["stribeck_exponent"] == 2.0 and written["bristle_stiffness"] == "600000 N/m"
    assert written["coulomb"] == "80 N"


@dataclass(frozen=True)
class StatedMap(GapMap):
    """Map that states which gaps are significant."""

    stated: tuple[str, ...] = ()


@pytest.fixture(autouse=True)
def stated_gaps(monkeypatch):
    monkeypatch.setattr(revised_model, "unexplained_at", lambda found, points: found.stated)


def model_with(force, supply, unexplained=()):
    """A model with a gap in the force balance and in that of the supply, at each of two points."""
    ones, places, points = np.ones((2, 2)), np.zeros((4, 2)), np.array([0, 1])
    gaps = np.array([[force, supply]] * 2)  # of windows whose scatter is 1
    names = ("force_test", "supply")
    found = StatedMap(
        names, gaps, ones, ones, *places, points, ("first", "second"), points, stated=unexplained
    )
    return SimpleNamespace(gap_map=found, columns={}, hypothesis=Hypothesis())


@pytest.mark.parametrize(
    ("mass_after", "droop_before", "droop_after", "kept"),
    [
        (1.1, 5.0, 1.2, ("added_mass", "supply_droop")),
        (1.9, 5.0, 1.2, ("supply_droop",)),
        (1.9, 1.8, 1.9, ()),
    ],
)
def test_the_revised_model_has_the_effects_that_held_out_runs_confirm(
    mass_after, droop_before, droop_after, kept
):
    """Added mass touches the force alone, a droop the supply alone."""
    result, refitted, final = confirmed(mass_after, droop_before, droop_after)
    assert result.names == ("added_mass", "supply_droop") and result.confirmed == kept
    assert [each.model for each in result.unconfirmed.values()] == [final] * (2 - len(kept))
    assert (result.final is refitted) == (not kept) and (result.final is final) == (len(kept) == 2)


def test_an_effect_that_leaves_a_large_gap_outside_the_fit_is_not_named():
    """5.0 times the repeatability without it, and 5.5 with it: another effect is missing."""
    result, refitted, _ = confirmed(1.9, 5.0, 5.5)
    assert result.names == ("added_mass",) and list(result.ruled_out) == ["supply_droop"]
    assert not result.confirmed and result.final is refitted


def test_the_levels_of_a_few_runs_do_not_refute_an_effect():
    """With it a run of other friction than the rest is left: a larger gap, of a level alone."""
    every = np.array([0])
    refitted, final = (force_alone(r) for r in (np.tile([1.5, -1.5], 4), np.full(8, 2.0)))
    assert final.gap_map.gap(("force_test",), every) > refitted.gap_map.gap(("force_test",), every)
    steps = (SearchStep(refitted, (), "added_mass", ()),)
    result = without_unconfirmed(
        SimpleNamespace(without=None), SearchResult(None, refitted, steps, final), np.array([0])
    )
    assert result.confirmed == ("added_mass",)


def force_alone(residuals):
    """A model with these residuals of one run, whose friction may differ by four scatters."""
    count = len(residuals)
    ones, places = np.ones((count, 1)), np.zeros((4, count))
    point = np.zeros(count, int)
    level = RunLevel(slice(0, count), 0, np.full(count, 4.0), 1.0)
    found = StatedMap(
        ("force_test",), residuals[:, None], ones, ones, *places, point, ("first",), point, (level,)
    )
    return SimpleNamespace(gap_map=found, columns={}, hypothesis=Hypothesis())


def confirmed(mass_after, droop_before, droop_after):
    """Return a result with two effects, confirmed or not, its refitted model and that with both."""
    refitted, final = model_with(1.5, droop_before), model_with(mass_after, droop_after)
    steps = tuple(SearchStep(refitted, (), name, ()) for name in ("added_mass", "supply_droop"))
    search = SimpleNamespace(without=lambda model, removed, others: model_with(1.5, droop_after))
    result = SearchResult(None, refitted, steps, final)
    return without_unconfirmed(search, result, np.array([1])), refitted, final


@pytest.mark.parametrize(("of_flow", "is_confirmed"), [(0.01, True), (3.0, False)])
def test_a_gap_that_an_effect_does_not_change_refutes_nothing(of_flow, is_confirmed):
    """With it the force's gap falls from 3 to 1.2, and refitted values raise the flow's."""
    without, final = model_with(3.0, 4.0), model_with(1.2, 5.5)
    for model in (without, final):
        model.gap_map = replace(model.gap_map, names=("force_test", "flow_tp"))
    rise = ("oil_warming", "rise")
    final.hypothesis = Hypothesis().with_coefficients({rise: typical_size(rise)})
    final.columns = {"oil_warming.rise": np.array([[3.0, of_flow]] * 2)}
    result = SearchResult(None, without, (SearchStep(without, (), "oil_warming", ()),), final)
    search = SimpleNamespace(without=None)
    confirmed = without_unconfirmed(search, result, np.array([1])).confirmed
    assert confirmed == (("oil_warming",) if is_confirmed else ())


@pytest.mark.parametrize(("left", "named"), [(5.8, False), (4.0, True)])
def test_what_leaves_most_of_a_significant_gap_is_not_named(left, named):
    """The force falls from 4.8 to 3.5, the supply's gap of 6 has another cause or the same."""
    refitted, final = model_with(4.8, 6.0), model_with(3.5, left, unexplained=("supply",))
    steps = (SearchStep(refitted, (), "added_mass", ()),)
    search = SimpleNamespace(without=None)
    result = without_unconfirmed(search, SearchResult(None, refitted, steps, final), np.array([1]))
    assert (result.names == ("added_mass",)) == named
    assert (list(result.ruled_out) == ["added_mass"]) != named
    agreeing = SearchResult(None, refitted, steps, model_with(3.5, left))
    assert without_unconfirmed(search, agreeing, np.array([1])).names == ("added_mass",)
