"""Tables of a comparison: means, fitted parameters and single speeds."""

from hbench.records import CampaignDifferences, CurveDifference, FrictionDifference, WordTable
from hbench.report.campaign.fit_tables import label_and_unit, law_words
from hbench.report.campaign.series_words import TITLES, kind_words, load_words
from hbench.report.comparison.cells import cells, difference_table, label_of
from hbench.report.render.numbers import number
from hbench.units import from_si


def means_tables(differences: CampaignDifferences) -> tuple[WordTable, WordTable]:
    """Return the means over the speeds of friction and of efficiency."""
    friction = [(curve, curve.mean_n) for curve in differences.curves]
    efficiency = [(curve, curve.efficiency) for curve in differences.curves]
    friction_table, efficiency_table = (
        difference_table(
            f"{title}: means over the speeds, and their differences",
            ("Curve",),
            [(who(curve), *cells(each, scale)) for curve, each in known if each is not None],
        )
        for title, scale, known in (
            ("Friction (N)", 1.0, friction),
            ("Efficiency (%)", 100.0, efficiency),
        )
    )
    return friction_table, efficiency_table


def parameters_table(differences: CampaignDifferences) -> WordTable:
    """Return the parameters of laws that were fitted in both."""
    rows = []
    for curve in differences.curves:
        for p in curve.parameters:
            words, unit = label_and_unit(p.name, p.unit)
            scale = from_si(1.0, unit)
            rows.append((who(curve), law_words(p.law), f"{words} ({unit})", *cells(p.value, scale)))
    return difference_table("Fitted parameters", ("Curve", "Law", "Parameter"), rows)


def points_table(differences: CampaignDifferences) -> WordTable:
    """Return friction at each speed of the curves with several."""
    rows: list[tuple[str, ...]] = [
        (
            who(curve),
            number(1e3 * point.v_m_s, 1) + (" *" if point.between else ""),
            *cells(point.friction_n, 1.0),
        )
        for curve in differences.curves
        if len(curve.points) > 1  # a single point is the mean
        for point in curve.points
    ]
    title = "Friction at each speed (N)"
    if any(point.between for each in differences.curves for point in each.points):
        title += "; * between two speeds of B"
    return difference_table(title, ("Curve", "Velocity (mm/s)"), rows)


def single_points(differences: CampaignDifferences) -> list[FrictionDifference]:
    """Return the differences at each speed of the curves with several."""
    several = (curve for curve in differences.curves if len(curve.points) > 1)
    return [point for curve in several for point in curve.points]


def who(pair: CurveDifference) -> str:
    """Write label, kind, direction and load of a curve."""
    load = load_words(pair.a.f_load_n, pair.a.p_lr_ref_pa)
    words = (label_of(pair), kind_words(pair.a), TITLES[pair.direction].lower(), load)
    return ", ".join(filter(None, words))
