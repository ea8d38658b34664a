"""Readers of foreign files: one file a format, and the table of all formats."""
