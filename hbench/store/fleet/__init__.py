"""The table of a fleet, and its rows during the analysis."""
