"""Acceptance of a cylinder as text, JSON and JUnit XML."""
