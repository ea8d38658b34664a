"""Operating points of a requirement at which runs were made and none was accepted.

They would be missing among the measured values: a cylinder could pass by the runs that succeeded.
"""

from collections.abc import Iterator

from hbench.analysis.conformity.measured import applies, near
from hbench.records import DIRECTION_WORDS, KINDS, Results, RunPlan, ScreenedRun
from hbench.records.conformity.acceptance import Requirement
from hbench.records.rod_pressure import SeriesKey, series_key
from hbench.units import from_si

_OF_STEADY_RUNS = ("friction", "efficiency")


def rejected_points(results: Results, requirement: Requirement) -> Iterator[str]:
    """Yield each series with such points in words: direction, load, speeds, reasons.

    A run is replaced by an accepted one of its series at about the same speed.
    """
    if requirement.quantity not in _OF_STEADY_RUNS:
        return
    runs = [
        each
        for each in results.runs
        if KINDS[each.run.plan.kind].has_constant_speed
        and applies(each.run.plan, each.run.plan, requirement)
        and near(abs(each.run.plan.v_ref_m_s), requirement.v_m_s)
    ]
    accepted = [each.run.plan for each in runs if each.accepted]
    rejected: dict[SeriesKey, list[ScreenedRun]] = {}
    for each in runs:
        plan = each.run.plan
        if not any(_replaces(other, plan) for other in accepted):
            rejected.setdefault(series_key(plan), []).append(each)
    for (label, _, f_load_n, _), each_of in rejected.items():
        speeds = {f"{from_si(abs(each.run.plan.v_ref_m_s), 'mm/s'):.3g}" for each in each_of}
        reasons = {reason.split(":")[0] for each in each_of for reason in each.reasons}
        series = [label, DIRECTION_WORDS[each_of[0].run.plan.direction]]
        if f_load_n is not None and requirement.f_load_n is None:
            series.append(f"load {f_load_n:.4g} N")
        yield (
            f"{', '.join(filter(None, series))}, at {', '.join(sorted(speeds, key=float))} mm/s: "
            f"no run was accepted ({', '.join(sorted(reasons))})"
        )


def _replaces(accepted: RunPlan, rejected: RunPlan) -> bool:
    same = series_key(accepted) == series_key(rejected)
    return same and near(abs(accepted.v_ref_m_s), abs(rejected.v_ref_m_s))
