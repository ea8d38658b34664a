"""Balances of the bench, evaluated on logged runs."""
