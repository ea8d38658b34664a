"""State of campaigns and stations, published and read while they run."""
