"""Statistics of a fleet: spreads, precision of the measurement, control charts, wear."""
