"""Deviations of forces at rest: made-up residuals whose parts are known."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.records import ResidualMap
from hbench.report.diagnosis.page import diagnosis_page
from hbench.report.diagnosis.tables.gap_tables import where_table
from hbench.report.diagnosis.verdict import verdict_words
from hbench.report.diagnosis.words.rest import deviation_in_motion
from tests.support.report.spaces import ordinary_spaces

SCATTER_N = 10.0


def held(compared, rest_n, moving_n, travel_m=2e-6, p_value=1.0):
    """Two runs of 8 windows in motion and one of 4 at rest, whose force is off by as much."""
    v = np.array([0.05] * 8 + [-0.05] * 8 + [0.0] * 4)
    x = np.concatenate((np.linspace(0.1, 0.3, 8), np.linspace(0.3, 0.1, 8), 0.2 * np.ones(4)))
    x[-1] += travel_m
    t = np.concatenate((np.arange(8), np.arange(8), np.arange(4))) * 0.16
    force = np.where(v == 0.0, rest_n, moving_n) / SCATTER_N
    value = np.column_stack((force, np.zeros(20)))
    side = ResidualMap(
        ("force_test", "flow_tp"), value, v, np.full(20, 5e3), x, t, np.zeros(20, bool)
    )
    every = float(np.sqrt(np.mean((SCATTER_N * force) ** 2)))
    first, second = compared.where
    gap = replace(
        first,
        gap=every / SCATTER_N,
        scatter=SCATTER_N,
        deviation=every,
        p_value=p_value,
        windows=20,
    )
    return replace(
        compared, verdict="none", rest=(), where=(gap, second), residuals_before=side
    )  # fmt: skip


def test_a_force_that_deviates_at_rest_alone_is_no_contradiction_to_an_agreement(compared):
    found = held(compared, rest_n=80.0, moving_n=8.0)
    assert deviation_in_motion(found, found.where[0]) == pytest.approx(8.0)
    verdict = ordinary_spaces(verdict_words(found))
    assert (
        "arises at rest, where the motion does not determine friction; in motion it is 8.0 N."
        in (verdict)
    )
    page = ordinary_spaces(diagnosis_page(found, ()))
    assert "deviates by 80 N RMS at rest and by 8.0 N in motion. At rest are the 4 of 20" in page
    assert "The piston moves by up to 0.002 mm there." in page
    assert "Such a ramp is no evidence of a missing effect." in page
    head, (row, _) = where_table(found).head, where_table(found).rows
    assert dict(zip(head, row, strict=True))["in motion"] == "8.0 N"


def test_a_deviation_in_motion_or_one_that_is_significant_is_not_explained_by_rest(compared):
    moving = held(compared, rest_n=80.0, moving_n=20.0)
    assert "at rest" not in verdict_words(moving)
    assert "no evidence" not in diagnosis_page(moving, ())
    significant = verdict_words(held(compared, rest_n=80.0, moving_n=8.0, p_value=0.01))
    assert "at rest" not in significant and "is significant" in significant


def test_a_creeping_piston_is_not_called_still(compared):
    creeping = held(compared, rest_n=80.0, moving_n=8.0, travel_m=4e-4)
    assert "arises at rest and below 2 mm/s; above, it is 8.0 N." in ordinary_spaces(
        verdict_words(creeping)
    )
    assert "no evidence" not in diagnosis_page(creeping, ())
