"""Precision of the measurement over the campaigns of a fleet, after ISO 5725."""

import math
from dataclasses import dataclass

from hbench.records.fleet.campaigns import Quantity, Side

CYLINDER = "cylinder"  # the source of variance that is not of the measurement
LIMIT_FACTOR = 2.8  # from a standard deviation to the limit of a difference (ISO 5725-6, 4.1.3)


@dataclass(frozen=True)
class Estimate:
    """A number that is not negative, with its 95 % interval; no upper end: not bounded."""

    value: float
    low: float
    high: float | None


@dataclass(frozen=True)
class VarianceSource:
    """Part of the variance of a number: by cylinder, operator, mounting, day or trials."""

    name: str
    levels: int  # of its factor; of trials, their degrees of freedom
    variance: Estimate  # by REML
    anova: float  # variance by ANOVA; may be negative


@dataclass(frozen=True)
class Precision:
    """Repeatability and reproducibility of one number, in SI, after ISO 5725."""

    quantity: Quantity
    direction: Side
    campaigns: int
    cylinders: int
    trials: float  # of a campaign, harmonic mean
    mean: float
    sources: tuple[VarianceSource, ...]  # cylinders first, trials last
    repeatability: Estimate  # standard deviation s_r: of trials
    reproducibility: Estimate  # standard deviation s_R: of everything but the cylinders
    share_of_total: Estimate | None  # s_R over the standard deviation of all sources, 0 to 1
    tolerance: float | None  # width between the limits; None: not given

    @property
    def limits(self) -> tuple[float, float]:
        """Limits r and R of the difference of two single trials at 95 % (ISO 5725-6, 4.1.4)."""
        return LIMIT_FACTOR * self.repeatability.value, LIMIT_FACTOR * self.reproducibility.value

    @property
    def critical_difference(self) -> float:
        """Largest difference of two campaigns of one cylinder at 95 % (ISO 5725-6, 4.2.2.1).

        CD = sqrt(R^2 - r^2 (1 - 1/n)) for means of n trials each.
        """
        r, limit = self.limits
        return math.sqrt(max(limit**2 - r**2 * (1 - 1 / self.trials), 0.0))

    @property
    def share_of_tolerance(self) -> float | None:
        """6 s_R over the width of the tolerance (AIAG, Measurement Systems Analysis, %GRR)."""
        return None if self.tolerance is None else 6 * self.reproducibility.value / self.tolerance

    @property
    def distinct_categories(self) -> float | None:
        """1.41 times the cylinders' standard deviation over s_R (AIAG, ndc)."""
        of_cylinders = [s.variance.value for s in self.sources if s.name == CYLINDER]
        if not of_cylinders or not self.reproducibility.value:
            return None
        return 1.41 * math.sqrt(of_cylinders[0]) / self.reproducibility.value
