"""Results of a campaign, the last product of the flow."""

from collections import Counter
from dataclasses import dataclass, field
from itertools import chain

from hbench.records.curves import Band, BandTrend, Curve, EfficiencyCurve, MotionBalance
from hbench.records.fits import JointFit
from hbench.records.motions import Motions
from hbench.records.runs import Provenance, ScreenedRun
from hbench.records.summary import Drift, FitVerdicts, Headline, OilTemperature, Quality


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
    motion_balances: tuple[MotionBalance, ...] = ()  # without hydraulics, or a fitted law
    drift: Drift | None = None  # None where no point was measured twice at different times
    oil_temperature: OilTemperature | None = None  # None where it was not measured
    headline: Headline = field(kw_only=True)
    quality: Quality = field(kw_only=True)

    @property
    def fit_verdicts(self) -> tuple[FitVerdicts, ...]:
        """Number of fits with each verdict, by law; joint fits included."""
        of_laws: dict[str, Counter[str]] = {}
        fits = chain((each.fits for each in self.curves), (each.fits for each in self.joint_fits))
        for fit in chain.from_iterable(fits):
            of_laws.setdefault(fit.law, Counter())[fit.verdict] += 1
        return tuple(
            FitVerdicts(
                law=law,
                fits=counts.total(),
                determined=counts["determined"],
                hardly_determined=counts["hardly determined"],
                not_determined=counts["not determined"],
                not_converged=counts["not converged"],
            )
            for law, counts in of_laws.items()
        )
