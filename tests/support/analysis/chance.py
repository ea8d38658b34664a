"""How many of so many random samples may show what a share of them shows."""

from scipy import stats


def binomial_limits(count: int, share: float, level: float = 0.95) -> tuple[float, float]:
    """Return the least and the largest number of ``count`` samples, with equal tails.

    Right code stays within the limits in ``level`` of the seeds.
    """
    return stats.binom.interval(level, count, share)
