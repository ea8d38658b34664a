"""Errors of sensors beside learned laws; made-up laws and sizes, no search."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from hbench.reconcile import diagnose
from hbench.reconcile.diagnose import with_laws
from hbench.reconcile.search.campaign_search import CampaignSearch
from hbench.reconcile.search_result import SearchResult, SearchStep

OFFSET, LEAK = "pressure_offset", "internal_leakage"


@dataclass(frozen=True)
class Search(CampaignSearch):
    """A search whose models are the names of their effects, and "law"."""

    too_small: tuple[str, ...] = field(default=())

    def without(self, model, removed, others):
        return others

    def _why_not_needed(self, model, names, name):
        return "it is too small" if name in self.too_small else ""


def result_with(monkeypatch, names, too_small):
    """Return the result of effects ``names`` with a law beside which some are too small."""

    class Laws:
        def __init__(self, measured, evaluator, effects, held_out):
            pass

        def run(self, model):
            return (*model, "law"), ("flow_lp over opening",)

    monkeypatch.setattr(diagnose, "LawSearch", Laws)
    measured = SimpleNamespace(tolerances={(OFFSET, "p_tp"): 5e4})
    steps = tuple(SearchStep((), (), name, ()) for name in names)
    found = SearchResult((), (), steps, names)
    search = Search(measured, np.arange(4), names, too_small=too_small)
    return with_laws(search, found, np.arange(1))


@pytest.mark.parametrize("names", [(OFFSET,), (LEAK, OFFSET)])
def test_an_offset_within_its_tolerance_beside_a_law_is_not_named(monkeypatch, names):
    found = result_with(monkeypatch, names, too_small=(OFFSET,))
    left = tuple(name for name in names if name != OFFSET)
    assert found.names == found.confirmed == left
    assert found.final == (*left, "law") and found.unlearned == left and found.laws


def test_an_offset_beyond_its_tolerance_beside_a_law_is_named(monkeypatch):
    found = result_with(monkeypatch, (OFFSET,), too_small=())
    assert found.names == (OFFSET,) and found.final == (OFFSET, "law")


def test_an_effect_of_the_plant_is_named_though_a_law_takes_most_of_it(monkeypatch):
    assert result_with(monkeypatch, (LEAK,), too_small=(LEAK,)).names == (LEAK,)
