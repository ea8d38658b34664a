"""What the runner writes its runs to: a campaign's folder, or memory."""

from datetime import datetime
from typing import Protocol

import numpy as np

from hbench.records import Outcome, RunPlan


class Journal(Protocol):
    """Takes the start part and the stop part of one run after the other."""

    def start_run(self, plan: RunPlan, at: datetime, after: str) -> None:
        """Note that a run begins, again ``after`` the reasons that spoke against it; or empty."""

    def finish_run(
        self, plan: RunPlan, words: np.ndarray, outcome: Outcome, why: str, at: datetime
    ) -> None:
        """Keep the log (n, channels) of the run that began last, and how it ended."""
