"""Tustin's law, fitted with the default settings and written out."""

import numpy as np

from hbench.analysis.fitting.fit import fit_law
from hbench.analysis.fitting.tustin import TUSTIN_LAW
from hbench.config.fitting import TABLE_6_1, Fitting


def fit_tustin(curve, bounds=None):
    """The Tustin law (3.2) fitted to a curve; within the bounds of table 6.1 if none are given."""
    return fit_law(TUSTIN_LAW, [curve], Fitting(), bounds or dict(TABLE_6_1))


def stribeck(v, f_c, f_s, v_s, b):
    """Equation 3.2 for v >= 0, written out for made data and other libraries."""
    return f_c + (f_s - f_c) * np.exp(-v / v_s) + b * v
