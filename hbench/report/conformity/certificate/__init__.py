"""Test certificate of a campaign: page, PDF and digital calibration certificate."""
