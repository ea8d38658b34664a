"""Tables of a comparison: means, fitted parameters and single speeds."""

from collections.abc import Iterable

from hbench.records import (
    DIRECTION_WORDS,
    CampaignDifferences,
    CurveDifference,
    Drift,
    DriftEffect,
    FrictionDifference,
    WordTable,
)
from hbench.report.campaign.fit_tables import label_and_unit, law_words
from hbench.report.campaign.series_words import kind_words, load_words
from hbench.report.comparison.cells import (
    MAY_BE_DRIFT,
    NOT_SIGNIFICANT,
    SIGNIFICANT,
    TRIALS,
    WITH_U,
    cells,
    difference_table,
    label_of,
    with_u95,
)
from hbench.report.render.numbers import NONE, half_width, in_mm_s, p_words, with_interval
from hbench.units import from_si

_CLEARLY_MORE = 1.1  # times the interval of the trials


def means_tables(differences: CampaignDifferences) -> tuple[WordTable, WordTable]:
    """Return the means over the speeds of friction and of efficiency.

    Friction has the mean over the curves, too, and where the order of the runs does not separate a
    drift, the drift's largest part in each difference. A difference of a curve that the drift may
    account for is not called significant.
    """
    friction = [(curve, curve.mean_n) for curve in differences.curves]
    efficiency = [(curve, curve.efficiency) for curve in differences.curves]
    hidden = {id(curve) for curve in hidden_curves(differences)}
    drift_column = has_drift_column(differences)
    friction_table, efficiency_table = (
        difference_table(
            f"{title}: means over the speeds, and their differences",
            ("Curve",),
            [
                (
                    who(curve),
                    *cells(each, scale, id(curve) in hidden),
                    *([_largest_drift(curve.drift_n)] if drift else []),
                )
                for curve, each in known
                if each is not None
            ]
            + rows,
            ("Drift up to (N)",) if drift else (),
        )
        for title, scale, known, drift, rows in (
            ("Friction (N)", 1.0, friction, drift_column, _over_curves(differences, drift_column)),
            ("Efficiency (%)", 100.0, efficiency, False, []),
        )
    )
    return friction_table, efficiency_table


def unseparated(differences: CampaignDifferences) -> list[Drift]:
    """Return the drifts that matter and that the order of the runs does not separate."""
    return [
        drift
        for drift in differences.drifts
        if drift is not None and not drift.separated and (drift.significant or drift.hidden)
    ]


def has_drift_column(differences: CampaignDifferences) -> bool:
    """Return whether the table of friction has the drift that a difference may come from."""
    known = any(curve.drift_n is not None for curve in differences.curves)
    return known and bool(unseparated(differences))


def hidden_curves(differences: CampaignDifferences) -> list[CurveDifference]:
    """Return the curves whose difference an unseparated drift may account for."""
    if not unseparated(differences):
        return []
    return [curve for curve in differences.curves if not is_beyond_drift(curve)]


def is_beyond_drift(curve: CurveDifference) -> bool:
    """Return whether a difference exceeds its uncertainty and its drift together."""
    mean, drift = curve.mean_n, curve.drift_n
    if mean is None or drift is None:
        return False
    return abs(mean.value) > (mean.u95 or 0.0) + drift.largest_n


def _largest_drift(drift: DriftEffect | None) -> str:
    return NONE if drift is None else half_width(drift.largest_n)


def _over_curves(differences: CampaignDifferences, drift_too: bool) -> list[tuple[str, ...]]:
    """Return the row of the mean over the curves; none where it is not known."""
    mean = differences.mean_of_curves
    if mean is None:
        return []
    drift = "cancels" if mean.drift_cancels else _largest_drift(mean.drift_n)
    trials = with_interval(mean.value_n, mean.ci95_n)
    with_u = with_interval(mean.value_n, mean.half_n)
    a = with_u95(mean.a_n, mean.u95_a)
    b = with_u95(mean.a_n + mean.value_n, mean.u95_b)
    row = (
        f"mean over all {mean.curves} curves, one test",
        a,
        b,
        with_u,
        trials,
        mean_verdict(differences),
        p_words(mean.p_value),
    )
    return [(*row, *([drift] if drift_too else []))]


def speeds_table(differences: CampaignDifferences) -> WordTable:
    """Return the difference of friction at each speed, in the mean over the curves.

    With its U, and with the intervals of the trials where these are clearly smaller.
    """
    mean = differences.mean_of_curves
    speeds = mean.speeds if mean else ()
    columns = {
        "Speed (mm/s)": [in_mm_s(each.v_m_s) for each in speeds],
        WITH_U: [with_interval(each.value_n, each.u95_n) for each in speeds],
        TRIALS: [with_interval(each.value_n, each.ci95_n) for each in speeds],
    }
    known = [(each.u95_n, each.ci95_n) for each in speeds if each.u95_n is not None]
    if len(known) < len(speeds):
        del columns[WITH_U]
    elif all(u95_n < _CLEARLY_MORE * ci95_n for u95_n, ci95_n in known):
        del columns[TRIALS]
    title = "Friction (N): B − A at each speed, means over the curves"
    return WordTable(title, tuple(columns), tuple(zip(*columns.values(), strict=True)))


def mean_verdict(differences: CampaignDifferences) -> str:
    """Return the verdict on the mean over the curves, which a drift of unknown size may explain."""
    mean = differences.mean_of_curves
    if mean is None or not mean.real:
        return NOT_SIGNIFICANT
    return MAY_BE_DRIFT if mean.drift_n is None and unseparated(differences) else SIGNIFICANT


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
    hidden = {id(curve) for curve in hidden_curves(differences)}
    rows: list[tuple[str, ...]] = [
        (
            who(curve),
            in_mm_s(point.v_m_s) + (" *" if point.between else ""),
            *cells(point.friction_n, 1.0, id(curve) in hidden),
        )
        for curve in differences.curves
        if len(curve.points) > 1  # a single point is the mean
        for point in curve.points
    ]
    title = "Friction at each speed (N)"
    if any(point.between for each in differences.curves for point in each.points):
        title += "; * between two speeds of B"
    return difference_table(title, ("Curve", "Velocity (mm/s)"), rows)


def single_points(curves: Iterable[CurveDifference]) -> list[FrictionDifference]:
    """Return the differences at each speed of the curves with several."""
    several = (curve for curve in curves if len(curve.points) > 1)
    return [point for curve in several for point in curve.points]


def who(pair: CurveDifference) -> str:
    """Write label, kind, direction and load of a curve."""
    load = load_words(pair.a.f_load_n, pair.a.p_lr_ref_pa)
    words = (label_of(pair), kind_words(pair.a), DIRECTION_WORDS[pair.direction], load)
    return ", ".join(dict.fromkeys(filter(None, words)))  # a label may be the direction
