"""Acceptance of a cylinder by a campaign."""
