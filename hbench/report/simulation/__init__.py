"""Pages and text of simulated phenomena and replayed campaigns."""
