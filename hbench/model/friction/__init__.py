"""Friction laws of one cylinder: static, dynamic, and the table of all."""
