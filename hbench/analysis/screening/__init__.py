"""Calibrated runs, and the verdict on each."""
