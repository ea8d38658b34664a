"""``hbench rig``, but each record that the board publishes also goes to a file, past the line.

python tapped_rig.py FILE [options of hbench rig]
"""

import sys
from pathlib import Path

from hbench.cli.main import main
from hbench.rig import virtual
from tests.support.faults.faulty_line import Truth

if __name__ == "__main__":
    FILE = Path(sys.argv[1]).open("wb", buffering=0)
    sys.argv[1] = "rig"

    class TappedRig(virtual.VirtualRig):
        """A rig whose board is read past the line."""

        truth = Truth()

        def read(self, timeout_s):
            said = super().read(timeout_s)
            FILE.write(self.truth.sample(self._board).tobytes())
            return said

    virtual.VirtualRig = TappedRig
    main()
