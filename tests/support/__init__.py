"""Modules that several test files share, imported as ``tests.support.FOLDER.MODULE``."""

from pathlib import Path

ROOT = Path(__file__).parents[2]  # of the repository
