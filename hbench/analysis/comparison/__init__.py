"""Comparison of two campaigns, and statistics of many."""
