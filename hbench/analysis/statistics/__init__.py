"""Least squares, intervals and tests that know nothing of hydraulics."""
