"""The wire between host and board: dictionary, frames, checks. Bytes only."""
