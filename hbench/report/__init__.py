"""Figures, tables and the page of a campaign, from the records alone."""
