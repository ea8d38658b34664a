"""What the refit moves into a balance, which does not show where an unknown cause is."""

from hbench.records import Diagnosis, Gap
from hbench.report.diagnosis.names import added_words, gap_number
from hbench.report.diagnosis.words.deviation import CLEARLY_WORSE


def refit_increases(diagnosis: Diagnosis) -> dict[str, str]:
    """Return the balances whose gap in held-out runs the refit increases, with both gaps in words.

    Empty where the refit was refused, or where effects were added to it.
    """
    if diagnosis.refit_refused or added_words(diagnosis):
        return {}
    return {
        name: f"gap {gap_number(gap.before)} to {gap_number(gap.refitted)}"
        for name, gap in diagnosis.gap_heldout.balances.items()
        if gap.refitted > max(1.0, CLEARLY_WORSE * gap.before)
    }


def unexplained(diagnosis: Diagnosis) -> list[Gap]:
    """Return the gaps that no effect explains; those that the refit increases come last.

    What the refit moves into a balance does not show where the cause is.
    """
    moved = refit_increases(diagnosis)
    return sorted(diagnosis.rest or diagnosis.where[:1], key=lambda gap: gap.name in moved)
