"""From raw logs to friction curves, fits and efficiency: pure functions, records in and out."""
