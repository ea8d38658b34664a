"""From a schedule to raw logs: the plan of runs and the runner."""
