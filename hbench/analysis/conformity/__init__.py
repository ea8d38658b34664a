"""Conformity of a cylinder: measured quantities, and decisions under uncertainty."""
