"""The fit file: which laws, within which bounds, with which weights and loss."""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from hbench.config import quantity as q
from hbench.config.loading import validate
from hbench.config.quantity import Section

LawName = Literal["tustin", "marton_lantos", "pressure_based"]


def _rises(bounds: tuple[float, float]) -> tuple[float, float]:
    if not bounds[0] < bounds[1]:
        raise ValueError("the lower bound must be less than the upper")
    return bounds


def _range(unit: str, **limits: float) -> Any:
    number = q.quantity(unit, **limits)
    return Annotated[tuple[number, number], AfterValidator(_rises)]


Range = tuple[float, float]


class FitBounds(Section):
    """Bounds of parameters, by their names in the results: table 6.1 of the source by default."""

    f_coulomb_n: _range("N", ge=-1e7, le=1e7) = (0.0, 1e5)
    f_stiction_n: _range("N", ge=-1e7, le=1e7) = (0.0, 1e5)
    v_stribeck_m_s: _range("m/s", gt=0, le=10) = (0.05, 0.2)
    b_viscous_n_s_m: _range("N s/m", ge=-1e7, le=1e7) = (0.0, 1e5)
    # From no fall at all to one over 2 mm/s, below the speeds that the bench holds.
    k2_s_m: _range("s/m", ge=-1e4, le=0) = (-500.0, 0.0)


class Fitting(Section):
    """How laws are fitted to curves."""

    laws: tuple[LawName, ...] = Field(
        default=("tustin", "marton_lantos", "pressure_based"), min_length=1
    )
    bounds: FitBounds = FitBounds()
    weights: Literal["trials", "equal"] = "trials"
    loss: Literal["linear", "huber", "soft_l1"] = "linear"
    bootstrap: int = Field(default=0, ge=0, le=100_000)  # campaigns drawn from the trials


def parse_fitting(data: dict[str, Any], source: str) -> Fitting:
    """Check the mapping of a fit file. Raises ``ConfigError``."""
    return validate(Fitting, data, source)
