"""Balances of the bench evaluated along logged runs."""
