"""Suggested import map as YAML text, with a comment on each choice."""
