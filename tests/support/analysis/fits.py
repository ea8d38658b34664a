"""Fits with the default settings."""

from hbench.analysis.fitting.fit import fit_law
from hbench.analysis.fitting.tustin import TUSTIN_LAW
from hbench.config.fitting import TABLE_6_1, Fitting


def fit_tustin(curve, bounds=None):
    """The Tustin law (3.2) fitted to a curve; within the bounds of table 6.1 if none are given."""
    return fit_law(TUSTIN_LAW, [curve], Fitting(), bounds or dict(TABLE_6_1))
