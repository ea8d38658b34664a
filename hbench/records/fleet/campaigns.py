"""Campaigns of a fleet: the quantities that are compared, and a row for each campaign."""

from dataclasses import dataclass, field
from datetime import datetime

from hbench.records.runs import DIRECTIONS, Direction

Side = Direction | None  # of a number; None: of both directions together


@dataclass(frozen=True)
class Quantity:
    """A number that a row holds, for each direction or for both together."""

    name: str  # of its columns, in SI
    words: str
    unit: str  # for display
    scale: float  # from SI to it
    of_directions: bool = True
    listed: bool = False  # in the table of the campaigns of a small fleet

    @property
    def sides(self) -> tuple[Side, ...]:
        """Return the directions that have such a number."""
        return DIRECTIONS if self.of_directions else (None,)

    def column(self, side: Side) -> str:
        """Return the name of its column: extending, ``friction_n`` is ``friction_extend_n``."""
        if side is None:
            return self.name
        unit = next((u for u in ("_n_s_m", "_m_s", "_n") if self.name.endswith(u)), "")
        return f"{self.name.removesuffix(unit)}_{side}{unit}"


QUANTITIES = (
    Quantity("friction_n", "Friction at the working speed", "N", 1.0, listed=True),
    Quantity("breakaway_n", "Breakaway, measured by ramps", "N", 1.0, listed=True),
    Quantity("breakaway_fit_n", "Breakaway, extrapolated by the fit", "N", 1.0),
    Quantity("efficiency", "Efficiency at the working speed", "%", 100.0, listed=True),
    Quantity("f_coulomb_n", "Coulomb friction", "N", 1.0),
    Quantity("v_stribeck_m_s", "Stribeck speed", "mm/s", 1e3),
    Quantity("b_viscous_n_s_m", "Viscous coefficient", "N s/m", 1.0),
    Quantity("half_band_n", "Half band at the median pressure", "N", 1.0, False, True),
    Quantity("half_band_slope_n_pa", "Slope of the half band", "N/bar", 1e5, False, True),
    Quantity("middle_n", "Middle of the band at the median pressure", "N", 1.0, False, True),
    Quantity("cycle_energy_j", "Energy of a cycle at the median pressure", "J", 1.0, False, True),
)


@dataclass(frozen=True)
class FleetNumber:
    """The mean over the loads of one direction, or over the series of bands, in SI.

    The interval's ends are the means of those of the loads: as wide as if all errors were the
    same at each load, which is an upper bound. The trials of the loads are independent.
    """

    value: float
    low: float | None = None  # 95 % interval; with instruments where they are known and count
    high: float | None = None
    se: float | None = None  # standard error of the trials alone
    trials: float | None = None  # repeats that ``se`` is of; of several loads, their harmonic mean
    dof: float | None = None  # degrees of freedom of ``se``


@dataclass(frozen=True)
class FleetRow:
    """Row of a fleet: one campaign. ``failed`` is why it could not be analyzed, or empty."""

    path: str
    failed: str = ""
    name: str = ""
    source: str = ""
    bench: str = ""
    label: str = ""  # of the series; several with commas between
    specimen: str = ""  # serial number
    operator: str = ""
    mounting: str = ""
    day: str = ""  # date of the measurement, as far as it is known
    seed: int | None = None  # of the virtual rig
    started: datetime | None = None
    # What must be the same where cylinders are compared: diameters, loads, working speed if set.
    protocol: str = ""
    area_piston_m2: float | None = None
    area_rod_m2: float | None = None
    stroke_m: float | None = None
    quality: str = ""  # good, with care, poor
    drift_possible: float | None = None  # share of friction that runs mixed with speed may hide
    weak: str = ""  # checks of the data with that grade, with commas between; empty: all are good
    missing: str = ""  # runs and trials of the plan that the campaign does not have
    logs_sha256: str = ""  # of all logs together: a copied campaign has that of the original
    runs: int = 0
    accepted: int = 0
    v_m_s: float | None = None  # working speed
    distance_m: float | None = None  # travelled in the logged runs
    friction_work_j: float | None = None  # of these
    numbers: dict[tuple[str, Side], FleetNumber] = field(default_factory=dict)


@dataclass(frozen=True)
class FleetCampaign:
    """A campaign of a small fleet, with its numbers by their columns."""

    path: str
    compared: bool  # of the evaluated kind
    name: str
    label: str
    quality: str
    missing: str  # of the plan; empty if it is complete
    report: str  # its page, relative to the fleet's; empty where there is none
    decision: str  # of its last acceptance; empty where there is none
    v_m_s: float | None  # working speed
    numbers: dict[str, FleetNumber]
    specimen: str = ""  # serial number
    started: datetime | None = None
    protocol: str = ""  # kind of campaign
    copy_of: str = ""  # path of the campaign with the same logs
