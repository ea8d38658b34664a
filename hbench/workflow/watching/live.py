"""Publication of the state of a running measurement."""

import math
import time
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hbench.experiment.progress import Progress, Report
from hbench.store.campaign.live_file import remove_live, write_live

EVERY_S = 0.5  # on the wall's clock
TRAIL = 60  # earlier states: half a minute, so that a page that is opened later shows it at once
_TRACED = ("at_s", "v_m_s", "v_ref_m_s", "f_load_n", "f_load_ref_n", "pressures_pa")


@contextmanager
def published(folder: Path, report: Report, about: Mapping[str, str]) -> Iterator[Report]:
    """Write the state given to ``report`` also to ``live.json`` in the campaign's folder.

    ``about``, the campaign's name and source, is added. It is written every ``EVERY_S``, and at the
    begin of a run, so that its number agrees with the journal. ``trail`` are the last states, one
    every ``EVERY_S``. The file is removed at the end.
    """
    written_s, sampled_s, run = -math.inf, -math.inf, ""
    trail: deque[dict[str, Any]] = deque(maxlen=TRAIL)

    def both(progress: Progress) -> None:
        nonlocal written_s, sampled_s, run
        report(progress)
        now_s = time.monotonic()
        if progress.plan.run != run or now_s - written_s >= EVERY_S:
            written_s, run = now_s, progress.plan.run
            state = {"at_s": time.time(), **about, **_state(progress)}
            if now_s - sampled_s >= EVERY_S:
                sampled_s = now_s
                trail.append({name: state[name] for name in _TRACED})
            write_live(folder, state | {"trail": list(trail)})

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
