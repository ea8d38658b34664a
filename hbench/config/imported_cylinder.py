"""The actuator under test of another bench."""

import math
from typing import Annotated

from pydantic import model_validator

from hbench.config import quantity as q
from hbench.config.quantity import ConfigSection

Area = Annotated[float, q.quantity("mm^2", gt=0, le=10)]
RodArea = Annotated[float, q.quantity("mm^2", ge=0, le=10)]
Displacement = Annotated[float, q.quantity("cm^3", gt=0, le=1)]  # a radian has no dimension


class ImportedCylinder(ConfigSection):
    """The actuator under test of another bench, by diameters, areas or displacement.

    ``displacement`` is the volume for one radian of a rotary actuator with equal sides.
    """

    piston_diameter: q.Length | None = None
    rod_diameter: Annotated[float, q.quantity("mm", ge=0, le=20)] = 0.0
    piston_area: Area | None = None
    rod_area: RodArea | None = None  # of the rod side, the annulus
    displacement: Displacement | None = None
    stroke: q.Length | None = None  # for end_stop; x_m is 0 with the piston fully retracted

    @property
    def rotary(self) -> bool:
        """Whether positions are angles and forces torques."""
        return self.displacement is not None

    @property
    def area_piston_m2(self) -> float:
        """A_p, or the displacement of a radian [m^3]; 0 if neither is known."""
        if self.piston_diameter is not None:
            return math.pi / 4 * self.piston_diameter**2
        return self.displacement or self.piston_area or 0.0

    @property
    def area_rod_m2(self) -> float:
        """A_r, the annulus, or the displacement of a radian [m^3]."""
        if self.piston_diameter is not None:
            return math.pi / 4 * (self.piston_diameter**2 - self.rod_diameter**2)
        return self.displacement or self.rod_area or 0.0

    @property
    def known(self) -> bool:
        """Whether it is a hydraulic actuator: it has a size."""
        return self.area_piston_m2 > 0.0

    @model_validator(mode="after")
    def _one_size(self) -> "ImportedCylinder":
        given = [
            name
            for name in ("piston_diameter", "piston_area", "displacement")
            if getattr(self, name) is not None
        ]
        if len(given) != 1:
            raise ValueError(
                "give one of piston_diameter (with rod_diameter), piston_area (with rod_area) and "
                f"displacement; found {' and '.join(given) or 'none'}"
            )
        if given == ["piston_diameter"] and self.rod_diameter >= (self.piston_diameter or 0):
            raise ValueError("rod_diameter must be smaller than piston_diameter")
        if self.rod_area is not None and given != ["piston_area"]:
            raise ValueError("rod_area needs piston_area")
        if (self.rod_area or 0.0) > (self.piston_area or math.inf):
            raise ValueError("rod_area, the annulus, must not be larger than piston_area")
        if self.rod_diameter and given != ["piston_diameter"]:
            raise ValueError("rod_diameter needs piston_diameter")
        return self


NO_CYLINDER = ImportedCylinder.model_construct()
