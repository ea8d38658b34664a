"""Atomic writes and bounded reads."""
