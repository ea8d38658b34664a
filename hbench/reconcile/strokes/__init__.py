"""Diagnosis from steady strokes alone, for logs without valve commands."""
