"""What a search means: the verdict in words, and what the data lacks for a better one."""

from collections import Counter
from collections.abc import Sequence

from hbench.analysis.screening.calibrate import FIELDS
from hbench.reconcile.gap import point_of
from hbench.reconcile.measured.balances import BALANCES, lacking_channels
from hbench.reconcile.search import Found
from hbench.records import KINDS, Gap, Run, RunPlan, Verdict

_REST = 2.0  # gap of a balance that is as far again from the model as its trials from one another
_P = 0.1
_FEWEST = 8  # operating points: fewer name nothing
_SPEEDS = "three or more speeds: what grows with speed is not told from what does not"
_LOADS = "a second load: effects of load and pressure look like offsets"


def rest(ranked: Sequence[Gap]) -> tuple[Gap, ...]:
    """Return the balances that lack something: structured, and too much for the trials."""
    return tuple(one for one in ranked if one.gap > _REST and one.p_value < _P)


def judge(found: Found, left: Sequence[Gap]) -> tuple[Verdict, str]:
    """Return the verdict and why; ``left`` are the balances that lack something at the end."""
    last = found.steps[-1]
    names = ", then ".join(found.names)
    where = ", ".join(f"{one.name} ({one.gap:.1f})" for one in left)
    if found.names:
        why = f"Adding {names} explains what operating points left out lack."
        if last.close:
            others = " or ".join(one.name for one in last.close)
            why += f" Of what is left, {others} would explain as much as one another."
        elif left:
            why += f" A rest is structured that no effect explains: {where} trial scatters."
        return "named", why
    if last.close:
        scores = ", ".join(f"{one.name} ({one.score:.0f})" for one in last.close)
        return "ambiguous", f"These data can't tell apart, scores in nats: {scores}."
    if left:
        best = last.tried[0].found if last.tried else None
        tried = (
            f" The best candidate, {best.name}, explains {best.explained:.0%} of it on operating "
            f"points left out (score {best.score:.1f}, threshold {best.threshold:.1f})."
            if best
            else ""
        )
        return "unknown", f"No effect of the catalogue explains the gap of {where}.{tried}"
    return "none", "No balance of the refitted model lacks more than its trials scatter."


def too_few(runs: Sequence[Run]) -> tuple[str, ...]:
    """Return why no effect can be named from whole runs, in words; empty where a search may begin.

    One speed or one load alone: then too many effects look the same for a name to be no guess.
    """
    plans = [run.plan for run in runs]
    repeated = sum(count > 1 for count in Counter(map(point_of, plans)).values())
    speeds = {abs(plan.v_ref_m_s) for plan in plans if KINDS[plan.kind].has_constant_speed}
    lacks = []
    if repeated < _FEWEST:
        lacks.append(f"operating points with two trials or more: {repeated}, of {_FEWEST} at least")
    if len(speeds) < 2 and not any(KINDS[plan.kind].covers_speeds for plan in plans):
        lacks.append(_SPEEDS)
    if len({plan.f_load_n for plan in plans if plan.f_load_n is not None}) < 2:
        lacks.append(_LOADS)
    if runs and not set(_compared(runs)) - {"kinematics", "supply"}:
        lacks.append("the chambers' pressures, with the valves' commands or the load cell's force")
    return tuple(lacks)


def missing_channels(runs: Sequence[Run]) -> tuple[str, ...]:
    """Return which channels no run has, and what can't be compared without them, in words."""
    without = [name for name in BALANCES if name not in _compared(runs)]
    lacking = {one for run in runs for name in without for one in lacking_channels(run, name)}
    if not lacking:
        return ()
    channels = ", ".join(name for name, field in FIELDS.items() if field in lacking)
    return (f"{channels} (not measured): {', '.join(without)} are not compared",)


def _compared(runs: Sequence[Run]) -> tuple[str, ...]:
    return tuple(name for name in BALANCES if any(not lacking_channels(run, name) for run in runs))


def what_is_missing(plans: Sequence[RunPlan]) -> tuple[str, ...]:
    """Return what runs lack for telling effects apart, in words."""
    steady = [plan for plan in plans if KINDS[plan.kind].has_constant_speed]
    kinds = [KINDS[plan.kind] for plan in plans]
    lacks = []
    if len({abs(plan.v_ref_m_s) for plan in steady}) < 3:
        lacks.append(_SPEEDS)
    if len({plan.f_load_n for plan in plans if plan.f_load_n is not None}) < 2:
        lacks.append(_LOADS)
    if len({plan.direction for plan in steady}) < 2:
        lacks.append("the other direction: friction turns with it, a sensor's error does not")
    if not any(kind.reverses for kind in kinds):
        lacks.append("reversals (triangle): presliding and friction's lag do not show")
    if not any(kind.has_fast_changes for kind in kinds):
        lacks.append("steps: slow valves, masses and filters hardly show")
    if not any(kind.is_at_rest for kind in kinds):
        lacks.append("a hold with closed valves: leaks look like the valves' errors")
    by_load: dict[float | None, set[float | None]] = {}
    for plan in steady:
        by_load.setdefault(plan.f_load_n, set()).add(plan.p_lr_ref_pa)
    if all(len(levels) < 2 for levels in by_load.values()):
        lacks.append("one load at two pressures: friction of seals looks like that of guides")
    return tuple(lacks)
