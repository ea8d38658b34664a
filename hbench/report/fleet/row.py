"""A campaign's results as one row of a fleet's table."""

import re
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime

from hbench.records import DIRECTIONS, FleetNumber, FleetRow, Results, RunPlan, ScreenedRun, Side
from hbench.report.campaign.quality.completeness import missing_words
from hbench.report.campaign.quality.verdict import weak_checks
from hbench.report.campaign.series_words import load_words
from hbench.report.render.numbers import short
from hbench.untrusted_text import printable

_IDENTITY = (("specimen", "serial"), *(("test", n) for n in ("operator", "mounting", "date")))
_PRESSURE = re.compile(r", (?=[\d.]+ bar\b)")  # between a load and its pressure
_BENCH = 60  # characters of its name in the kind of campaign
SPEED_NOT_SET = "speed not set"
_LONGEST = 200  # characters of a campaign's own words


def fleet_row(
    path: str, results: Results, numbers: Mapping[tuple[str, Side], FleetNumber]
) -> FleetRow:
    """Return the row of the campaign at ``path``; ``numbers`` are its means over the loads.

    The time of an imported campaign is that of ``test.date``: its start is that of the import.
    """
    plans = [run.run.plan for run in results.runs]
    drift = results.drift
    speed = results.headline.v_m_s
    provenance = results.provenance
    seed = provenance.details.get("seed")
    specimen = plans[0].specimen
    identity = {
        name: _line(str(provenance.settings.get(section, {}).get(name, "")))
        for section, name in _IDENTITY
    }
    imported = provenance.source == "imported"
    started = _moment(identity["date"] if imported else provenance.started)
    return FleetRow(
        path=path,
        name=_line(provenance.name),
        source=provenance.source,
        bench=_line(provenance.bench),
        label=_line(", ".join(_labels(plans))),
        specimen=identity["serial"],
        operator=identity["operator"],
        mounting=identity["mounting"],
        day=identity["date"] or ("" if started is None else f"{started:%Y-%m-%d}"),
        seed=seed if isinstance(seed, int) and abs(seed) < 2**63 else None,
        started=started,
        protocol=_protocol(plans, speed, provenance.source, provenance.bench),
        area_piston_m2=specimen.area_piston_m2,
        area_rod_m2=specimen.area_rod_m2,
        stroke_m=specimen.stroke_m,
        quality=results.quality.grade,
        drift_possible=drift.possible_percent / 100 if drift is not None and drift.hidden else None,
        weak=_line(weak_checks(results.quality)),
        missing=_line(missing_words(results.quality.completeness)),
        runs=len(results.runs),
        accepted=sum(run.accepted for run in results.runs),
        v_m_s=speed,
        distance_m=_distance(results.runs),
        friction_work_j=_work(results.runs),
        numbers=dict(numbers),
    )


def _protocol(plans: list[RunPlan], speed: float | None, source: str, bench: str) -> str:
    """Return the settings that must be equal for a comparison of cylinders.

    A single label names the cylinder or the seal, which may differ; several must be equal.
    """
    areas = sorted({(p.specimen.area_piston_m2, p.specimen.area_rod_m2) for p in plans})
    bench = _line(bench).replace(";", ",")[:_BENCH]
    settings = [f"{source}, {bench}".strip(", ")]
    settings += ["; ".join(f"{short(1e6 * a)}/{short(1e6 * b)} mm²" for a, b in areas)]
    for direction in DIRECTIONS:
        chosen = [plan for plan in plans if plan.direction == direction]
        loads = dict.fromkeys(load_words(p.f_load_n, p.p_lr_ref_pa) or "no load" for p in chosen)
        if chosen:
            settings.append(f"{direction} {', '.join(loads)}")
    labels = _labels(plans)
    settings += labels if len(labels) > 1 else []
    if any(plan.speed_is_measured for plan in plans):
        settings.append(SPEED_NOT_SET)
    elif speed is not None:
        settings.append(f"{short(1e3 * speed)} mm/s")
    return _line("; ".join(settings))


def kind_difference(kind: str, evaluated: str) -> str:
    """Return in which settings two kinds of campaigns differ, as their rows have them."""
    a, b = (kind_parts(each) for each in (kind, evaluated))
    differing = [name for name in a if a[name] != b[name]]
    return ", ".join(f"other {name}" for name in differing) or "other settings"


def at_pressure(kind: str) -> str:
    """Return a kind of campaign with the pressure of each load in words: 2000 N at 15 bar."""
    return _PRESSURE.sub(" at ", kind)


def kind_parts(kind: str) -> dict[str, list[str]]:
    """Return the settings of a kind of campaign by what they are."""
    bench, *settings = kind.split("; ")
    parts: dict[str, list[str]] = {
        "bench or origin": [bench],
        "cylinder size": [],
        "loads": [],
        "working speed": [],
        "labels": [],
    }
    for setting in settings:
        if setting.endswith("mm²"):
            parts["cylinder size"].append(setting)
        elif setting.startswith(tuple(f"{direction} " for direction in DIRECTIONS)):
            parts["loads"].append(setting)
        elif setting.endswith("mm/s") or setting == SPEED_NOT_SET:
            parts["working speed"].append(setting)
        else:
            parts["labels"].append(setting)
    return parts


def _distance(runs: Iterable[ScreenedRun]) -> float | None:
    known = [run.travel_m for run in runs if run.travel_m is not None]
    return sum(known) if known else None


def _work(runs: Sequence[ScreenedRun]) -> float | None:
    """Return the friction work of all runs: rejected ones have the accepted ones' mean force.

    What is wrong with a rejected run may be its force.
    """
    accepted = [run for run in runs if run.accepted and run.friction_work_j is not None]
    distance, of_accepted = _distance(runs), _distance(accepted)
    if not distance or not of_accepted:
        return None
    return sum(run.friction_work_j or 0.0 for run in accepted) * distance / of_accepted


def _labels(plans: list[RunPlan]) -> list[str]:
    return sorted({plan.label for plan in plans if plan.label})


def _line(text: str) -> str:
    text = " ".join(printable(text).split())
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"


def _moment(text: str) -> datetime | None:
    try:
        moment = datetime.fromisoformat(text)
        return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).astimezone(UTC)
    except (ValueError, OverflowError):
        return None
