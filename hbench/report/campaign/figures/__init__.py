"""Figures of a campaign, one file a subject."""
