"""The report of a campaign: page, tables, CSV and JSON."""
