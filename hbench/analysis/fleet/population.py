"""Statistics of one quantity over many campaigns: spread, trend, deviations of single campaigns.

The model of a campaign's value x_i is

    x_i = m + b_i + e_i ,   b_i ~ N(0, tau^2) from cylinder to cylinder,   e_i ~ N(0, s_i^2)

with s_i the standard error of the campaign's trials if it is more than three times the median of
all, and else the root mean square of all others: with three trials each, the standard errors differ
mostly by chance. Instrument errors are equal in all campaigns of a bench and are left out. m is the
median, or the Theil-Sen line if there is a trend, and tau solves

    median |x_i - m| / sqrt(tau^2 + s_i^2) = 0.6745

so that up to half of the campaigns may be outliers. The p-value of
z_i = (x_i - m) / sqrt(tau^2 + s_i^2) is that of Student's distribution with 0.37 (n - 1) degrees of
freedom, since a median absolute deviation is as precise as the standard deviation of 37 % of the
values (Huber, Robust Statistics, 1981, section 5.1). With the same degrees of freedom nu, the 95 %
interval of tau is that of a variance, by the quantiles of the chi-squared distribution:

    tau^2 from (tau^2 + s^2) nu / chi2_0.975 - s^2  to  (tau^2 + s^2) nu / chi2_0.025 - s^2

with s the median of the s_i, and zero in place of a negative number.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import chdtri, stdtr, stdtrit

from hbench.analysis.rounding import ROUNDING, is_constant, merged
from hbench.motion.noise import NORMAL_MEDIAN, robust_sigma
from hbench.records import FEWEST_CAMPAIGNS
from hbench.records.numbers import SIGNIFICANCE

_EFFICIENCY = 0.37  # of the median absolute deviation against the standard deviation
_NOISY = 3.0  # times the median standard error
_MOST_PAIRS = 1000  # values whose pairs are all taken; more are grouped to as many medians
_BISECTIONS = 200
_MOST_BINS, _FEWEST_BINS = 40, 8
_REACH = 6.0  # standard deviations that a histogram shows on each side


class RobustDeviations(NamedTuple):
    """Deviations of the campaigns' values from their centre, in standard deviations."""

    between: float  # tau
    within: np.ndarray  # (n,) s_i as used
    z: np.ndarray  # (n,)
    p: np.ndarray  # (n,) two-sided, for one campaign
    between_low: float  # 95 % interval of tau
    between_high: float


class TrendLine(NamedTuple):
    """Theil-Sen line, with the 95 % interval of its slope."""

    slope: float
    low: float
    high: float
    intercept: float
    p: float  # of zero slope


def robust_deviations(
    x: np.ndarray, se: np.ndarray, centre: np.ndarray | float
) -> RobustDeviations:
    """Return the deviations of the values x (n,) from ``centre``.

    ``se`` (n,) are the standard errors of each campaign's trials, NaN if not known.
    """
    within = _within_scatter(se)
    distance = np.abs(x - centre)
    distance[distance <= ROUNDING * np.abs(x)] = 0.0
    between = _between_scatter(distance, within)
    total = np.hypot(between, within)
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.where(distance > 0, (x - centre) / total, 0.0)
    p = 2 * stdtr(_freedom(len(x)), -np.abs(z))
    return RobustDeviations(between, within, z, p, *_between_interval(between, within))


def outlier_limit(n: int, tests: int) -> float:
    """Return the |z| of a value of n campaigns whose p, times ``tests``, is ``SIGNIFICANCE``."""
    return -float(stdtrit(_freedom(n), SIGNIFICANCE / 2 / tests))


def _freedom(n: int) -> float:
    return _EFFICIENCY * max(n - 1, 1)


def _between_interval(between: float, within: np.ndarray) -> tuple[float, float]:
    own = float(np.median(within)) ** 2
    freedom = _freedom(len(within))
    spread = (between**2 + own) * freedom
    low, high = (spread / float(chdtri(freedom, tail)) - own for tail in (0.025, 0.975))
    return float(np.sqrt(max(low, 0.0))), float(np.sqrt(max(high, 0.0)))


def _within_scatter(se: np.ndarray) -> np.ndarray:
    known = se[np.isfinite(se)]
    if not len(known):
        return np.zeros(len(se))
    noisy = np.nan_to_num(se, nan=0.0, posinf=0.0) > _NOISY * np.median(known)
    pooled = np.sqrt(np.mean(se[np.isfinite(se) & ~noisy] ** 2))
    return np.where(noisy, se, pooled)


def _between_scatter(distance: np.ndarray, within: np.ndarray) -> float:
    def median_z(tau: float) -> float:
        with np.errstate(divide="ignore", invalid="ignore"):
            return float(np.median(np.where(distance > 0, distance / np.hypot(tau, within), 0.0)))

    low, high = 0.0, robust_sigma(distance)
    if median_z(low) <= NORMAL_MEDIAN:
        return low
    for _ in range(_BISECTIONS):
        between = (low + high) / 2
        if between in (low, high):
            break
        low, high = (between, high) if median_z(between) > NORMAL_MEDIAN else (low, between)
    return high


def trend_line(t: np.ndarray, x: np.ndarray) -> TrendLine | None:
    """Return the Theil-Sen line through x (n,) over t (n,).

    Interval and p-value are those of Kendall's tau. Many values are first reduced to medians of
    consecutive groups. Returns None for too few values, or for constant t or x.
    """
    if len(x) < FEWEST_CAMPAIGNS:
        return None
    order = np.argsort(t, kind="stable")
    t, x = t[order], x[order]
    if len(x) > _MOST_PAIRS:
        groups = np.array_split(np.arange(len(x)), _MOST_PAIRS)
        t = np.array([t[group].mean() for group in groups])
        x = np.array([np.median(x[group]) for group in groups])
    if t[0] == t[-1] or is_constant(x):
        return None
    from scipy.stats import kendalltau, theilslopes  # slow import

    line = theilslopes(x, t)
    return TrendLine(
        float(line.slope),
        float(line.low_slope),
        float(line.high_slope),
        float(line.intercept),
        float(kendalltau(t, merged(x)).pvalue),
    )


def histogram(x: np.ndarray) -> tuple[np.ndarray, np.ndarray, int, int]:
    """Return edges and counts over the bulk of x (n,), and the numbers of values below and above.

    The bin width is Freedman and Diaconis's, the number of bins is bounded. Values more than six
    (robust) standard deviations from the median are counted as below or above.
    """
    middle = float(np.median(x))
    sigma = robust_sigma(x - middle)
    reach = _REACH * sigma if sigma > 0 else np.inf
    low, high = max(float(x.min()), middle - reach), min(float(x.max()), middle + reach)
    if low == high:
        low, high = low - max(abs(low), 1.0) * 1e-3, high + max(abs(high), 1.0) * 1e-3
    width = 2 * float(np.subtract(*np.percentile(x, [75, 25]))) / len(x) ** (1 / 3)
    wanted = (high - low) / width if width > 0 else _FEWEST_BINS
    bins = int(np.clip(np.ceil(wanted), _FEWEST_BINS, _MOST_BINS))
    counts, edges = np.histogram(x, bins, (low, high))
    return edges, counts, int((x < low).sum()), int((x > high).sum())
