"""Logs of one session end to end, so that a balance is evaluated for all of them at once."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from hbench.errors import DataError
from hbench.motion.local_polynomials import local_polynomials, odd_samples
from hbench.motion.standstill import standstill
from hbench.reconcile.measured.weak import EVEN, Window, sampling, window
from hbench.records import Run
from hbench.records.reconcile.diagnosis import REST_M_S

PRESSURES = ("p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa", "p_s_pa")
VELOCITY = "velocity"  # of the position, see ``Session.velocity_m_s``
COMMANDS = ("u_t_v", "u_l1_v", "u_l2_v")
RECORD_S = 0.01  # of a log with the board's rate; the records of faster ones are averaged
_SMOOTHED, _ORDER = 7, 4  # samples of a polynomial, and its order
_FEWEST = 5  # samples of a polynomial of that order
_VELOCITY_S = 0.05  # of the polynomial whose slope is the velocity; at least five samples
_OSCILLATING = 10.0  # times the fluctuation of the median window
_VISIBLE = 0.01  # of a channel's range: a smaller oscillation does not matter
_FEW = 3  # records or usual steps; samples that are further apart have a gap between them
_MOST_IN_GAPS = 0.5  # of a run
_SUSTAINED = 4  # windows: what ends earlier is a transient
CAVITATES_PA = -0.3e5  # above the atmosphere; below it oil releases air, and no chamber stays full


@dataclass(frozen=True)
class Session:
    """Logs of r runs with the same sampling, in their order: n samples, w windows."""

    runs: tuple[Run, ...]
    window: Window
    channels: dict[str, np.ndarray]  # (n,) by field of ``Run``; 0 where a run does not have it
    progress: np.ndarray  # (r,) of the campaign at each run, from -1 to 1
    logged: "Session | None" = None  # the same session, before its pressures were smoothed

    @cached_property
    def edges(self) -> np.ndarray:
        """First sample of each run (r + 1,), and the number of samples."""
        return np.cumsum([0, *(len(run.t_s) for run in self.runs)])

    @cached_property
    def counts(self) -> np.ndarray:
        """Number of windows of each run (r,)."""
        return np.array([self.window.count(len(run.t_s)) for run in self.runs])

    @cached_property
    def run_of_window(self) -> np.ndarray:
        """Index (w,) of each window's run."""
        return np.repeat(np.arange(len(self.runs)), self.counts)

    @cached_property
    def measured(self) -> dict[str, np.ndarray]:
        """Whether each run has a channel (r,), by field of ``Run``."""
        return {
            name: np.array([getattr(run, name) is not None for run in self.runs])
            for name in self.channels
        }

    def drifting(self, drift: float) -> np.ndarray:
        """Return a sensor's drift (n,), from - ``drift`` in the first run to it in the last."""
        return drift * np.repeat(self.progress, np.diff(self.edges))

    def ahead(self, name: str, by_s: float) -> np.ndarray:
        """Return a channel or the velocity (n,) as it is ``by_s`` later, by a Taylor series.

        Its two terms also undo a Butterworth filter of second order, with the delay sqrt(2) / omega
        at low frequencies.
        """
        y, slope, bend = self._derivatives[name]
        return y + by_s * (slope + 0.5 * by_s * bend)

    @cached_property
    def _derivatives(self) -> dict[str, list[np.ndarray]]:
        """Signals (n,) with their first and second derivatives, hardly smoothed."""
        names = ("x_m", "f_applied_n", *PRESSURES[:4])
        signals = {name: self.channels[name] for name in names} | {VELOCITY: self.velocity_m_s}
        edges, dt_s = self.edges, self.window.dt_s
        return {
            name: [
                y,
                *(local_polynomials(y, edges, _FEWEST, _ORDER, order, dt_s) for order in (1, 2)),
            ]
            for name, y in signals.items()
        }

    def shifted(self, name: str, by_s: float) -> np.ndarray:
        """Return a channel (n,), which may have steps, as it is ``by_s`` later."""
        y = self.channels[name]
        if by_s == 0.0:
            return y
        t_s = self.channels["t_s"]
        runs = (slice(*ends) for ends in pairwise(self.edges))
        return np.concatenate([np.interp(t_s[own] + by_s, t_s[own], y[own]) for own in runs])

    @cached_property
    def _samples(self) -> np.ndarray:
        """Samples (w, k) of each window."""
        starts = [
            self.window.starts(len(run.t_s)) + first
            for run, first in zip(self.runs, self.edges, strict=False)
        ]
        return np.concatenate(starts)[:, None] + np.arange(len(self.window.value))

    @cached_property
    def velocity_m_s(self) -> np.ndarray:
        """Velocity (n,) of the position, at rest that of a longer time."""
        x, edges, dt_s = self.channels["x_m"], self.edges, self.window.dt_s
        short = odd_samples(_VELOCITY_S, dt_s, _FEWEST)
        rests = [standstill(x[start:stop], dt_s) for start, stop in pairwise(edges)]
        at_rest, resting = (np.concatenate(each) for each in zip(*rests, strict=True))
        return np.where(at_rest, resting, local_polynomials(x, edges, short, _ORDER, 1, dt_s))

    @cached_property
    def oscillating(self) -> np.ndarray:
        """Windows (w,) in which the log does not resolve the control."""
        return _oscillating(self) if self.logged is None else self.logged.oscillating

    @cached_property
    def cavitating(self) -> np.ndarray:
        """Windows (w, 4) in which a chamber's pressure is too low for the laws of its oil."""
        own = self.logged or self
        lowest = [own.channels[name][own._samples].min(axis=1) for name in PRESSURES[:4]]
        return np.column_stack(lowest) < CAVITATES_PA

    @cached_property
    def with_gaps(self) -> np.ndarray:
        """Windows (w,) with a gap between samples."""
        return self.channels["in_gap"][self._samples].any(axis=1)

    @cached_property
    def resting(self) -> np.ndarray:
        """Windows (w,) in which the piston rests."""
        return np.abs(self.rate(self.channels["x_m"])) < REST_M_S

    def mean(self, y: np.ndarray) -> np.ndarray:
        """Return <y> (..., w) of the samples (..., n)."""
        return _times(self._weights["value"], y)

    def rate(self, y: np.ndarray) -> np.ndarray:
        """Return <y'> (..., w)."""
        return _times(self._weights["slope"], y)

    def second(self, y: np.ndarray) -> np.ndarray:
        """Return <y''> (..., w)."""
        return _times(self._weights["bend"], y)

    @cached_property
    def _weights(self) -> dict[str, csr_array]:
        """Weights (w, n) of all samples in the windows, by field of ``Window``."""
        w, k = self._samples.shape
        first = np.arange(0, w * k + 1, k)
        shape = w, int(self.edges[-1])
        return {
            name: csr_array(
                (np.tile(getattr(self.window, name), w), self._samples.ravel(), first), shape
            )
            for name in ("value", "slope", "bend")
        }

    def smoothed(self) -> "Session":
        """Return the session with smoothed pressures, for the derivatives of its balances.

        Columns with dP/dt would contain the noise of the residuals themselves, and a fit would
        follow it.
        """
        smooth = {name: self.smooth(name, 2) for name in PRESSURES}
        return replace(self, channels={**self.channels, **smooth}, logged=self)

    def smooth(self, name: str, order: int) -> np.ndarray:
        """Return a channel (n,) as a polynomial through seven samples."""
        return local_polynomials(
            self.channels[name], self.edges, _SMOOTHED, order, 0, self.window.dt_s
        )


