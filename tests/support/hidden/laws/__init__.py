"""Laws of the hidden plants; ``table.py`` is the file for ``HBENCH_EFFECTS``."""
