"""Headline numbers of a campaign, the grades of its data, and its row in a fleet."""
