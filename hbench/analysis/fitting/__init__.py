"""Fits of friction laws to curves."""
