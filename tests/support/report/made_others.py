"""Pages of a comparison, an identification and an aborted campaign, made up from few records."""

from dataclasses import replace

import numpy as np

from hbench.records import (
    CampaignDifferences,
    CurveDifference,
    Difference,
    Fit,
    FitParameter,
    FrictionDifference,
    Identification,
    IdentifiedLaw,
    LawsAlongCurve,
    ModelErrors,
)
from hbench.report.campaign.page import report_document
from hbench.report.comparison.text import differences_page
from hbench.report.render.document import page

LONG = "W" * 300


def comparison_page(results):
    """A comparison of a campaign with itself on another bench of a long name."""
    curve = results.curves[0]
    difference = Difference(400.0, 440.0, 4.0, 12.0, 15.0, 1e-3, 0.004)
    points = tuple(FrictionDifference(p.v_m_s, difference, False) for p in curve.points)
    one = CurveDifference(curve, curve, points, difference, difference, ())
    settings = {"limits": {"speed_max": "400 mm/s"}, "long": {LONG: LONG}}
    other = replace(results.provenance, bench=LONG, settings=settings)
    qualities = (results.quality, results.quality)
    names = ("before", LONG)
    found = CampaignDifferences(names, results.provenance, other, qualities, False, (one,), (LONG,))
    return differences_page(found, ())


def made_identification(results):
    """Two laws with errors, one of them along a measured curve."""
    errors = {
        part: ModelErrors(9.7, 1e-4, 1e4, 2e4, 300) for part in ("steady", "unsteady", "rest")
    }
    parameter = FitParameter(150.0, 10.0, (130.0, 170.0), None, "N")
    fit = Fit("tustin", {"f_coulomb_n": parameter}, 4.0, True, LONG)
    laws = (
        IdentifiedLaw("tustin", fit, runs=("0001",), errors=errors),
        IdentifiedLaw("lugre", None, "no reversal"),
    )
    curve = results.curves[0]
    v = np.linspace(0.01, 0.2, 5)
    along = LawsAlongCurve(curve, v, {"tustin": 400.0 + 900.0 * v})
    return Identification(
        results.provenance, laws, (), "no ramps", ("0002",), errors, "", (), (), (LONG,), (along,)
    )


def aborted_page(results):
    """The report of a campaign whose last run the board ended."""
    completeness = replace(results.quality.completeness, planned=96, not_completed=("0007",) * 40)
    last = replace(results.runs[-1], reasons=(f"aborted: {LONG}",))
    quality = replace(results.quality, completeness=completeness)
    broken = replace(results, runs=(*results.runs[:-1], last), quality=quality)
    return page(report_document(broken, ()))
