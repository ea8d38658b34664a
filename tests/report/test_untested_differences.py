"""Comparisons with poor data, and with differences that no trials test."""

from dataclasses import replace

import pytest

from hbench.records import CampaignDifferences, CurveDifference, Difference, QualityCheck
from hbench.report.comparison.about import data_facts
from hbench.report.comparison.text import differences_page
from tests.support.report.spaces import ordinary_spaces

SINGLE = Difference(400.0, 376.1, None, None, None, None, untested="no scatter: a single trial")


@pytest.fixture
def found(small):
    curve = small.curves[0]
    one = CurveDifference(curve, curve, (), SINGLE, None, ())
    provenance, qualities = small.provenance, (small.quality, small.quality)
    names = "before", "after"
    return CampaignDifferences(names, provenance, provenance, qualities, True, (one,), ())


def test_the_data_of_a_poor_campaign_does_not_refer_to_its_own_numbers(found):
    poor = QualityCheck("runs_accepted", "poor", 12.5, "%", 95.0, 80.0, 1, 8)
    quality = found.qualities[0]
    bad = replace(quality, grade="poor", checks=(*quality.checks, poor))
    facts = dict(data_facts(replace(found, qualities=(quality, bad))))
    assert facts["Data of B"].startswith("The data is poor. 1 of 8 runs was accepted.")
    missing = replace(poor, name="trials_per_point", value=1.0)
    bad = replace(quality, grade="poor", checks=(missing,))
    facts = dict(data_facts(replace(found, qualities=(quality, bad))))
    assert "numbers below" not in " ".join(facts.values())


def test_differences_that_no_trials_test_are_not_called_insignificant(found):
    page = ordinary_spaces(differences_page(found, ()))
    assert (
        "No difference of mean friction could be tested in the only curve (no scatter: a single "
        "trial); the largest is −23.9 N (no interval)." in page
    )
