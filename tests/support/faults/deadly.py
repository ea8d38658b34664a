"""hbench whose process dies over a campaign called deadly..., and is slow with one called slow...

Its death is that by a system that is out of memory: SIGKILL. Run as a program it is ``hbench``, in
its processes too; a Dask worker takes it by ``--preload``.
"""

import os
import signal
import time

from hbench.parallel import dask_cluster
from hbench.workflow import fleet, results


def derive(campaign):
    name = campaign.folder.name
    if name.startswith("deadly"):
        os.kill(os.getpid(), signal.SIGKILL)
    if name.startswith("slow"):
        time.sleep(0.25)
    return results.derive(campaign)


fleet.derive = derive
dask_cluster._CONNECT_S = 4.0  # until a scheduler that was killed is given up

if __name__ == "__main__":
    for number in (signal.SIGINT, signal.SIGTERM):  # whatever a test was started with
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    from hbench.cli.main import main

    main()
