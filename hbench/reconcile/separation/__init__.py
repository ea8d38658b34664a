"""Separation of effects by runs, made or planned."""
