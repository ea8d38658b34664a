"""Results of ``identify``: friction laws of the test cylinder and their verification. In SI.

And those of ``simulate``, which runs a model under the measured valve commands.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hbench.records.curves import Curve
from hbench.records.fits import Fit
from hbench.records.runs import Direction, Provenance, Run

PARTS = ("steady", "unsteady", "rest")  # of a verification run
NEGLIGIBLE_MISFIT = 0.05  # of friction
MEMORY_M = 0.02  # about ten presliding lengths, after which the initial state has no effect


@dataclass(frozen=True)
class ModelErrors:
    """Root mean square differences from the measurement over a part of the samples."""

    friction_n: float
    v_m_s: float
    p_tp_pa: float
    p_tr_pa: float
    samples: int


@dataclass(frozen=True)
class SteadyParts:
    """Errors at constant speeds, apart for parts where the simulated friction oscillates."""

    smooth: ModelErrors | None  # None: no such part
    oscillating: ModelErrors | None
    parts: int  # of constant speed
    speeds_m_s: tuple[float, ...]  # of the oscillating parts, without sign


@dataclass(frozen=True)
class LackOfFit:
    """Differences of the measured friction from a law, and the part that repeats in all trials.

    All numbers are root mean squares.
    """

    friction_n: float  # measured; in motion less its mean over the run
    error_n: float  # all differences; in motion less their mean over the run
    scatter_n: float  # part that the trials' scatter explains; in motion with the noise
    misfit_n: float  # part that repeats, and that no known error of the instruments explains
    significant: bool  # whether the misfit is more than the scatter makes it
    compared: int  # points of steady curves, or runs in motion

    @property
    def share(self) -> float:
        """The misfit as a share of friction."""
        return self.misfit_n / self.friction_n if self.friction_n > 0 else 0.0

    @property
    def describes(self) -> bool:
        """Whether the law describes the friction but for scatter and a small share."""
        return not (self.significant and self.share > NEGLIGIBLE_MISFIT)


@dataclass(frozen=True)
class IdentifiedLaw:
    """One friction law: its fit, or the reason why there is none."""

    law: str
    fit: Fit | None  # None with a reason
    reason: str = ""
    section: dict[str, Any] = field(default_factory=dict)  # of a bench file, as it is written
    runs: tuple[str, ...] = ()  # that it was identified from
    errors: dict[str, ModelErrors] = field(default_factory=dict)  # by ``PARTS``; empty: not tried
    steady: SteadyParts | None = None  # None: not tried
    not_verified: str = ""  # why there are no errors, or not those of all runs
    # Root mean square error [N] of the law's friction along motions that were left out of the fit.
    held_out_n: float | None = None
    held_out_runs: tuple[str, ...] = ()
    misfit: LackOfFit | None = None  # at steady speeds; None: not known
    misfit_in_motion: LackOfFit | None = None  # of a dynamic law along reversing motions


@dataclass(frozen=True)
class RampComparison:
    """Tustin fits of a steady curve and of ramps, each on its own data and on the other's."""

    direction: Direction
    f_load_n: float | None
    p_lr_ref_pa: float | None
    a_ref_m_s2: float
    steady_on_steady_n: float  # root mean square errors
    steady_on_ramp_n: float
    ramp_on_steady_n: float
    ramp_on_ramp_n: float
    runs: tuple[str, ...]  # ramps


@dataclass(frozen=True)
class Trace:
    """Friction and velocity over time."""

    t_s: np.ndarray  # (n,)
    v_m_s: np.ndarray  # (n,)
    friction_n: np.ndarray  # (n,)


@dataclass(frozen=True)
class Followed:
    """One verification run, as measured and as the models followed its profile."""

    run: str
    f_load_n: float | None
    p_lr_ref_pa: float | None
    measured: Trace
    modelled: dict[str, Trace]  # by law
    compared_from_s: float = 0.0  # before, friction depends on the state before the log


@dataclass(frozen=True)
class LawsAlongCurve:
    """A measured steady curve, and the steady friction of the laws between its ends."""

    curve: Curve
    v_m_s: np.ndarray  # (n,)
    friction_n: dict[str, np.ndarray]  # by law, (n,)


@dataclass(frozen=True)
class Identification:
    """Friction laws identified from a campaign, and their errors in a model of the bench."""

    provenance: Provenance
    laws: tuple[IdentifiedLaw, ...]
    ramps: tuple[RampComparison, ...]
    no_ramps: str  # why ``ramps`` is empty
    verification_runs: tuple[str, ...]
    scatter: dict[str, ModelErrors]  # between the trials of a verification run, by ``PARTS``
    not_verified: str  # why no run verified the laws; empty if one did
    followed: tuple[Followed, ...]  # the first trial of each profile and load
    left_out: tuple[str, ...]  # runs that took no part, each with its reason
    notes: tuple[str, ...]
    steady: tuple[LawsAlongCurve, ...] = ()


@dataclass(frozen=True)
class SignalError:
    """Root mean square error of a simulated signal, in ``unit``."""

    signal: str
    unit: str
    off: float  # over all runs
    worst: float  # of the worst run
    worst_run: str


@dataclass(frozen=True)
class Replay:
    """SIMULATED runs of a model under measured valve commands and supply pressure."""

    provenance: Provenance  # of the measured campaign
    model: str  # file name
    bench: dict[str, Any]  # the campaign's bench file, under a name that says simulated
    runs: tuple[Run, ...]  # labelled as simulated; commands and supply are the measured ones
    off: tuple[SignalError, ...]  # by signal
    left_out: tuple[str, ...]  # runs that could not be simulated, each with its reason
