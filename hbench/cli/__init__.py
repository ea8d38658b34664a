"""The command line: parse, call the workflow, print."""

import gc

# A command is short, and most of what it makes stays. Looking for garbage after each 700 objects
# took a quarter of a report's time, in which figures are drawn, and a fifth of --help's.
gc.set_threshold(50_000)
