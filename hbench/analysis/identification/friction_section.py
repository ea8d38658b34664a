"""From a fitted friction law to the friction section of a bench or plant file."""

from typing import Any

from hbench.records import DIRECTIONS, Fit
from hbench.records.friction_laws import FRICTION_LAWS, parameter_named
from hbench.units import from_si

_DIGITS = 6


def friction_section(fit: Fit) -> dict[str, Any]:
    """Return a fit as a cylinder's section of a bench file: every key of its law, with units.

    Values have six digits. The lines of Marton and Lantos may be named by direction
    (``extend_low_force_n``). The section is not checked: see ``config.friction.parse_friction``.
    """
    law = FRICTION_LAWS[fit.law]
    section: dict[str, Any] = {"law": law.name}
    for name, fitted in fit.parameters.items():
        parameter, direction = parameter_named(name), name.partition("_")[0]
        if parameter is None or not parameter.key:
            continue
        into = section.setdefault(direction, {}) if direction in DIRECTIONS else section
        value = _quantity(fitted.value, parameter.shown)
        if parameter.of_several:
            into.setdefault(parameter.key, []).append(value)
        else:
            into[parameter.key] = value
    # A file laid over another of the same law would keep that one's value of a key left out.
    return section | {key: value for key, value in law.neutral.items() if key not in section}


def _quantity(si: float, unit: str) -> str | float:
    number = f"{from_si(si, unit):.{_DIGITS}g}"
    return float(number) if unit == "1" else f"{number} {unit}"
