"""Sections of a campaign's report."""
