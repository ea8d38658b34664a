"""Definitions of the words and columns of a diagnosis's page."""

import re

from hbench.records import Diagnosis
from hbench.records.reconcile.diagnosis import (
    LEAST_EXPLAINED,
    LEAST_SIZE,
    LEVEL_SCATTER,
    SIGNIFICANT_P,
    UNEXPLAINED_GAP,
)
from hbench.report.diagnosis.names import EDGES, in_words, of_strokes
from hbench.report.diagnosis.words.change import wrong_readings
from hbench.report.diagnosis.words.error import scatter_words
from hbench.sentences import capital

Fact = tuple[str, str]  # name and description
_AT_REFERENCE = re.compile(r"p_0 = (\d+) bar")

SENSOR = (
    "An effect of a sensor is an error of the measurement, not of the bench. Correct the "
    "instrument rather than the model."
)
REFITTED = (
    "They are fitted first, and again with each effect, so that their errors do not appear as "
    "effects."
)
REFUSED = (
    "A refit is kept only if it reduces the gap of runs outside the fit, by whatever amount. So "
    "this page compares the measurement with the model as given.{fitted}"
)
FITTED_WITH = " With the {added}, the values are fitted again: model.yaml has those."
RUNS = (
    "The gap of a single run includes its own scatter: a model with exact values has 1. The last "
    "columns show the flow or force and the signals with the largest gaps, for the final model. "
    "gaps_by_run.csv beside this page contains every run and signal."
)
NUMBERS = (
    "diagnosis.json and gaps_by_run.csv contain all numbers, also those of folded tables, which "
    "are not printed. The folder figures has each figure as SVG and its data as CSV."
)
NEXT_FILE = "next.yaml is the schedule that is proposed."
WHICH: tuple[Fact, ...] = (
    ("Score", "Gain of log-likelihood in nats (natural logarithm) by cross-validation: each fifth "
     "of the operating points of the fit is predicted from the others. It also counts changes from "
     "window to window, as at a step or after a reversal, which a gap hardly shows."),
    ("Explains", "Share of the gap beyond the repeatability that the effect removes there, in the "
     "quantities that it changes alone. A candidate can have a large share and a score near 0: the "
     "score counts all quantities and the uncertainty of the fit, and the refitted values of the "
     "model predict these points as well without the effect."),
    ("Size", "Its largest coefficient relative to a typical one; a dash without a gain."),
    ("Named", "An effect whose score exceeds the limit beside it in the table, that explains more "
     f"than {100 * LEAST_EXPLAINED:g} %, and whose size is at least {LEAST_SIZE:g} of a typical "
     "one. Of several, the one with the highest score."),
)  # fmt: skip
_GAP = (
    "Root mean square of measurement less model, in multiples of the repeatability: the standard "
    "deviation over repeated trials. 1 is as close as the bench repeats."
)
_EFFECTS_GAPS = (
    "Of the quantities that the effect changes. The level of dry friction may differ by some "
    f"{100 * LEVEL_SCATTER:g} % from run to run: such differences are not counted here, but in "
    "all other gaps."
)
_DRAWN = "Means over windows of 0.16 s are compared. Gaps below 0.3 are drawn at 0.3."
_BALANCES = (
    "Flows and forces",
    "The quantities that decide, computed from the measured signals and compared with the model: "
    "the oil flow into each {chamber} (continuity), the force balance of {cylinder}, the "
    "derivative of the position against the velocity, and the supply pressure. They need no "
    "simulation.",
)
_OF_LOAD = ("flow_lp", "flow_lr", "force_load")
_STROKES = (
    "Pairs of strokes",
    "Pairs of steady strokes, one in each direction at one load. Half the difference of their "
    "residual forces is friction; their mean is what does not turn with the direction, such as an "
    "offset or a wrong gain of the load cell.",
)
_MOTION = (
    "Force balance",
    "Newton's law of the driven mass: the force of the drive less the applied force, friction and "
    "inertia. It is evaluated along the measured logs, and it decides. Its repeatability is the "
    "noise of the measured signals and the change of friction from run to run.",
)
_SIGNALS = (
    "The same schedule, simulated in closed loop, and runs outside the fit in open loop. They "
    "check the revised model; the verdict does not depend on them, and no expected gap is "
    "computed for them."
)
_REFITTED_STAGE = "The model with its poorly known values fitted, and no effect added."
_EXPECTED = (
    "Gap that a correct model has on average: its fitted values are uncertain, and trials differ "
    "by more at some operating points than at others. It is no lower limit: a fit can come closer."
)
_LEAVE_ONE_OUT = (
    "Each load in turn, predicted with values that were fitted to the other loads. The effects "
    "were chosen with all loads."
)
_POINT = (
    "At the working point",
    "The measured operating point that is nearest to the median speed, load and pressures, in "
    "steady motion. The 95 % interval is that of the effect's coefficients.",
)
_ALONG = (
    "Along the logs",
    "Over all measured motion, in windows of 0.16 s: the root mean square, and the value that 5 % "
    "of the windows exceed.",
)
_ALONG_STROKES = ("Along the logs", "Over all pairs of strokes, in the same way.")
_SIGNS = (
    "Signs",
    "A flow is positive into its chamber, friction against the motion. The speed changes at the "
    "same commands and pressures; the pressure, which is that of the fed chamber, at the same "
    "speed and load.",
)
_PARTS_OF_MASS = "= test or load", "that of the mass"  # in a law
_SIGNS_OF_MASS = ("Signs", "A force is positive against the motion.")
_COMPUTED = (
    "Error of an instrument",
    "It changes the readings, and the friction and the flows that are computed from them. At the "
    "bench nothing is different.",
)
_ALL_RUNS = (
    "All runs",
    "The gaps and deviations of this section are of all runs, those of the section on the gap of "
    "the runs outside the fit alone.",
)
_PROBABILITY = (
    "Probability of such a deviation with a correct model, corrected after Holm for the number of "
    "quantities."
)
_P = (
    "p (Holm)",
    f"{_PROBABILITY} What the trials of an operating point have in common is compared with what "
    "differs between them (F test). Where a point has one run, its halves are taken as trials.",
)
_P_OF_STROKES = (
    "p (Holm)",
    f"{_PROBABILITY} It is computed from 999 random draws, so the smallest possible value is 0.001 "
    "times this number.",
)
_P_OF_MOTION = (
    "p (Holm)",
    "Probability that as many runs deviate by more than the noise if the model is correct: then "
    "half of them do (sign test).",
)
_DEVIATION = (
    "Deviation",
    "Root mean square of measurement less model, without the noise of single windows, but with "
    "the scatter from trial to trial. Up to the limit in the table it does not matter. A dash: not "
    "distinguishable from that noise.",
)
_SCATTER_OF_STROKES = (
    "Repeatability",
    "Standard deviation over repeated trials, root mean square over the loads.",
)
_DEVIATION_OF_STROKES = (
    "Deviation",
    "Root mean square of the residual over all pairs of strokes, with their scatter.",
)
_RANGE = (
    "Range",
    "Largest magnitude of the quantity in these runs: of a flow, the largest speed times the "
    "driven area; of a force, that of the load cell.",
)
_ALLOWED = (
    "Tolerances allow without refit",
    "Deviation that sensors within their tolerances may cause in a model that is not refitted. The "
    "refit includes them (offset, gain and drift): what remains has another cause, even if it is "
    "smaller. A dash: no tolerance changes it.",
)
_UNEXPLAINED = (
    "Limit for an unknown effect",
    "A quantity is reported as unexplained where its deviation is significant (p below "
    f"{SIGNIFICANT_P:g}, not the 0.05 of other pages, since it must matter as well) and large "
    f"enough to matter, and is more than {UNEXPLAINED_GAP:g} times the repeatability.",
)
_EDGE = (
    "Metering edge",
    "Edge of the valve's spool that connects the chamber with the supply or the tank. Where one "
    "gap is much larger, inspect that edge.",
)


