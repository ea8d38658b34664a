"""Journal interface of the runner, for a campaign folder or memory."""

from datetime import datetime
from typing import Protocol

import numpy as np

from hbench.records import Outcome, RunPlan


class Journal(Protocol):
    """Journal of the start and the end of each run, in order."""

    def start_run(self, plan: RunPlan, at: datetime, after: str) -> None:
        """Note the start of a run; ``after`` has the reasons that rejected its last attempt."""

    def finish_run(
        self, plan: RunPlan, words: np.ndarray, outcome: Outcome, why: str, at: datetime
    ) -> None:
        """Keep the log (n, channels) of the run that started last, and its outcome."""
