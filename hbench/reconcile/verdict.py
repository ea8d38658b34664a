"""Verdict of a search, and what the data do not contain."""

from collections.abc import Collection, Mapping, Sequence
from itertools import combinations

import numpy as np

from hbench.analysis.rounding import distinct_texts
from hbench.analysis.screening.calibrate import RUN_FIELDS
from hbench.reconcile.acceptance import ALIKE, CRITERIA, ambiguity_margin
from hbench.reconcile.gaps.gap_map import point_of
from hbench.reconcile.measured.balances import BALANCES, channels_missing
from hbench.reconcile.search_result import SearchResult
from hbench.records import KINDS, Candidate, Gap, Run, Verdict
from hbench.records.diagnosis import UNEXPLAINED_GAP
from hbench.sentences import listed, plural

FEWEST_POINTS = 8  # operating points
_OTHER_LOAD = 0.2  # of the largest mean force: a smaller difference may be that of friction
_SAME_LOAD = 0.02  # of the largest load: friction and the pressures' control change it by as much
_SAME_SPEED = 0.1  # speeds that differ by this share have nearly the same friction
NO_RESIDUALS = (
    "No quantity has residuals that are significant, large enough to matter and more than "
    f"{UNEXPLAINED_GAP:g} times the repeatability."
)
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


def decide_verdict(result: SearchResult, unexplained: Sequence[Gap]) -> tuple[Verdict, str]:
    """Return the verdict and its reason.

    ``unexplained`` are the gaps of the model with all effects and without learned laws.
    """
    first, last = result.steps[0], result.steps[-1]
    unnamed = _unnamed(result)
    if result.names:
        reason = named_words(result.names, tuple(result.unconfirmed))
        if last.ambiguous:
            others = " or ".join(candidate.name for candidate in last.ambiguous)
            reason += f" {others} would explain the remaining residuals equally well."
        elif unexplained:
            reason += (
                f" Gaps that remain (in multiples of the repeatability): {_gap_list(unexplained)}."
            )
        return "named", reason + unnamed
    if last.ambiguous:
        margin = ambiguity_margin(last.ambiguous[0].score)
        return "ambiguous", (
            f"Not distinguishable, scores in nats: {scores(last.ambiguous)}. A score decides where "
            f"it is {margin:.1f} nats (a tenth of the best one, at least 3) above the next, or "
            f"{ALIKE * margin:.1f} where these runs are not expected to distinguish both."
        )
    if unexplained:
        reason = unexplained_words(unexplained)
        if first.evaluated:
            best = first.evaluated[0].candidate
            reason += (
                f" The best candidate, {best.name}, explains {100 * best.explained:.0f} % in "
                f"cross-validation ({100 * CRITERIA.explained:.0f} % needed; score "
                f"{best.score:.1f} nats, {best.threshold:.1f} needed)."
            )
            if best.score > best.threshold and best.size < CRITERIA.size:
                size, needed = distinct_texts(best.size, CRITERIA.size)
                reason += (
                    f" It is too small to be named: {size} of a typical size, {needed} needed."
                )
            elif best.name in result.ruled_out:
                reason += f" It is not named: refined, {result.ruled_out[best.name]}."
        return "unknown", reason + unnamed
    return "none", NO_RESIDUALS


def _unnamed(result: SearchResult) -> str:
    """Return the sentence about learned laws; empty without any."""
    tables = [result.final.hypothesis.tables[law.table] for law in result.laws]
    words = [f"{table.adds_to} over {listed(list(table.knots))}" for table in tables]
    laws = "unnamed laws" if len(words) > 1 else "an unnamed law"
    return f" The revised model contains {laws}: {'; '.join(words)}." if words else ""


def named_words(names: Sequence[str], unconfirmed: Sequence[str]) -> str:
    """Return the sentences about named effects, and those that held-out runs do not confirm."""
    explain = plural(len(names), "explains", "explain")
    words = f"{listed(names)} {explain} the residuals in cross-validation."
    if not unconfirmed:
        return words
    return (
        f"{words} Runs outside the fit do not confirm {listed(unconfirmed)}, so the revised model "
        f"does not contain {plural(len(unconfirmed), 'it', 'them')}."
    )


def unexplained_words(gaps: Sequence[Gap]) -> str:
    """Return the sentence about gaps that no effect explains."""
    return (
        "No effect of the catalogue explains the gaps (in multiples of the repeatability): "
        f"{_gap_list(gaps)}."
    )


def scores(candidates: Sequence[Candidate]) -> str:
    """Return candidates with their scores in nats."""
    return ", ".join(f"{candidate.name} ({candidate.score:.0f})" for candidate in candidates)


