"""The oil of a bench or an import map: grade, viscosity, density."""

from functools import cached_property
from typing import Annotated, Any

from pydantic import field_validator

from hbench.config import quantity as q
from hbench.config.identity import Text
from hbench.config.oil.walther import LEAST_M2_S, ViscosityLine
from hbench.config.quantity import ConfigSection

DENSITY_AT_K = 288.15  # 15 degC, at which data sheets state the density (ISO 12185)
_APART_K = 5.0  # of two points: closer ones do not give a line

KinematicViscosity = Annotated[float, q.quantity("mm^2/s", ge=LEAST_M2_S, le=0.1)]


class OilRecord(ConfigSection):
    """What a data sheet states of the oil.

    ``viscosity`` is kinematic, at two temperatures: ``{40 degC: 46 mm^2/s, 100 degC: 6.8 mm^2/s}``.
    Others follow by ASTM D341. ``density`` is that at 15 degC; it falls by ``expansion``.
    """

    grade: Text = ""  # such as HLP 46, for the report
    viscosity: dict[q.Temperature, KinematicViscosity] = {}
    density: q.Density | None = None
    expansion: Annotated[float, q.quantity("1/K", ge=0, le=2e-3)] = 7e-4  # of mineral oil

    @field_validator("viscosity")
    @classmethod
    def _two_points(cls, points: dict[float, float]) -> dict[float, float]:
        if not points:
            return points
        if len(points) != 2:
            raise ValueError(f"give it at two temperatures; found {len(points)}")
        (low, at_low), (high, at_high) = sorted(points.items())
        if high - low < _APART_K:
            raise ValueError(f"the temperatures are {high - low:.3g} K apart; limit {_APART_K:g} K")
        if at_high >= at_low:
            raise ValueError("viscosity must be lower at the higher temperature")
        return points

    @cached_property
    def line(self) -> ViscosityLine | None:
        """Viscosity over temperature; None where it is not known."""
        return ViscosityLine.through(self.viscosity) if self.viscosity else None

    def viscosity_ratio(self, t_k: Any, t_ref_k: float) -> Any:
        """Return eta(T) / eta(T_ref) at temperatures [K]; None where the viscosity is not known."""
        if self.line is None:
            return None
        kinematic = self.line.kinematic_m2_s
        return kinematic(t_k) / kinematic(t_ref_k) * self._lightness(t_ref_k) / self._lightness(t_k)

    def _lightness(self, t_k: Any) -> Any:
        """Return rho_15 / rho(T) = 1 + expansion (T - 15 degC)."""
        return 1.0 + self.expansion * (t_k - DENSITY_AT_K)

    def dynamic_pa_s(self, t_k: Any) -> Any:
        """Return eta = nu rho [Pa s] at temperatures [K]; None where either is not known."""
        if self.line is None or self.density is None:
            return None
        return self.line.kinematic_m2_s(t_k) * self.density / self._lightness(t_k)
