"""Publication of the state of a running measurement."""

import math
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hbench.experiment.progress import Progress, Report
from hbench.store.campaign.live_file import remove_live, write_live

EVERY_S = 0.5  # on the wall's clock


@contextmanager
def published(folder: Path, report: Report, about: Mapping[str, str]) -> Iterator[Report]:
    """Write the state given to ``report`` also to ``live.json`` in the campaign's folder.

    ``about``, the campaign's name and source, is added. It is written every ``EVERY_S``, and at the
    begin of a run, so that its number agrees with the journal. The file is removed at the end.
    """
    written_s, run = -math.inf, ""

    def both(progress: Progress) -> None:
        nonlocal written_s, run
        report(progress)
        if progress.plan.run != run or time.monotonic() - written_s >= EVERY_S:
            written_s, run = time.monotonic(), progress.plan.run
            write_live(folder, {"at_s": time.time(), **about, **_state(progress)})

    try:
        yield both
    finally:
        remove_live(folder)


def _state(progress: Progress) -> dict[str, Any]:
    plan, last = progress.plan, progress.last_rejected
    values = {
        "run": plan.run,
        "kind": plan.kind,
        "label": plan.label,
        "direction": plan.direction,
        "trial": plan.trial,
        "trials": progress.trials,
        "attempt": progress.attempt,
        "runs_done": progress.runs_done,
        "runs_total": progress.runs_total,
        "at_most": progress.at_most,
        "phase": progress.phase,
        "waiting": progress.waiting,
        "v_plan_m_s": plan.v_ref_m_s,
        "v_ref_m_s": progress.v_ref_m_s,
        "v_m_s": progress.v_m_s,
        "f_load_ref_n": plan.f_load_n,
        "f_load_n": progress.f_load_n,
        "f_applied_n": progress.f_applied_n,
        "pressures_pa": dict(progress.pressures_pa),
        "pressure_max_pa": progress.pressure_max_pa,
        "x_m": progress.x_m,
        "travel_m": list(progress.travel_m),
        "rejected": progress.rejected,
        "last_rejected": last and {"run": last.plan.run, "reasons": list(last.reasons)},
        "seconds_left": progress.seconds_left,
    }
    return _finite(values)


def _finite(value: Any) -> Any:
    """Replace values that are not finite, which JSON can't express, by None."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value
