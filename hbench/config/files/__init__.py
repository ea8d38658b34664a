"""YAML files read safely, with errors that name file, line, key, value and limit."""
