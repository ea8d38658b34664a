"""Reconciliation of imported steady strokes."""