def averaged(run: Run) -> Run:
    """Return a run with means over 10 ms each; an even log of fewer records as it is.

    The laws take a record as a mean over its time, and each one costs the same. Between uneven
    samples the signals are taken as straight; records in a gap, of more than three records, are
    marked. Raises ``DataError`` where these are more than half of the run.
    """
    steps = np.diff(run.t_s)
    if not steps.any():
        return run
    usual = float(np.median(steps))
    if np.abs(steps - usual).max() > EVEN * usual:
        together = steps[steps <= _FEW * usual]
        width = max(RECORD_S, float(f"{together.mean():.1g}"))  # one for all runs
    else:
        width = usual * max(1, int(RECORD_S / usual + 1e-6))
        if width == usual:
            return run
    if run.t_s[-1] - run.t_s[0] < 2 * width:
        raise DataError(
            f"run {run.plan.run}: lasts {run.t_s[-1] - run.t_s[0]:.3g} s, with a sample every "
            f"{usual:.3g} s (two records of {width:.2g} s are required): check the unit of the time"
        )
    edges = np.arange(run.t_s[0], run.t_s[-1] + 1e-6 * width, width)
    means: dict[str, Any] = {"t_s": 0.5 * (edges[1:] + edges[:-1])}
    for field in fields(run):
        channel = getattr(run, field.name)
        if isinstance(channel, np.ndarray) and field.name != "t_s":
            mean = _means(run.t_s, channel.astype(float), edges)
            means[field.name] = mean > 1e-9 if channel.dtype == bool else mean
    in_gap = _in_gaps(run.t_s, edges, _FEW * width)
    if in_gap.mean() > _MOST_IN_GAPS:
        raise DataError(
            f"run {run.plan.run}: gaps of up to {steps.max():.3g} s between samples make up "
            f"{100 * in_gap.mean():.0f} % of its time (limit: {100 * _MOST_IN_GAPS:g} %)"
        )
    if in_gap.any():
        means["in_gap"] = in_gap
    return replace(run, **means)


