"""Verification of friction laws: errors of a law's model on measured runs.

A model of the bench with the identified law follows the same profile under the same controller
(sections 5.4 and 5.5). Its log is compared with the measured one sample by sample. Samples are
steady if the reference has been constant for 0.3 s, at rest if it has been zero for as long
(friction then equals the applied force, which no static law describes), else unsteady. As in the
fits, the first 20 mm of the measured motion are not compared: there friction depends on how the
piston came to rest before the log began.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence

import numpy as np

from hbench.analysis.screening.sample_friction import LoggedMotion, logged_motion
from hbench.errors import DataError
from hbench.records import ModelErrors, Run
from hbench.records.identification import PARTS, SteadyParts

SETTLE_S = 0.3  # as in the steady window
_OSCILLATES = 3.0  # simulated friction scatters by more than this times the measured friction


def unchanged(v_ref_m_s: np.ndarray, dt_s: float) -> np.ndarray:
    """Return whether the reference has been constant for 0.3 s at each sample (n,)."""
    changed = np.concatenate(([True], np.diff(v_ref_m_s) != 0))
    last = np.maximum.accumulate(np.where(changed, np.arange(len(changed)), 0))
    return (np.arange(len(changed)) - last) * dt_s > SETTLE_S - 0.5 * dt_s


def model_errors(
    measured: Sequence[Run], simulated: Sequence[Run], mass_kg: float
) -> dict[str, ModelErrors]:
    """Return the errors in the ``steady``, ``unsteady`` and ``rest`` sections of all runs.

    Each pair of runs has the same profile; if one of them is shorter, the common time counts.
    ``mass_kg`` is the test side's. Raises ``DataError``.
    """
    errors = _SectionErrors()
    for v_ref, log, signals, simulation in _pairs(measured, simulated, mass_kg):
        errors.add(v_ref, log, simulation - signals)
    return errors.rms()


def steady_parts(measured: Sequence[Run], simulated: Sequence[Run], mass_kg: float) -> SteadyParts:
    """Return the errors of the ``steady`` section, apart for parts that oscillate in simulation.

    A part is a time of constant reference. It oscillates if the standard deviation of the
    simulated friction is more than three times that of the measured one: where friction falls with
    speed, a static law damps no oscillation. Arguments and errors as of ``model_errors``.
    """
    differences: dict[bool, list[np.ndarray]] = {False: [], True: []}
    speeds = []
    for v_ref, motion, log, simulation in _pairs(measured, simulated, mass_kg):
        steady = unchanged(v_ref, motion.dt_s) & (v_ref != 0) & motion.compared[: len(v_ref)]
        edges = np.flatnonzero(np.diff(np.concatenate(([False], steady, [False]))))
        for part in map(slice, edges[::2], edges[1::2]):
            oscillates = bool(simulation[0, part].std() > _OSCILLATES * log[0, part].std())
            differences[oscillates].append((simulation - log)[:, part].T)
            if oscillates:
                speeds.append(abs(float(v_ref[part][0])))
    return SteadyParts(
        smooth=_rms(differences[False]) if differences[False] else None,
        oscillating=_rms(differences[True]) if differences[True] else None,
        parts=len(differences[False]) + len(differences[True]),
        speeds_m_s=tuple(speeds),
    )


def _pairs(
    measured: Sequence[Run], simulated: Sequence[Run], mass_kg: float
) -> Iterator[tuple[np.ndarray, LoggedMotion, np.ndarray, np.ndarray]]:
    """Yield reference (n,), measured motion, measured and simulated signals (4, n) of each run."""
    for real, model in zip(measured, simulated, strict=True):
        if real.v_ref_m_s is None or real.plan.motion != model.plan.motion:
            raise DataError(f"run {real.plan.run}: its model followed another profile")
        n = min(len(real.t_s), len(model.t_s))
        log, simulation = logged_motion(real, mass_kg), logged_motion(model, mass_kg)
        yield real.v_ref_m_s[:n], log, _signals(log, n), _signals(simulation, n)


def trial_scatter(measured: Sequence[Run], mass_kg: float) -> dict[str, ModelErrors]:
    """Return the scatter between the trials of a profile, in the same sections.

    The deviation of each of n trials from their mean is multiplied by ``sqrt(n / (n - 1))``: these
    are the errors of a model that equals the trials' expectation. Empty if no profile has two
    trials. ``mass_kg`` is the test side's. Raises ``DataError``.
    """
    profiles: dict[tuple, list[Run]] = defaultdict(list)
    for run in measured:
        profiles[run.plan.operating_point].append(run)
    scatter = _SectionErrors()
    for runs in profiles.values():
        if len(runs) < 2 or any(run.v_ref_m_s is None for run in runs):
            continue
        n = min(len(run.t_s) for run in runs)
        motions = [logged_motion(run, mass_kg) for run in runs]
        signals = np.array([_signals(motion, n) for motion in motions])
        factor = np.sqrt(len(runs) / (len(runs) - 1))
        for run, motion, trial in zip(runs, motions, signals, strict=True):
            v_ref = run.channel("v_ref_m_s")[:n]
            scatter.add(v_ref, motion, factor * (trial - signals.mean(axis=0)))
    return scatter.rms() if scatter else {}


def _signals(motion: LoggedMotion, n: int) -> np.ndarray:
    signals = motion.friction_n, motion.v_m_s, motion.p_p_pa, motion.p_r_pa
    return np.array([signal[:n] for signal in signals])


class _SectionErrors(dict[str, list[np.ndarray]]):
    """Differences (n, 4) of the four signals, by sections of the profile."""

    def add(self, v_ref_m_s: np.ndarray, motion: LoggedMotion, difference: np.ndarray) -> None:
        """Sort one run's differences (4, n) where its measured ``motion`` is compared."""
        constant, zero = unchanged(v_ref_m_s, motion.dt_s), v_ref_m_s == 0
        sections = (constant & ~zero, ~constant, constant & zero)
        for name, section in zip(PARTS, sections, strict=True):
            self.setdefault(name, []).append(
                difference.T[section & motion.compared[: len(section)]]
            )

    def rms(self) -> dict[str, ModelErrors]:
        """Return the root mean square in each section; nan without samples."""
        return {name: _rms(pieces) for name, pieces in self.items()}


def _rms(pieces: Sequence[np.ndarray]) -> ModelErrors:
    """Return the root mean square of differences (n, 4); nan without samples."""
    d = np.concatenate(pieces)
    means = np.sqrt(np.mean(d**2, axis=0)).tolist() if len(d) else [float("nan")] * 4
    friction, v, p_p, p_r = means
    return ModelErrors(friction, v, p_p, p_r, samples=len(d))
