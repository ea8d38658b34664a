"""A campaign's results as one row of a fleet's table."""

import math
from collections.abc import Callable, Iterable
from datetime import UTC, datetime
from statistics import fmean, median_low

from hbench.records import Direction, FleetNumber, FleetRow, Results, RunPlan
from hbench.report.campaign.quality import checks, worst
from hbench.report.campaign.rod_side import load_words
from hbench.report.campaign.summary import Glance, Number, glances
from hbench.report.render.numbers import short
from hbench.untrusted_text import printable

_DIRECTIONS: tuple[Direction, ...] = ("extend", "retract")
_LONGEST = 200  # characters of a campaign's own words
_FITTED = {
    "breakaway_fit_n": "f_stiction_n",
    "f_coulomb_n": "f_coulomb_n",
    "v_stribeck_m_s": "v_stribeck_m_s",
    "b_viscous_n_s_m": "b_viscous_n_s_m",
}


def fleet_row(path: str, results: Results, speed_m_s: float | None = None) -> FleetRow:
    """Return the row of the campaign at ``path``.

    Without a working speed it is the middle one of those that the schedule asked for, so that it
    does not depend on what was rejected.
    """
    plans = [one.run.plan for one in results.runs]
    speed = speed_m_s or _planned_speed(plans)
    found = glances(results, speed)
    made = results.provenance
    seed = made.details.get("seed")
    specimen = plans[0].specimen
    return FleetRow(
        path=path,
        name=_own(made.name),
        source=made.source,
        bench=_own(made.bench),
        seed=seed if isinstance(seed, int) and abs(seed) < 2**63 else None,
        started=_moment(made.started),
        protocol=_protocol(plans, speed),
        area_piston_m2=specimen.area_piston_m2,
        area_rod_m2=specimen.area_rod_m2,
        stroke_m=specimen.stroke_m,
        quality=worst(checks(results)),
        runs=len(results.runs),
        accepted=sum(run.accepted for run in results.runs),
        v_m_s=speed,
        numbers={
            (name, direction): number
            for direction in _DIRECTIONS
            for name, number in _numbers(
                [one for one in found if one.curve.direction == direction],
                _series(plans, direction),
            )
        },
    )


def _series(plans: list[RunPlan], direction: Direction) -> int:
    """Return how many loads were to be measured in a direction."""
    own = [plan for plan in plans if plan.direction == direction]
    kind = "steady" if any(plan.kind == "steady" for plan in plans) else "ramp"
    return len({(p.label, p.f_load_n, p.p_lr_ref_pa) for p in own if p.kind == kind})


def _numbers(found: list[Glance], loads: int) -> Iterable[tuple[str, FleetNumber]]:
    columns: dict[str, list[FleetNumber | None]] = {
        "friction_n": [_shown(one.friction_n) for one in found],
        "breakaway_n": [_measured(one.breakaway_n) for one in found],
        "efficiency": [_shown(one.efficiency) for one in found],
        **{name: [_fitted(one, parameter) for one in found] for name, parameter in _FITTED.items()},
    }
    for name, numbers in columns.items():
        known = [one for one in numbers if one is not None]
        if known and len(known) == loads:  # else it is no mean over the same loads
            yield name, _mean(known)


def _shown(one: Number | None) -> FleetNumber | None:
    if one is None:
        return None
    ends = (None, None) if one.u95 is None else (one.value - one.u95, one.value + one.u95)
    return FleetNumber(one.value, *ends, one.se)


def _measured(one: Number | None) -> FleetNumber | None:
    return None if one is None or one.flag else _shown(one)


def _fitted(one: Glance, parameter: str) -> FleetNumber | None:
    for fit in one.curve.fits:
        found = fit.parameters.get(parameter)
        if fit.converged and found is not None and found.ci95 is not None:
            low, high = found.ci95
            return FleetNumber(found.value, low, high, found.se)
    return None


def _mean(numbers: list[FleetNumber]) -> FleetNumber:
    def over(name: str, mean: Callable[[list[float]], float]) -> float | None:
        values = [getattr(one, name) for one in numbers]
        return None if None in values else mean(values)

    value = fmean(one.value for one in numbers)
    se = over("se", lambda each: math.hypot(*each) / len(each))
    return FleetNumber(value, over("low", fmean), over("high", fmean), se)


def _planned_speed(plans: list[RunPlan]) -> float | None:
    speeds = [abs(plan.v_ref_m_s) for plan in plans if plan.kind == "steady"]
    return median_low(speeds) if speeds else None


def _protocol(plans: list[RunPlan], speed: float | None) -> str:
    """Say what must be the same where cylinders are compared."""
    areas = sorted({(p.specimen.area_piston_m2, p.specimen.area_rod_m2) for p in plans})
    words = ["; ".join(f"{short(1e6 * a)}/{short(1e6 * b)} mm²" for a, b in areas)]
    for direction in _DIRECTIONS:
        own = [plan for plan in plans if plan.direction == direction]
        loads = dict.fromkeys(load_words(p.f_load_n, p.p_lr_ref_pa) or "no load" for p in own)
        if own:
            words.append(f"{direction} {', '.join(loads)}")
    words += sorted({plan.label for plan in plans if plan.label})
    if speed is not None:
        words.append(f"{short(1e3 * speed)} mm/s")
    return _own("; ".join(words))


def _own(words: str) -> str:
    words = " ".join(printable(words).split())
    return words if len(words) <= _LONGEST else words[: _LONGEST - 1] + "…"


def _moment(text: str) -> datetime | None:
    try:
        moment = datetime.fromisoformat(text)
        return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).astimezone(UTC)
    except (ValueError, OverflowError):
        return None
