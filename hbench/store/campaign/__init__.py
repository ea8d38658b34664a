"""The campaign folder: journal, raw logs, checksums, lock file."""
