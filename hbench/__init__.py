"""hbench: friction and efficiency of hydraulic cylinders, from a bench to a data sheet."""

__version__ = "0.1.0"
