"""Sections of a logged motion: rest, constant speed, reversals. Arrays in, slices out."""