def poorly_known(diagnosis: Diagnosis) -> str:
    """Return which values of the model are fitted."""
    values = "levels of friction, a valve's gain, dead volumes and the like"
    if diagnosis.errors:
        values = "the levels of friction and the moving mass"
    elif of_strokes(diagnosis):
        values = "the levels of friction"
    return f"Poorly known values of the model file are {values}."


def of_gaps(diagnosis: Diagnosis) -> tuple[Fact, ...]:
    """Return the definitions of the section on the gap of held-out runs."""
    strokes = of_strokes(diagnosis)
    held_out = _LEAVE_ONE_OUT if strokes else _not_fitted(diagnosis)
    gap, expected = of_numbers(diagnosis)
    every = (
        gap,
        _MOTION if diagnosis.errors else _STROKES if strokes else _balances(diagnosis),
        *([("Signals", _SIGNALS)] if diagnosis.gap_heldout.signals else []),
        *([] if diagnosis.refit_refused else [("Refitted", _REFITTED_STAGE)]),
        expected,
        ("Loads outside the fit" if strokes else "Runs outside the fit", held_out),
    )
    elsewhere = (gap, expected) if diagnosis.held_out_loads else ()
    return tuple(fact for fact in every if fact not in elsewhere)


def _balances(diagnosis: Diagnosis) -> Fact:
    """Return what is compared along logs: of both cylinders, or of a single one."""
    both = any(gap.name in _OF_LOAD for gap in diagnosis.where)
    chamber, cylinder = ("of the four chambers", "either cylinder") if both else (
        "chamber of the cylinder", "the cylinder"
    )  # fmt: skip
    name, words = _BALANCES
    return name, words.format(chamber=chamber, cylinder=cylinder)