def _gap_list(gaps: Sequence[Gap]) -> str:
    """Return balances with their gaps."""
    return ", ".join(f"{gap.name} ({gap.gap:.1f})" for gap in gaps)


def data_shortfalls(runs: Sequence[Run]) -> dict[str, str]:
    """Return by code why complete runs do not suffice to name an effect; empty if they do.

    With a single speed or a single load too many effects have the same signature.
    """
    plans = [run.plan for run in runs]
    points = len(set(map(point_of, plans)))
    speeds = {abs(plan.v_ref_m_s) for plan in plans if KINDS[plan.kind].has_constant_speed}
    shortfalls = {}
    if points < FEWEST_POINTS:
        shortfalls["points"] = (
            f"at least {FEWEST_POINTS} operating points; these runs have {points}"
        )
    codes = []
    if len(speeds) < 2 and not any(KINDS[plan.kind].covers_speeds for plan in plans):
        codes.append("speeds")
    if not _has_second_load(runs):
        codes.append("loads")
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


def _has_second_load(runs: Sequence[Run]) -> bool:
    """Return whether runs have two loads: nominal ones, or measured ones at nearly one speed."""
    nominal = {run.plan.f_load_n for run in runs if run.plan.f_load_n is not None}
    if nominal:
        return len(nominal) > 1
    forces: dict[tuple[str, float, str], list[float]] = {}
    for run in runs:
        if run.f_applied_n is not None:
            which = run.plan.kind, run.plan.v_ref_m_s, run.plan.label
            forces.setdefault(which, []).append(float(np.median(run.f_applied_n)))
    means = {which: float(np.mean(each)) for which, each in forces.items()}
    other = _OTHER_LOAD * max(map(abs, means.values()), default=0.0)
    return any(
        kind == kind_2
        and abs(v - v_2) <= _SAME_SPEED * min(abs(v), abs(v_2))
        and abs(means[kind, v, label] - means[kind_2, v_2, label_2]) > other
        for (kind, v, label), (kind_2, v_2, label_2) in combinations(means, 2)
    )


def _has_second_pressure(runs: Sequence[Run]) -> bool:
    """Return whether steady runs have one load at two rod-side pressures of the load cylinder.

    Both are the nominal ones, or the measured ones at nearly one speed where none are stated.
    """
    steady = [run for run in runs if KINDS[run.plan.kind].has_constant_speed]
    loads = [_stated(run.plan.f_load_n, run.f_applied_n) for run in steady]
    levels = [_stated(run.plan.p_lr_ref_pa, run.p_lr_pa) for run in steady]
    speeds = [run.plan.v_ref_m_s for run in steady]
    same = _SAME_LOAD * np.nanmax(np.abs([*loads, 0.0]))
    other = _OTHER_LOAD * np.nanmax(np.abs([*levels, 0.0]))
    return any(
        abs(v - v_2) <= _SAME_SPEED * min(abs(v), abs(v_2))
        and abs(load - load_2) <= same
        and abs(level - level_2) > other
        for (v, load, level), (v_2, load_2, level_2) in combinations(
            zip(speeds, loads, levels, strict=True), 2
        )
    )


def _stated(nominal: float | None, measured: np.ndarray | None) -> float:
    """Return a nominal value, or else the median of the measured ones; NaN without either."""
    if nominal is not None:
        return nominal
    return float("nan") if measured is None else float(np.median(measured))


def missing_experiments(runs: Sequence[Run]) -> dict[str, str]:
    """Return by code which experiments would make more effects distinguishable."""
    plans = [run.plan for run in runs]
    steady = [plan for plan in plans if KINDS[plan.kind].has_constant_speed]
    kinds = [KINDS[plan.kind] for plan in plans]
    codes = []
    covers_speeds = not steady and any(kind.covers_speeds for kind in kinds)
    if len({abs(plan.v_ref_m_s) for plan in steady}) < 3 and not covers_speeds:
        codes.append("speeds")
    if not _has_second_load(runs):
        codes.append("loads")
    reverses = any(kind.reverses for kind in kinds)
    if len({plan.direction for plan in steady}) < 2 and (steady or not reverses):
        codes.append("directions")
    if not reverses:
        codes.append("reversals")
    if not any(kind.has_fast_changes for kind in kinds):
        codes.append("steps")
    if not any(kind.analysis == "leakage" for kind in kinds):
        codes.append("hold")
    if not _has_second_pressure(runs):
        codes.append("pressures")
    return {code: MISSING[code] for code in codes}
