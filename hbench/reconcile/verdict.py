"""Verdict of a search."""

from collections.abc import Sequence

from hbench.analysis.rounding import distinct_texts
from hbench.reconcile.acceptance import ALIKE, CRITERIA, ambiguity_margin
from hbench.reconcile.search_result import SearchResult, SmallEffects
from hbench.records import Candidate, Gap, Verdict
from hbench.records.reconcile.diagnosis import TOLERATED, UNEXPLAINED_GAP
from hbench.sentences import listed, plural

NO_RESIDUALS = (
    "No quantity has residuals that are significant, large enough to matter and more than "
    f"{UNEXPLAINED_GAP:g} times the repeatability."
)


def decide_verdict(result: SearchResult, unexplained: Sequence[Gap]) -> tuple[Verdict, str]:
    """Return the verdict and its reason.

    ``unexplained`` are the gaps of the model with all effects and without learned laws.
    """
    first, last = result.steps[0], result.steps[-1]
    unnamed = _unnamed(result)
    if result.names:
        reason = named_words(result.names, tuple(result.unconfirmed))
        if last.ambiguous:
            others = " or ".join(candidate.name for candidate in last.ambiguous)
            reason += f" {others} would explain the remaining residuals equally well."
        elif unexplained:
            reason += (
                f" Gaps that remain (in multiples of the repeatability): {_gap_list(unexplained)}."
            )
        return "named", reason + unnamed
    if last.ambiguous:
        margin = ambiguity_margin(last.ambiguous[0].score)
        return "ambiguous", (
            f"Not distinguishable, scores in nats: {scores(last.ambiguous)}. A score decides where "
            f"it is {margin:.1f} nats (a tenth of the best one, at least 3) above the next, or "
            f"{ALIKE * margin:.1f} where these runs are not expected to distinguish both."
        )
    if unexplained:
        reason = unexplained_words(unexplained)
        if first.evaluated:
            best = first.evaluated[0].candidate
            reason += (
                f" The best candidate, {best.name}, explains {100 * best.explained:.0f} % in "
                f"cross-validation ({100 * CRITERIA.explained:.0f} % needed; score "
                f"{best.score:.1f} nats, {best.threshold:.1f} needed)."
            )
            if best.score > best.threshold and best.size == 0.0:
                reason += f" It is not named: {TOLERATED}."
            elif best.score > best.threshold and best.size < CRITERIA.size:
                size, needed = distinct_texts(best.size, CRITERIA.size)
                reason += (
                    f" It is too small to be named: {size} of a typical size, {needed} needed."
                )
            elif best.name in result.ruled_out:
                reason += f" It is not named: refined, {result.ruled_out[best.name]}."
        return "unknown", reason + unnamed
    return "none", _small_words(result.small) if result.small else NO_RESIDUALS


def _small_words(small: SmallEffects) -> str:
    """Return the sentence about effects that explain what would otherwise be unexplained."""
    sizes = [f"{step.added} ({step.added_size:.2g} of a typical size)" for step in small.steps]
    explain = plural(len(sizes), "explains", "explain")
    return (
        f"{listed(sizes)} {explain} all residuals that are large enough to matter, and "
        f"{plural(len(sizes), 'is', 'are')} too small to be named ({CRITERIA.size:g} needed)."
    )


def _unnamed(result: SearchResult) -> str:
    """Return the sentence about learned laws; empty without any."""
    tables = [result.final.hypothesis.tables[law.table] for law in result.laws]
    words = [f"{table.adds_to} over {listed(list(table.knots))}" for table in tables]
    laws = "unnamed laws" if len(words) > 1 else "an unnamed law"
    return f" The revised model contains {laws}: {'; '.join(words)}." if words else ""


def named_words(names: Sequence[str], unconfirmed: Sequence[str]) -> str:
    """Return the sentences about named effects, and those that held-out runs do not confirm."""
    explain = plural(len(names), "explains", "explain")
    words = f"{listed(names)} {explain} the residuals in cross-validation."
    if not unconfirmed:
        return words
    return (
        f"{words} Runs outside the fit do not confirm {listed(unconfirmed)}, so the revised model "
        f"does not contain {plural(len(unconfirmed), 'it', 'them')}."
    )


def unexplained_words(gaps: Sequence[Gap]) -> str:
    """Return the sentence about gaps that no effect explains."""
    return (
        "No effect of the catalogue explains the gaps (in multiples of the repeatability): "
        f"{_gap_list(gaps)}."
    )


def scores(candidates: Sequence[Candidate]) -> str:
    """Return candidates with their scores in nats."""
    return ", ".join(f"{candidate.name} ({candidate.score:.0f})" for candidate in candidates)


def _gap_list(gaps: Sequence[Gap]) -> str:
    """Return balances with their gaps."""
    return ", ".join(f"{gap.name} ({gap.gap:.1f})" for gap in gaps)
