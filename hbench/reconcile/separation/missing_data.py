"""What the runs of a campaign do not contain, by their plans and by their logs."""

from collections.abc import Collection, Mapping, Sequence

from hbench.analysis.screening.calibrate import RUN_FIELDS
from hbench.reconcile.gaps.gap_map import point_of
from hbench.reconcile.measured.balances import BALANCES, channels_missing
from hbench.reconcile.separation.logged_loads import Areas, has_second_load, has_second_pressure
from hbench.reconcile.separation.logged_motion import logged_motion
from hbench.records import KINDS, Run

FEWEST_POINTS = 8  # operating points
MISSING: Mapping[str, str] = {
    "speeds": "three or more speeds, to separate effects that grow with speed from the others",
    "loads": "a second load, to separate effects of load and pressure from offsets",
    "directions": "the other direction: friction changes its sign with it, a sensor error does not",
    "reversals": "reversals (triangle): they show presliding and the lag of friction",
    "steps": "steps: they show slow valves, masses and filters",
    "hold": "a hold with closed valves, to separate leakage from valve errors",
    "pressures": "one load at two pressures, to separate the friction of seals from that of guides",
    "chambers": "the chambers' pressures, with the valves' commands or the load cell's force",
}
"""Text of each kind of missing data, by code."""


def missing_data(
    usable: Sequence[Run],
    measured: Sequence[Run],
    load_areas: Areas | None = None,
    absent: Collection[str] = (),
) -> tuple[bool, tuple[str, ...]]:
    """Return whether the usable runs suffice to name an effect, and what is missing in words.

    The most important item is the first. What complete runs that are left out have ``measured`` is
    not asked for again, but their logs are. ``load_areas`` are those of the load cylinder; the
    bench has no balances ``absent``.
    """
    complete = [run for run in measured if not (run.aborted or run.truncated)]
    short = data_shortfalls(usable)
    missing = data_shortfalls(complete) if short else {}
    if short.keys() - missing.keys():
        others = " (the others do not suffice)" if usable else ""
        missing = {"logs": f"the runs that are left out, with complete logs{others}"} | missing
    missing |= unmeasured_channels(complete, absent)
    missing |= missing_experiments(complete, load_areas, absent)
    return not short, tuple(missing.values())


def data_shortfalls(runs: Sequence[Run]) -> dict[str, str]:
    """Return by code why complete runs do not suffice to name an effect; empty if they do.

    At a single speed too many effects have the same signature. A single load, as of one mass, is
    enough: effects that it does not distinguish are ambiguous.
    """
    plans = [run.plan for run in runs]
    points = len(set(map(point_of, plans)))
    speeds = {abs(plan.v_ref_m_s) for plan in plans if KINDS[plan.kind].has_constant_speed}
    shortfalls = {}
    if points < FEWEST_POINTS:
        shortfalls["points"] = (
            f"at least {FEWEST_POINTS} operating points (runs with the same plan are trials of one "
            f"operating point); these runs have {points}"
        )
    codes = []
    if len(speeds) < 2 and not any(KINDS[plan.kind].covers_speeds for plan in plans):
        codes.append("speeds")
    if runs and not set(_compared(runs)) - {"kinematics", "supply"}:
        codes.append("chambers")
    return shortfalls | {code: MISSING[code] for code in codes}


def unmeasured_channels(runs: Sequence[Run], absent: Collection[str] = ()) -> dict[str, str]:
    """Return under ``channels`` those that no run has, with the balances that need them.

    The bench has no balances ``absent``.
    """
    balances = [name for name in BALANCES if name not in (*_compared(runs), *absent)]
    missing = {
        channel for run in runs for name in balances for channel in channels_missing(run, name)
    }
    if not missing:
        return {}
    channels = ", ".join(name for name, field in RUN_FIELDS.items() if field in missing)
    return {"channels": f"{channels} (not measured), for the quantities {', '.join(balances)}"}


def _compared(runs: Sequence[Run]) -> tuple[str, ...]:
    return tuple(name for name in BALANCES if any(not channels_missing(run, name) for run in runs))


def missing_experiments(
    runs: Sequence[Run], load_areas: Areas | None = None, absent: Collection[str] = ()
) -> dict[str, str]:
    """Return by code which experiments would make more effects distinguishable.

    ``load_areas`` are those of the load cylinder. The bench has no balances ``absent``: one
    cylinder against a weight or a spring has a single pressure at each load.
    """
    plans = [run.plan for run in runs]
    steady = [plan for plan in plans if KINDS[plan.kind].has_constant_speed]
    kinds = [KINDS[plan.kind] for plan in plans]
    motions = [logged_motion(run) for run in runs]
    others = [each for each, kind in zip(motions, kinds, strict=True) if kind.covers_speeds]
    codes = []
    covers_speeds = not steady and any(kind.covers_speeds for kind in kinds)
    several = covers_speeds or any(each.has_several_speeds for each in others)
    if len({abs(plan.v_ref_m_s) for plan in steady}) < 3 and not several:
        codes.append("speeds")
    if not has_second_load(runs, load_areas):
        codes.append("loads")
    reverses = any(kind.reverses for kind in kinds)
    both = any(each.has_both_directions for each in others)
    if len({plan.direction for plan in steady}) < 2 and (steady or not reverses) and not both:
        codes.append("directions")
    if not (reverses or any(each.reverses for each in motions)):
        codes.append("reversals")
    fast = any(kind.has_fast_changes for kind in kinds)
    if not (fast or any(each.has_fast_changes for each in motions)):
        codes.append("steps")
    if not any(kind.analysis == "leakage" for kind in kinds):
        codes.append("hold")
    if "force_load" not in absent and not has_second_pressure(runs, load_areas):
        codes.append("pressures")
    return {code: MISSING[code] for code in codes}
