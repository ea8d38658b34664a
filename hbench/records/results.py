"""The last product of the flow: all that a campaign tells."""

from dataclasses import dataclass

from hbench.records.flow import Band, Curve, EfficiencyCurve, JointFit, Provenance, ScreenedRun
from hbench.records.motions import Motions


@dataclass(frozen=True)
class Results:
    """All that ``analyze`` derives from a campaign."""

    provenance: Provenance
    runs: tuple[ScreenedRun, ...]
    curves: tuple[Curve, ...]
    efficiency: tuple[EfficiencyCurve, ...]
    bands: tuple[Band, ...]
    notes: tuple[str, ...]  # what was left out, and why
    motions: Motions = Motions()
    joint_fits: tuple[JointFit, ...] = ()
