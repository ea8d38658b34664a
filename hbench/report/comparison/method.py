"""What the tables of a comparison contain, and how it was computed."""

from hbench.records import CampaignDifferences
from hbench.records.numbers import SIGNIFICANCE
from hbench.report.comparison.cells import MAY_BE_DRIFT, P_TRIALS, TRIALS
from hbench.report.comparison.tables import (
    has_drift_column,
    hidden_curves,
    speeds_table,
    unseparated,
)
from hbench.report.comparison.verdict import drift_words
from hbench.sentences import capital

_U = (
    "Expanded uncertainty{coverage}: of the trials, the instruments and any significant drift "
    "within a campaign, without a new mounting of the cylinder. U of A and of B also contains the "
    "errors of the instruments that cancel in B − A, which is computed from unrounded values."
)
_COVERAGE = " for a coverage probability of 95 %"
_FACTOR = " with the coverage factor k = 2 that the campaigns state"
_OF_ONE = ", that of {name} with the coverage factor k = 2 that it states"
_READ_TRIALS = (("± trials", "Half-width of the 95 % interval of the trials alone."),)
_MEAN = "Its p is that of a single test of independent trials."
_MEAN_U = (
    " In U the trials are independent, and the error of an instrument is the same in all curves of "
    "a campaign: it is added with its sign, so that it cancels in part between the directions."
)
_DRIFT = (
    ("Drift up to", "Largest change of this difference by a drift within the campaigns that the "
     "trials do not exclude. Where it exceeds the difference less U, the verdict on friction and "
     f"on efficiency is “{MAY_BE_DRIFT}”."),
)  # fmt: skip
_UNKNOWN_DRIFT = (
    (capital(MAY_BE_DRIFT), "The part of a drift within the campaigns in this difference is not "
     "known, as with runs without times, and no plan of the runs excludes it."),
)  # fmt: skip
SET_UP = (
    "Where the strokes of one file are trials, their interval does not contain what mounting a "
    "seal again would change."
)
_P = (
    P_TRIALS,
    "Probability of a difference this large between equal cylinders, by the trials alone, "
    "corrected after Holm for the number of differences of its kind. A difference is significant "
    f"where p is below {SIGNIFICANCE:g} and the difference exceeds its U.",
)
_METHOD = (
    ("Friction", "A point is the mean of its trials, as a magnitude. The interval by the trials is "
     "that of Welch's t."),
    _P,
    ("Speeds", "Speeds within 2 % count as the same, and within 20 % where no speed was set, as in "
     "strokes cut from a cycle. If a campaign has several labels, curves of equal labels are "
     "compared."),
    ("Means", "A mean has equal weights at all speeds of A that B has too, or that lie between two "
     "speeds of B. Steady runs count as independent, although drift may link those of a pass. The "
     "points of a ramp or of steps come from the same strokes, so each trial counts once, with its "
     "mean."),
    ("Drift", "A drift is a straight line over the time of a campaign, estimated from trials of "
     "the same point at different times. It changes the mean of a curve by its rate times the time "
     "between the curve and the middle of the campaign. Where both campaigns have the same order "
     "of runs, only the difference of their drifts counts; in the mean over all curves a drift "
     "cancels within each campaign. comparison.json contains the part of each difference."),
)  # fmt: skip
_OF_BREAKAWAY = (
    "Breakaway",
    "Compared in the same direction, at the same load, after the same time at rest and at the same "
    "rate of the force. It is tested as a point is.",
)
_BANDS = (
    "Compared at equal loads, or at pressures within 5 %. Half bands, middles and energies are "
    f"tested by their trials, slopes by their standard errors. {SET_UP}"
)


def read_facts(differences: CampaignDifferences) -> tuple[tuple[str, str], ...]:
    """Return what the uncertainties of the tables of means contain."""
    tested = [each for curve in differences.curves for each in (curve.mean_n, curve.efficiency)]
    tested += [each.breakaway_n for each in differences.breakaways]
    known = any(each is not None and each.u95 is not None for each in tested)
    if not known:
        return _READ_TRIALS
    both = TRIALS in speeds_table(differences).head
    return (("U", _U.format(coverage=_coverage(differences))), *(_READ_TRIALS if both else ()))


def _coverage(differences: CampaignDifferences) -> str:
    """Return the coverage probability of U, or the factor that the instruments' files state."""
    stated = [
        name
        for name, each in (("A", differences.a), ("B", differences.b))
        if each.settings.get("instruments", {}).get("expansion") == "k_2"
    ]
    if len(stated) == 2:
        return _FACTOR
    return _COVERAGE + "".join(_OF_ONE.format(name=name) for name in stated)


def p_fact() -> tuple[str, str]:
    """Return what p is, and that it does not decide alone."""
    return _P


def mean_facts(differences: CampaignDifferences) -> tuple[tuple[str, str], ...]:
    """Return how the mean over the curves is tested, and what a drift does to it."""
    mean = differences.mean_of_curves
    if mean is None:
        return ()
    of_u = _MEAN_U if mean.u95_a is not None and mean.u95_b is not None else ""
    facts = [("Mean over all curves", _MEAN + of_u)]
    if unseparated(differences) and mean.real and (words := drift_words(differences)):
        facts.append(("Drift", words))
    return tuple(facts)


def drift_facts(differences: CampaignDifferences) -> tuple[tuple[str, str], ...]:
    """Return what the column of the drift is, or why a difference may come from one."""
    if has_drift_column(differences):
        return _DRIFT
    return _UNKNOWN_DRIFT if hidden_curves(differences) else ()


def method_facts(differences: CampaignDifferences) -> tuple[tuple[str, str], ...]:
    """Return how friction, means, tests and drifts were computed."""
    bands = (("Bands", _BANDS),) if differences.bands else ()
    breakaway = (_OF_BREAKAWAY,) if differences.breakaways else ()
    return (*(_METHOD if differences.curves else (_METHOD[0], _P)), *bands, *breakaway)
