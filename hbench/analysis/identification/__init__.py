"""Identification of friction laws from a campaign, with verification in a model of its bench."""
