"""Search for effects in the runs of a campaign: candidates, rounds, refinement."""
