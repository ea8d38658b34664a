"""Quality of a campaign's data in words and tables."""
