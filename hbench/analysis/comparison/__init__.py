"""Comparison of campaigns: two side by side, or one among many."""