def _in_gaps(t: np.ndarray, edges: np.ndarray, longest: float) -> np.ndarray:
    """Return which records between ``edges`` touch a gap between samples that is longer."""
    gaps = np.flatnonzero(np.diff(t) > longest)
    starts, stops = t[gaps], t[gaps + 1]
    touched = (starts[:, None] < edges[1:]) & (stops[:, None] > edges[:-1])
    return np.asarray(touched.any(axis=0))


def _means(t: np.ndarray, y: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the means of straight lines through samples (n,) between successive ``edges``."""
    areas = np.concatenate([[0.0], np.cumsum(0.5 * (y[1:] + y[:-1]) * np.diff(t))])
    at = np.interp(edges, t, y)
    k = np.clip(np.searchsorted(t, edges, side="right") - 1, 0, len(t) - 2)
    total = areas[k] + 0.5 * (y[k] + at) * (edges - t[k])
    return np.diff(total) / np.diff(edges)


def sessions(runs: Iterable[Run]) -> tuple[Session, ...]:
    """Return the sessions of some runs: one for each sampling. Raises ``DataError``."""
    every, by_sampling = tuple(runs), defaultdict[float, list[int]](list)
    for i, run in enumerate(every):
        by_sampling[float(f"{sampling(run):.6g}")].append(i)
    progress = np.linspace(-1.0, 1.0, len(every)) if len(every) > 1 else np.zeros(1)
    return tuple(
        _session([every[i] for i in own], dt_s, progress[own]) for dt_s, own in by_sampling.items()
    )


def _session(runs: Sequence[Run], dt_s: float, progress: np.ndarray) -> Session:
    channels = {
        name: np.concatenate([_channel(run, name) for run in runs])
        for name in ("t_s", "x_m", "v_m_s", "f_applied_n", *PRESSURES, *COMMANDS, "in_gap")
    }
    return Session(tuple(runs), window(dt_s), channels, progress)


def _oscillating(session: Session) -> np.ndarray:
    """Return which windows (w,) have an oscillation that the log does not resolve.

    In at least four successive windows a chamber's pressure or a command deviates from a polynomial
    of fourth order through seven samples by more than ten times the median deviation, and by 1 % of
    its range. Between the records such signals are no parabolas, so flows and friction along the
    log would be wrong.
    """
    found = np.zeros(len(session.run_of_window), bool)
    for name in (*PRESSURES[:4], *COMMANDS):
        values = session.channels[name]
        square = session.mean((values - session.smooth(name, _ORDER)) ** 2)
        if np.any(square > 0):
            usual = np.sqrt(np.median(square[square > 0]))
            found |= square > max(_OSCILLATING * usual, _VISIBLE * np.ptp(values)) ** 2
    runs = np.split(found, np.cumsum(session.counts)[:-1])
    return np.concatenate([_sustained(own) for own in runs])


def _channel(run: Run, name: str) -> np.ndarray:
    values = getattr(run, name)
    return np.zeros(len(run.t_s)) if values is None else values


def _sustained(found: np.ndarray) -> np.ndarray:
    """Return ``found`` (m,) without what lasts for fewer than ``_SUSTAINED`` windows."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], found, [False]])))
    kept = np.zeros_like(found)
    for start, stop in edges.reshape(-1, 2):
        kept[start:stop] = stop - start >= _SUSTAINED
    return kept


def _times(weights: csr_array, y: np.ndarray) -> np.ndarray:
    """Return the weighted sums (..., w) of samples (..., n)."""
    rows = y.reshape(-1, y.shape[-1])
    return np.array([weights @ row for row in rows]).reshape(*y.shape[:-1], -1)
