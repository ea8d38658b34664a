"""Odds by which the runs of the fit favour an effect over the next best one."""

from collections.abc import Sequence
from math import exp, isfinite

from hbench.records import AddedEffect
from hbench.report.diagnosis.names import in_words
from hbench.report.render.numbers import significant
from hbench.sentences import capital

_MOST_ODDS = 1000.0  # larger ones are not stated: the model of the residuals is not that exact


def odds_words(effect: AddedEffect) -> str:
    """Return how clearly the cross-validation favours an effect over the next best one.

    Where held-out runs do not confirm the effect, the sentence states that too.
    """
    words = favoured(effect)
    if effect.confirmed:
        return f"{capital(words)}."
    return f"In the runs of the fit, {words}; runs outside the fit do not confirm it."


def favoured(effect: AddedEffect) -> str:
    """Return by which odds the runs of the fit favour an effect over the next best one."""
    rival = effect.runner_up
    if rival is None or not isfinite(rival.margin):
        return "no other effect of the catalogue that is possible here explains these residuals"
    return (
        "it predicts each operating point from the others better than the next best explanation, "
        f"{in_words(rival.name)}, by {_ratio(rival.margin)}"
    )


def odds_clause(effect: AddedEffect) -> str:
    """Return by which odds an effect is favoured over the next best one; empty without one."""
    rival = effect.runner_up
    if rival is None or not isfinite(rival.margin):
        return ""
    return (
        f"The data favour it over the next best explanation, {in_words(rival.name)}, by "
        f"{_ratio(rival.margin)}."
    )


def least_odds(effects: Sequence[AddedEffect]) -> str:
    """Return by which odds at least the runs of the fit favour several effects over others."""
    margins = [effect.runner_up.margin for effect in effects if effect.runner_up]
    known = [margin for margin in margins if isfinite(margin)]
    if not known:
        return ""
    return f"Each is favoured over the next best explanation by {_ratio(min(known))}."


def _ratio(nats: float) -> str:
    """Return the odds that correspond to a gain of log-likelihood."""
    odds = exp(min(max(nats, 0.0), 700.0))
    if odds > _MOST_ODDS:
        return f"odds of more than {_MOST_ODDS:.0f} to 1"
    return f"odds of {significant(float(f'{odds:.1e}'), 2)} to 1"
