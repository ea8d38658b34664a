"""Reconciliation of a model with measured runs: residuals, gaps, candidate effects, verdict."""
