"""Runs and curves for other programs."""
