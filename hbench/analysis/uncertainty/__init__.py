"""Uncertainty budgets, and the efficiency with its uncertainty."""
