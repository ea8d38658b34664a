"""The fit file: laws, bounds, weights and loss."""

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from hbench.config import quantity as q
from hbench.config.files.loading import validate
from hbench.config.quantity import ConfigSection
from hbench.records.friction_laws import FRICTION_LAWS

FITTED_LAWS = tuple(name for name, law in FRICTION_LAWS.items() if law.data != "motions")

if TYPE_CHECKING:
    LawName = str
else:
    LawName = Literal[FITTED_LAWS]


def _rises(bounds: tuple[float, float]) -> tuple[float, float]:
    if not bounds[0] < bounds[1]:
        raise ValueError("the lower bound must be less than the upper")
    return bounds


_Force = Annotated[float, q.quantity("N", ge=-1e7, le=1e7)]
_Speed = Annotated[float, q.quantity("m/s", gt=0, le=10)]
_Slope = Annotated[float, q.quantity("N s/m", ge=-1e7, le=1e7)]
_Rate = Annotated[float, q.quantity("s/m", ge=-1e4, le=0)]
_rising = AfterValidator(_rises)


class FitBounds(ConfigSection):
    """Bounds of parameters, by their names in the results; None: those of the measured points.

    ``bounds: table_6_1`` instead of a section gives the source's, which it set after seeing the
    data of one bench.
    """

    f_coulomb_n: Annotated[tuple[_Force, _Force], _rising] | None = None
    f_stiction_n: Annotated[tuple[_Force, _Force], _rising] | None = None
    v_stribeck_m_s: Annotated[tuple[_Speed, _Speed], _rising] | None = None
    b_viscous_n_s_m: Annotated[tuple[_Slope, _Slope], _rising] | None = None
    # From no decay to a decay over 2 mm/s, below the lowest steady speeds.
    k2_s_m: Annotated[tuple[_Rate, _Rate], _rising] = (-500.0, 0.0)


TABLE_6_1 = FitBounds.model_validate(
    {
        "f_coulomb_n": ("0 N", "100 kN"),
        "f_stiction_n": ("0 N", "100 kN"),
        "v_stribeck_m_s": ("50 mm/s", "200 mm/s"),
        "b_viscous_n_s_m": ("0 N s/m", "1e5 N s/m"),
    }
)


def _named(bounds: object) -> object:
    return TABLE_6_1 if bounds == "table_6_1" else bounds


class Fitting(ConfigSection):
    """Settings of the fits of friction laws to curves."""

    laws: tuple[LawName, ...] = Field(default=FITTED_LAWS, min_length=1)
    bounds: Annotated[FitBounds, BeforeValidator(_named)] = FitBounds()
    weights: Literal["trials", "equal"] = "trials"
    loss: Literal["linear", "huber", "soft_l1"] = "linear"
    reference_temperature: q.Temperature = 313.15  # 40 degC, of friction reduced to it
    bootstrap: q.WholeNumber = Field(default=0, ge=0, le=100_000)  # resampled campaigns


def parse_fitting(data: dict[str, Any], source: str) -> Fitting:
    """Check the mapping of a fit file. Raises ``ConfigError``."""
    return validate(Fitting, data, source)
