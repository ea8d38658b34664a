"""``python -m hbench`` is the same as ``hbench``."""

from hbench.cli.main import main

main()
