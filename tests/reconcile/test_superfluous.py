"""Effects that a later one makes superfluous are dropped again; made-up scores, no search."""

from types import SimpleNamespace

import pytest

from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.search.campaign_search import CampaignSearch, SearchResult, SearchStep
from hbench.reconcile.search.candidates import EvaluatedCandidate
from hbench.records import Candidate


class Search(CampaignSearch):
    """A search whose models are the names of their effects, with given scores."""

    def linearise_at(self, start, hypothesis):
        return SimpleNamespace(**vars(start) | {"hypothesis": hypothesis})

    def refit(self, start, effects, renewed):
        return start

    def with_columns(self, model, names):
        return model

    def _evaluate_in_full(self, model, added, name):
        assert name not in model.hypothesis.effects and name not in added
        score = self.scores[frozenset(added)][name]
        candidate = Candidate(name, score, 0.9, 1.0, {}, "full", 5.0)
        return EvaluatedCandidate(candidate, model)

    def _with_threshold(self, evaluated, added, names):
        return evaluated

    def _lost(self, model, without, effects, fewer):
        (name,) = set(effects) - set(fewer)
        return self.losses.get(name, 0.0)


def search(scores, losses=None):
    made = Search(SimpleNamespace(start=Hypothesis()), None, ())
    object.__setattr__(made, "losses", losses or {})
    object.__setattr__(made, "scores", {frozenset(key): row for key, row in scores.items()})
    return made


def model(*names):
    return SimpleNamespace(
        hypothesis=Hypothesis(effects={name: {"test": 1.0} for name in names}),
        coefficients_of=lambda wanted: [],
    )


def test_an_effect_that_adds_nothing_beside_a_later_one_is_dropped():
    found, dropped = search(
        {("load_friction",): {"seal_pressure_friction": 1.2}}
    ).without_superfluous(
        model("seal_pressure_friction", "load_friction"),
        ("seal_pressure_friction", "load_friction"),
    )
    assert dropped == ("seal_pressure_friction",)
    assert list(found.hypothesis.effects) == ["load_friction"]


def test_of_two_that_replace_each_other_beside_a_third_one_stays():
    """Each alone is superfluous; without the first the second is not."""
    scores = {("b", "c"): {"a": 0.0}, ("c",): {"b": 30.0}}
    found, dropped = search(scores).without_superfluous(model("a", "b", "c"), ("a", "b", "c"))
    assert dropped == ("a",)
    assert list(found.hypothesis.effects) == ["b", "c"]


def test_an_effect_that_still_explains_residuals_stays():
    start = model("a", "b")
    found, dropped = search({("b",): {"a": 12.0}}).without_superfluous(start, ("a", "b"))
    assert dropped == () and found is start


def test_an_effect_whose_loss_makes_the_model_worse_stays_though_it_has_no_score_there():
    """A bow of the bore that grows eightfold takes the place of a lag, and explains far less."""
    start = model("friction_lag", "position_friction")
    rivals = search({("position_friction",): {"friction_lag": 0.2}}, {"friction_lag": 35.0})
    names = ("friction_lag", "position_friction")
    assert rivals.without_superfluous(start, names) == (start, ())


@pytest.mark.parametrize(("zero_alone", "ruled_out"), [(False, ("b",)), (True, ("b", "a"))])
def test_of_two_that_may_each_be_0_beside_the_other_the_first_stays(zero_alone, ruled_out):
    class Refined(Search):
        def refined(self, model, names):
            return model

        def _why_not_needed(self, model, names, name):
            return "" if len(names) == 1 and not zero_alone else "it may be 0"

    made = Refined(SimpleNamespace(start=Hypothesis()), None, ())
    found, gone = made.refined_and_named(model("a", "b"), ("a", "b"))
    assert gone == dict.fromkeys(ruled_out, "it may be 0")
    assert set(found.hypothesis.effects) == {"a", "b"} - set(ruled_out)


@pytest.mark.parametrize(
    ("steps", "names"),
    [
        ([("a", ()), ("b", ("a",))], ("b",)),
        ([("a", ()), ("b", ("a",)), ("a", ())], ("b", "a")),
        ([("a", ()), ("b", ()), (None, ())], ("a", "b")),
    ],
)
def test_a_result_names_what_is_in_its_final_model(steps, names):
    rows = tuple(SearchStep(None, (), added, (), dropped) for added, dropped in steps)
    assert SearchResult(None, None, rows, None).names == names


@pytest.mark.parametrize(
    ("name", "coefficients", "at"),
    [
        ("load_cell_gain", {"error": 0.5}, "error"),
        ("load_cell_gain", {"error": -0.3}, ""),
        ("valve_deadband", {"test": 5.0, "load": 0.0}, "test"),
        ("internal_leakage", {"test": 0.0, "load": 2e-12}, ""),  # no leak is no bound
        ("external_leakage", {"tp": 2e-13, "exponent": 3.0}, ""),  # a shape
    ],
)
def test_an_effect_as_large_as_the_catalogue_allows_is_at_its_bound(name, coefficients, at):
    class Valued(Search):
        def _own_values(self, model, name):
            return {(name, key): value for key, value in coefficients.items()}

    assert Valued(None, None, ())._at_bound(None, name) == at