def of_numbers(diagnosis: Diagnosis) -> tuple[Fact, Fact]:
    """Return the definitions of the gaps in numbers, which only these need for strokes."""
    drawn = "" if diagnosis.errors or of_strokes(diagnosis) else _DRAWN
    gap = f"{_GAP} {scatter_words(diagnosis) or drawn}".strip()
    return ("Gap", gap), ("Expected", _EXPECTED)


def _not_fitted(diagnosis: Diagnosis) -> str:
    return f"Not used for the fit: {', '.join(diagnosis.heldout_runs)}."


def of_deviations(diagnosis: Diagnosis) -> tuple[Fact, ...]:
    """Return the definitions of the section on where the model disagrees."""
    if of_strokes(diagnosis):
        return _P_OF_STROKES, _SCATTER_OF_STROKES, _DEVIATION_OF_STROKES
    p_value = _P_OF_MOTION if diagnosis.errors else _P
    edges = (_EDGE,) if any(gap.name in EDGES for gap in diagnosis.where) else ()
    return _ALL_RUNS, p_value, _DEVIATION, _RANGE, _ALLOWED, _UNEXPLAINED, *edges


def of_changes(diagnosis: Diagnosis) -> tuple[Fact, ...]:
    """Return how the tables of changes are to be read; empty without any."""
    if not diagnosis.practice:
        return ()
    computed = (_COMPUTED,) if any(map(wrong_readings, diagnosis.practice)) else ()
    if of_strokes(diagnosis):
        return _POINT, _ALONG_STROKES, *computed
    return _POINT, _ALONG, _SIGNS_OF_MASS if diagnosis.errors else _SIGNS, *computed


def of_laws(diagnosis: Diagnosis) -> tuple[Fact, ...]:
    """Return the law of each effect that was added, by whose symbols its coefficients are meant."""
    return tuple(
        (f"Law of {in_words(effect.name)}", f"{capital(_as_printed(law))}.")
        for effect in diagnosis.effects
        if (law := effect.law.replace(*_PARTS_OF_MASS) if diagnosis.errors else effect.law)
    )


def of_effects_gaps(diagnosis: Diagnosis) -> tuple[Fact, ...]:
    """Return which gaps the table of the effects has, if they differ from the others."""
    if not diagnosis.effects or diagnosis.errors or of_strokes(diagnosis):
        return ()
    return (("Gap without it, with it", _EFFECTS_GAPS),)


def _as_printed(law: str) -> str:
    """Return a formula with a minus sign and raised exponents."""
    if (power := _AT_REFERENCE.search(law)) and "G p_0" in law:  # the flow that pages state
        flow = f"Q_{power[1]}"
        law = law.replace("G p_0", flow).replace("G = ", f"{flow} = ")
    return law.replace(" - ", " − ").replace("^2", "²").replace("^n", "ⁿ")
