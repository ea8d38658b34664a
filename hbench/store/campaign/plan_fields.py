"""Reader of a run's plan from the journal's fields, with a check of every value."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from hbench.records import (
    KINDS,
    Factors,
    LevelReference,
    Motion,
    RunPlan,
    Segment,
    Specimen,
    kind_names,
)

_LENGTH, _SPEED, _SLOPE = (-1e3, 1e3), (-1e3, 1e3), (-1e6, 1e6)
_FORCE, _PRESSURE, _TIME = (-1e10, 1e10), (-1e11, 1e11), (0, 1e6)
_LEAST_AREA_M2 = 1e-9
# No bench exceeds these ranges: a value outside is a mistake.
_RANGES = {
    "trial": (1, 1e6),
    "v_ref_m_s": _SPEED,
    "a_ref_m_s2": _SLOPE,
    "f_load_n": _FORCE,
    "p_lr_ref_pa": _PRESSURE,
    "p_lp_ref_pa": _PRESSURE,
    "area_piston_m2": (0, 1e2),
    "area_rod_m2": (0, 1e2),
    "stroke_m": (1e-6, 1e3),
    "x_low_m": _LENGTH,
    "x_high_m": _LENGTH,
    "x_start_m": _LENGTH,
    "x_min_m": _LENGTH,
    "x_max_m": _LENGTH,
    "hold_s": _TIME,
    "dwell_s": _TIME,
    "cycles": (1, 1e6),
    "within": (0, 1e3),
    "v_m_s": _SPEED,
    "a_m_s2": _SLOPE,
    "duration_s": _TIME,
    "force_rate_n_s": _FORCE,
    "displacement_m": _LENGTH,
    "pressure_pa": _PRESSURE,
    "limit_pa": (0, 1e11),
}
_TEXTS = ("kind", "label", "until")
_FLAGS = ("closed", "vented", "speed_is_measured", "load_cell_free")


def check_number(name: str, value: Any) -> None:
    """Raise ``ValueError`` unless ``value`` is a finite number in the range of its name."""
    low, high = _RANGES[name]
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{name} is {str(value)[:40]!r}, not a number")
    if not low <= value <= high:  # nor is NaN
        raise ValueError(f"{name} is {str(value)[:40]}; expected {low:g} to {high:g}")


def check_plan(plan: RunPlan) -> None:
    """Raise ``ValueError`` for a plan with a value that ``read_plan`` refuses."""
    read_plan(plan.run, {key: value for key, value in asdict(plan).items() if key != "run"})


def read_plan(run: str, fields: Mapping[str, Any]) -> RunPlan:
    """Return the plan in ``fields``. Raises ``ValueError``, ``TypeError``, ``KeyError``."""
    fields = dict(fields)
    specimen, motion = dict(fields.pop("specimen")), fields.pop("motion", None)
    factors = read_factors(fields.pop("factors", {}))
    level = fields.pop("level", None)
    if fields["v_ref_m_s"] is None or fields["kind"] not in KINDS:
        raise ValueError(f"kind is {fields['kind']!r}; expected one of {kind_names()}")
    _check(fields)
    _check(specimen)
    fields |= {"motion": _motion(motion), "factors": factors, "level": _level(level)}
    plan = RunPlan(run=run, **fields, specimen=Specimen(**specimen))
    if 0 < plan.specimen.area_piston_m2 < _LEAST_AREA_M2:
        raise ValueError(
            f"area_piston_m2 is {plan.specimen.area_piston_m2:g}; expected {_LEAST_AREA_M2:g} or "
            "more, or 0 without hydraulics"
        )
    if plan.specimen.area_rod_m2 > plan.specimen.area_piston_m2:
        raise ValueError("area_rod_m2, the annulus, is larger than area_piston_m2")
    return plan


def read_factors(values: Any) -> Factors:
    """Return factors, given as a mapping or as pairs. Raises ``ValueError``."""
    try:
        factors = dict(values)
    except (TypeError, ValueError):
        raise ValueError("factors is not a mapping of names to values") from None
    for text in (*factors, *factors.values()):
        if not isinstance(text, str) or not text.isprintable():
            raise ValueError(f"factors has {str(text)[:40]!r}, which is not printable text")
    return tuple(factors.items())


def _level(fields: Mapping[str, Any] | None) -> LevelReference | None:
    if fields is None:
        return None
    _check(fields)
    return LevelReference(**fields)


def _motion(fields: Mapping[str, Any] | None) -> Motion | None:
    if fields is None:
        return None
    others = {key: value for key, value in fields.items() if key != "segments"}
    _check(others)
    for segment in fields["segments"]:
        _check(segment)
    return Motion(**others, segments=tuple(Segment(**segment) for segment in fields["segments"]))


def _check(section: Mapping[str, Any]) -> None:
    for key, value in section.items():
        if key in _TEXTS:
            if not isinstance(value, str):
                raise ValueError(f"{key} is {str(value)[:40]!r}, not text")
        elif key in _FLAGS:
            if not isinstance(value, bool):
                raise ValueError(f"{key} is {str(value)[:40]!r}, neither true nor false")
        elif key in _RANGES:
            if value is not None:
                check_number(key, value)
        else:
            raise ValueError(f"unknown key {str(key)[:40]!r}")
