"""Gaps between measured and simulated runs: per window, region, run and table."""
