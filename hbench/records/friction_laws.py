"""The table of friction laws: formulas, parameters with symbols and units, keys of the files.

Everything that lists laws or their parameters takes them from here, or a test compares it with
this table (``tests/model/test_law_table.py``). The formulas as code are in
``model/friction/formulas.py``.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from hbench.records.runs import DIRECTIONS


@dataclass(frozen=True)
class LawParameter:
    """Parameter of a friction law, as fits report it and as bench and plant files name it."""

    name: str  # in results; ends in its SI unit; "_i_" is the number of one of several
    unit: str  # of results, SI
    shown: str  # unit on pages and in bench and plant files
    symbol: str
    title: str = ""
    key: str = ""  # of the law's section in bench and plant files; empty: not in them

    @property
    def of_several(self) -> bool:
        """Whether it is one of a list, as the elements of Leuven's law."""
        return "_i_" in self.name

    @property
    def label(self) -> str:
        """Title and symbol for a table or a sentence."""
        return f"{self.title} {self.symbol}".strip()


@dataclass(frozen=True)
class FrictionLaw:
    """Friction law of one cylinder."""

    name: str  # in files and results
    title: str
    equations: str  # of the source
    formula: str
    data: Literal["curve", "curves", "motions"]  # that its parameters are fitted to
    parameters: tuple[LawParameter, ...]  # in the order of its fit
    neutral: Mapping[str, str | float]  # file keys that a fit may leave out, without their effect
    dynamic: bool = False  # it has states of its own
    by_direction: bool = False  # the keys of the parameters are given for extend and retract

    @property
    def units(self) -> dict[str, str]:
        """SI units of the parameters by name."""
        return {parameter.name: parameter.unit for parameter in self.parameters}

    @property
    def keys(self) -> frozenset[str]:
        """Keys of the parameters in bench and plant files."""
        return frozenset(p.key for p in self.parameters if p.key)


_COULOMB = LawParameter("f_coulomb_n", "N", "N", "F_C", "Coulomb force", "coulomb")
_STATIC = LawParameter("f_stiction_n", "N", "N", "F_s", "Static friction", "stiction")
_STRIBECK = LawParameter(
    "v_stribeck_m_s", "m/s", "mm/s", "v_s", "Stribeck velocity", "stribeck_velocity"
)
_VISCOUS = LawParameter("b_viscous_n_s_m", "N s/m", "N s/m", "B", "Viscous coefficient", "viscous")
_SIGMA_1 = LawParameter(
    "sigma1_n_s_m", "N s/m", "N s/m", "σ_1", "Bristle damping", "bristle_damping"
)
_SEALS = (
    LawParameter("k_piston_n_pa", "N/Pa", "N/bar", "k_piston", "Piston seal", "piston_seal"),
    LawParameter("k_rod_n_pa", "N/Pa", "N/bar", "k_rod", "Rod seal", "rod_seal"),
)
_CURVE = (_COULOMB, _STATIC, _STRIBECK, _VISCOUS)  # of Stribeck
_NO_SCATTER: dict[str, str | float] = {"scatter": "0 %"}
_EXPONENTIAL: dict[str, str | float] = {"stribeck_exponent": 1.0}

_ROWS = (
    FrictionLaw(
        name="tustin",
        title="Tustin",
        equations="3.2",
        formula="F = sign(v) (F_C + (F_s − F_C) exp(−|v|/v_s)) + B v",
        data="curve",
        parameters=_CURVE,
        neutral={
            **_NO_SCATTER,
            "piston_seal": "0 N/bar",
            "rod_seal": "0 N/bar",
            **_EXPONENTIAL,
        },
    ),
    FrictionLaw(
        name="marton_lantos",
        title="Marton and Lantos",
        equations="3.3",
        formula="F = sign(v) (a_1 + b_1 |v|) up to v_SW, sign(v) (a_2 + b_2 |v|) above it",
        data="curve",
        parameters=(
            LawParameter("low_force_n", "N", "N", "a_1", "Force at rest", "low_force"),
            LawParameter(
                "low_slope_n_s_m", "N s/m", "N s/m", "b_1", "Slope below v_SW", "low_slope"
            ),
            LawParameter(
                "high_force_n", "N", "N", "a_2", "Intercept of the high-speed line", "high_force"
            ),
            LawParameter(
                "high_slope_n_s_m", "N s/m", "N s/m", "b_2", "Slope above v_SW", "high_slope"
            ),
            LawParameter("v_switch_m_s", "m/s", "mm/s", "v_SW", "Switch velocity"),
        ),
        neutral=_NO_SCATTER,
        by_direction=True,
    ),
    FrictionLaw(
        name="pressure_based",
        title="Pressure-based",
        equations="3.7",
        formula="F = sign(v) (k_1 exp(k_2 |v|) + k_3 |P_p − P_r| + k_4 P_r + k_5 |v|)",
        data="curves",
        parameters=(
            LawParameter("k1_n", "N", "N", "k_1", "Force at rest", key="stribeck_force"),
            LawParameter("k2_s_m", "s/m", "s/m", "k_2", "Rate of decay", key="stribeck_rate"),
            LawParameter("k3_n_pa", "N/Pa", "N/bar", "k_3", "Piston seal", key="piston_seal"),
            LawParameter("k4_n_pa", "N/Pa", "N/bar", "k_4", "Rod seal", key="rod_seal"),
            LawParameter("k5_n_s_m", "N s/m", "N s/m", "k_5", "Viscous coefficient", key="viscous"),
        ),
        neutral=_NO_SCATTER,
    ),
    FrictionLaw(
        name="lugre",
        title="LuGre",
        equations="3.8 to 3.12",
        formula="F = σ_0 z + σ_1 dz/dt + B v, dz/dt = v − |v| z σ_0 / F_dry(v)",
        data="motions",
        parameters=(
            LawParameter(
                "sigma0_n_m", "N/m", "N/mm", "σ_0", "Bristle stiffness", "bristle_stiffness"
            ),
            _SIGMA_1,
            *_CURVE,
            *_SEALS,
        ),
        neutral=_NO_SCATTER | _EXPONENTIAL,
        dynamic=True,
    ),
    FrictionLaw(
        name="leuven",
        title="Leuven",
        equations="3.14 to 3.20",
        formula="F = F_h + σ_1 dz/dt + B v, dz/dt = v (1 − sign(r) |r|^n), "
        "r = F_h / (sign(v) F_dry(v)), F_h = Σ θ_i min(max(δ_i/Δ_i, −1), 1)",
        data="motions",
        parameters=(
            LawParameter("theta_i_n", "N", "N", "θ_i", "Force of element i", "elements"),
            *_CURVE,
            *_SEALS,
            LawParameter("delta_max_m", "m", "mm", "Δ_max", "Largest deflection", "presliding"),
            LawParameter("n", "", "1", "n", "Exponent", "shape"),
            _SIGMA_1,
        ),
        neutral={**_NO_SCATTER, **_EXPONENTIAL, "shape": 1.0, "bristle_damping": "0 N s/m"},
        dynamic=True,
    ),
)

FRICTION_LAWS: Mapping[str, FrictionLaw] = {law.name: law for law in _ROWS}
PARAMETERS: Mapping[str, LawParameter] = {p.name: p for law in _ROWS for p in law.parameters}


def parameter_named(name: str) -> LawParameter | None:
    """Return the parameter of a fit's name, such as ``theta_2_n`` or ``extend_low_force_n``."""
    for direction in DIRECTIONS:
        name = name.removeprefix(f"{direction}_")
    return PARAMETERS.get(re.sub(r"_\d+_", "_i_", name))
