"""Friction laws identified from a campaign and verified in a model of its bench."""
