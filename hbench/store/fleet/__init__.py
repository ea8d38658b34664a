"""The table of a fleet, and its rows while it is computed."""
