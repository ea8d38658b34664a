"""Results of a campaign, the last product of the flow."""

from dataclasses import dataclass, field

from hbench.records.bands import Band, BandTrend, MotionBalance
from hbench.records.flow import (
    Curve,
    EfficiencyCurve,
    JointFit,
    Provenance,
    ScreenedRun,
)
from hbench.records.motions import Motions
from hbench.records.summary import Drift, Headline, Quality


@dataclass(frozen=True)
class Results:
    """Everything that ``analyze`` derives from a campaign."""

    provenance: Provenance
    runs: tuple[ScreenedRun, ...]
    curves: tuple[Curve, ...]
    efficiency: tuple[EfficiencyCurve, ...]
    bands: tuple[Band, ...]
    notes: tuple[str, ...]  # data left out, with the reason
    motions: Motions = Motions()
    joint_fits: tuple[JointFit, ...] = ()
    band_trends: tuple[BandTrend, ...] = ()
    motion_balances: tuple[MotionBalance, ...] = ()  # without hydraulics
    drift: Drift | None = None  # None where no point was measured twice at different times
    headline: Headline = field(kw_only=True)
    quality: Quality = field(kw_only=True)
