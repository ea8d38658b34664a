"""General statistics: least squares, intervals and tests."""
