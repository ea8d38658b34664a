"""Calibration of runs, and the verdict on each run."""
