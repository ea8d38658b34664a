"""Page, rows, text and figures of a fleet."""
