"""One number among many campaigns: its spread, its trend, and which campaigns stand out.

A campaign's number x_i is taken as

    x_i = m + b_i + e_i ,   b_i ~ N(0, tau^2) from cylinder to cylinder,   e_i ~ N(0, s_i^2)

with s_i the standard error of the campaign's own trials where it is more than three times the
median of all, and else the root mean square of all others: with three trials each, most of what
tells their standard errors apart is chance. Errors of the instruments, the same in all campaigns of
a bench, take no part. m is the median, or Theil and Sen's line where there is a trend, and tau
solves

    median |x_i - m| / sqrt(tau^2 + s_i^2) = 0.6745

so that up to half of the campaigns may be anything. z_i = (x_i - m) / sqrt(tau^2 + s_i^2) is judged
by Student's distribution with 0.37 (n - 1) degrees of freedom, since a median of deviations is as
sharp as a standard deviation of 37 % of the values (Huber, Robust Statistics, 1981, section 5.1).
"""

from typing import NamedTuple

import numpy as np
from scipy.special import stdtr
from scipy.stats import kendalltau, theilslopes

from hbench.analysis.rounding import ROUNDING, is_constant, merged

FEWEST = 10  # campaigns that are judged at all
_MEDIAN = 0.6745  # of |z| for a normal z
_SHARP = 0.37
_NOISY = 3.0
_MOST_PAIRS = 1000  # values of which all pairs are taken; more are grouped to as many medians
_BISECTIONS = 200
_MOST_BINS, _FEWEST_BINS = 40, 8
_REACH = 6.0  # standard deviations that a histogram shows on each side


class Standing(NamedTuple):
    """How each campaign stands among the others."""

    between: float  # tau
    own: np.ndarray  # (n,) s_i as it counts
    z: np.ndarray  # (n,)
    p: np.ndarray  # (n,) of a value this far off, two-sided, for one campaign


class Line(NamedTuple):
    """A straight line, and how sure its slope is."""

    slope: float
    low: float  # 95 %
    high: float
    intercept: float
    p: float  # of no slope


def standing(x: np.ndarray, se: np.ndarray, centre: np.ndarray | float) -> Standing:
    """Return how the numbers x (n,) stand about ``centre``.

    ``se`` (n,) are the standard errors of their own trials, NaN where they are not known.
    """
    own = _own_scatter(se)
    away = np.abs(x - centre)
    away[away <= ROUNDING * np.abs(x)] = 0.0
    between = _between(away, own)
    total = np.hypot(between, own)
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.where(away > 0, (x - centre) / total, 0.0)
    p = 2 * stdtr(_SHARP * max(len(x) - 1, 1), -np.abs(z))
    return Standing(between, own, z, p)


def _own_scatter(se: np.ndarray) -> np.ndarray:
    known = se[np.isfinite(se)]
    if not len(known):
        return np.zeros(len(se))
    noisy = np.nan_to_num(se, nan=0.0, posinf=0.0) > _NOISY * np.median(known)
    pooled = np.sqrt(np.mean(se[np.isfinite(se) & ~noisy] ** 2))
    return np.where(noisy, se, pooled)


def _between(away: np.ndarray, own: np.ndarray) -> float:
    def middle(tau: float) -> float:
        with np.errstate(divide="ignore", invalid="ignore"):
            return float(np.median(np.where(away > 0, away / np.hypot(tau, own), 0.0)))

    low, high = 0.0, float(np.median(away)) / _MEDIAN
    if middle(low) <= _MEDIAN:
        return low
    for _ in range(_BISECTIONS):
        between = (low + high) / 2
        if between in (low, high):
            break
        low, high = (between, high) if middle(between) > _MEDIAN else (low, between)
    return high


def line(t: np.ndarray, x: np.ndarray) -> Line | None:
    """Return Theil and Sen's line through x (n,) over t (n,); None where there is no telling.

    Its interval and p are those of Kendall's tau. Of many values, medians of those that follow
    each other are taken.
    """
    if len(x) < FEWEST:
        return None
    order = np.argsort(t, kind="stable")
    t, x = t[order], x[order]
    if len(x) > _MOST_PAIRS:
        parts = np.array_split(np.arange(len(x)), _MOST_PAIRS)
        t = np.array([t[part].mean() for part in parts])
        x = np.array([np.median(x[part]) for part in parts])
    if t[0] == t[-1] or is_constant(x):
        return None
    found = theilslopes(x, t)
    return Line(
        float(found.slope),
        float(found.low_slope),
        float(found.high_slope),
        float(found.intercept),
        float(kendalltau(t, merged(x)).pvalue),
    )


def histogram(x: np.ndarray) -> tuple[np.ndarray, np.ndarray, int, int]:
    """Return edges and counts over the bulk of x (n,), and how many lie below and above it.

    The bins are Freedman and Diaconis's, of bounded number; what is further from the median than
    six (robust) standard deviations is counted, not shown.
    """
    middle = float(np.median(x))
    sigma = float(np.median(np.abs(x - middle))) / _MEDIAN
    reach = _REACH * sigma if sigma > 0 else np.inf
    low, high = max(float(x.min()), middle - reach), min(float(x.max()), middle + reach)
    if low == high:
        low, high = low - max(abs(low), 1.0) * 1e-3, high + max(abs(high), 1.0) * 1e-3
    width = 2 * float(np.subtract(*np.percentile(x, [75, 25]))) / len(x) ** (1 / 3)
    wanted = (high - low) / width if width > 0 else _FEWEST_BINS
    bins = int(np.clip(np.ceil(wanted), _FEWEST_BINS, _MOST_BINS))
    counts, edges = np.histogram(x, bins, (low, high))
    return edges, counts, int((x < low).sum()), int((x > high).sum())
