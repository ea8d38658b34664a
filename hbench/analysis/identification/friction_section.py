"""From a fitted friction law to the friction section of a bench or plant file."""

from typing import Any

from hbench.records import Fit

# A fit's parameter -> the section's key and its unit there.
_KEYS = {
    "f_coulomb_n": ("coulomb", "N"),
    "f_stiction_n": ("stiction", "N"),
    "v_stribeck_m_s": ("stribeck_velocity", "mm/s"),
    "b_viscous_n_s_m": ("viscous", "N s/m"),
    "sigma0_n_m": ("bristle_stiffness", "N/m"),
    "sigma1_n_s_m": ("bristle_damping", "N s/m"),
    "delta_max_m": ("presliding", "mm"),
    "k_piston_n_pa": ("piston_seal", "N/bar"),
    "k_rod_n_pa": ("rod_seal", "N/bar"),
    "k1_n": ("stribeck_force", "N"),
    "k2_s_m": ("stribeck_rate", "s/m"),
    "k3_n_pa": ("piston_seal", "N/bar"),
    "k4_n_pa": ("rod_seal", "N/bar"),
    "k5_n_s_m": ("viscous", "N s/m"),
    "low_force_n": ("low_force", "N"),
    "low_slope_n_s_m": ("low_slope", "N s/m"),
    "high_force_n": ("high_force", "N"),
    "high_slope_n_s_m": ("high_slope", "N s/m"),
}
_FACTORS = {"mm/s": 1e3, "mm": 1e3, "N/bar": 1e5}
_NO_SCATTER = {"scatter": "0 %"}
_NO_SEALS = {"piston_seal": "0 N/bar", "rod_seal": "0 N/bar"}
# What a law has and its fit does not tell. Without it a file laid over another of the same law
# would keep that one's value.
_NOT_FITTED: dict[str, dict[str, Any]] = {
    "tustin": _NO_SCATTER | _NO_SEALS | {"stribeck_exponent": 1.0},
    "marton_lantos": _NO_SCATTER,
    "pressure_based": _NO_SCATTER,
    "lugre": _NO_SCATTER | {"stribeck_exponent": 1.0},
    "leuven": _NO_SCATTER | {"stribeck_exponent": 1.0, "shape": 1.0, "bristle_damping": "0 N s/m"},
}
_DIGITS = 6


def friction_section(fit: Fit) -> dict[str, Any]:
    """Return a fit as a cylinder's section of a bench file: every key of its law, with units.

    Values have six digits. The lines of Marton and Lantos may be named by direction
    (``extend_low_force_n``). The section is not checked: see ``config.friction.parse_friction``.
    """
    section: dict[str, Any] = {"law": fit.law}
    for name, parameter in fit.parameters.items():
        direction, _, rest = name.partition("_")
        into, own = section, name
        if direction in ("extend", "retract"):
            into, own = section.setdefault(direction, {}), rest
        if own.startswith("theta_"):
            section.setdefault("elements", []).append(_quantity(parameter.value, "N"))
        elif own in _KEYS:
            key, unit = _KEYS[own]
            into[key] = _quantity(parameter.value, unit)
    return section | {
        key: value for key, value in _NOT_FITTED[fit.law].items() if key not in section
    }


def _quantity(si: float, unit: str) -> str:
    return f"{_FACTORS.get(unit, 1.0) * si:.{_DIGITS}g} {unit}"
