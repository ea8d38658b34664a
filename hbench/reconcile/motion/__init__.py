"""Reconciliation of the motion of a driven mass without hydraulics."""
