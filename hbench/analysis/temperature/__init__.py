"""Friction and the temperature of the oil."""
