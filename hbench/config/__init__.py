"""Validated configuration: bench, plant, schedule and import map files."""
