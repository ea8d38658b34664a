"""Friction laws fitted to curves."""
