"""Benchmarks compare times, so they run alone: xdist's workers (``pytest -n``) leave them out."""

import os

collect_ignore_glob = ["test_*.py"] if "PYTEST_XDIST_WORKER" in os.environ else []
