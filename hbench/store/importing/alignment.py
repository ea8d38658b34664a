"""Alignment of channels of different sampling rates to the times of the position."""

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from hbench.errors import DataError
from hbench.store.importing.file_notes import FileNote
from hbench.store.importing.resampling import gaps_within, interval_means
from hbench.store.importing.time_bases import TimeBase

_FASTER = 1.05  # a rate above the position's by this factor is averaged
_LONGEST_OF_OIL_S = 60.0  # between samples of its temperature, which changes slowly
_SAME = 1e-6  # of a sampling interval: times that differ by less are equal


def aligned(
    bases: Sequence[TimeBase], max_gap_s: float, source: str, name: str
) -> tuple[TimeBase, list[FileNote]]:
    """Return the channels of all ``bases`` at the times of the first, with notes.

    A channel sampled at the same or a lower rate is linearly interpolated; one sampled at a higher
    rate is averaged over the first base's sampling interval about each of its times, which keeps
    higher frequencies from aliasing. Values within a gap longer than ``max_gap_s`` (60 s for
    temperatures of the oil) are NaN. Samples outside the time range that all channels have in
    common are left out; a temperature is its first or last value for 60 s. Raises ``DataError``.
    """
    first = bases[0]
    if len(bases) == 1:
        return first, []
    if len(first.t_s) < 2:
        raise DataError(f"{source}: x_m has a single sample")
    t_s, step = first.t_s, _step(first.t_s)
    channels, clipped = dict(first.channels), first.clipped.copy()
    start, stop = t_s[0], t_s[-1]
    for base in bases[1:]:
        own = _step(base.t_s)
        slow = all(key.startswith("temp_") for key in base.channels)
        longest_s = max(max_gap_s, _LONGEST_OF_OIL_S) if slow else max_gap_s
        if own > longest_s:
            raise DataError(
                f"{source}: {', '.join(base.channels)}: {own:.4g} s between samples; "
                f"limit {'' if slow else 'screening.max_gap = '}{longest_s:g} s",
                "Increase screening.max_gap in the map to interpolate over longer times.",
            )
        faster = _is_faster(own, step)
        margin = step / 2 if faster else -longest_s if slow else 0.0
        start, stop = max(start, base.t_s[0] + margin), min(stop, base.t_s[-1] - margin)
        convert = partial(_averaged, step_s=step) if faster else _interpolated
        for key, values in base.channels.items():
            channels[key] = convert(t_s, base.t_s, values, longest_s)
        if base.clipped.any():  # one clipped sample makes the value at t_s a clipped one
            clipped |= convert(t_s, base.t_s, base.clipped * 1.0, max_gap_s) > 0
    margin = _SAME * step
    common = (t_s >= start - margin) & (t_s <= stop + margin)
    if not common.any():
        raise DataError(
            f"{source}: the channels have no time in common with x_m, which lasts from "
            f"{t_s[0]:.6g} s to {t_s[-1]:.6g} s"
        )
    kept = {key: values[common] for key, values in channels.items()}
    return TimeBase(t_s[common], kept, first.rows[common], clipped[common]), list(
        _notes(bases, common, name)
    )


def _notes(bases: Sequence[TimeBase], common: np.ndarray, name: str) -> Iterator[FileNote]:
    """Report what was done to the channels; nothing if they are sampled at the same times."""
    t_s, step = bases[0].t_s, _step(bases[0].t_s)
    changes = []
    for base in bases[1:]:
        own = _step(base.t_s)
        if _is_faster(own, step) or not _coincide(t_s[common], base.t_s):
            change = (
                f"means over {step:.4g} s" if _is_faster(own, step) else "linearly interpolated"
            )
            changes.append(f"{', '.join(base.channels)} ({1 / own:.4g} Hz): {change}")
    if changes:
        yield FileNote(name, f"at the times of x_m ({1 / step:.4g} Hz): {'; '.join(changes)}")
    if not common.all():
        text = (
            "{count} of {samples} samples left out: before the first or after the last sample of "
            "another channel"
        )
        yield FileNote(name, text, {"count": int((~common).sum()), "samples": len(t_s)})


def _is_faster(step_s: float, reference_s: float) -> bool:
    return step_s * _FASTER < reference_s


def _step(t_s: np.ndarray) -> float:
    return float(np.median(np.diff(t_s))) if len(t_s) > 1 else np.inf


def _coincide(at_s: np.ndarray, t_s: np.ndarray) -> bool:
    """Return whether each of ``at_s`` (m,) is the time of a sample."""
    i = np.clip(np.searchsorted(t_s, at_s), 1, len(t_s) - 1)
    distance = np.minimum(np.abs(at_s - t_s[i - 1]), np.abs(at_s - t_s[i]))
    return bool((distance < _SAME * (t_s[i] - t_s[i - 1])).all())


def _interpolated(
    at_s: np.ndarray, t_s: np.ndarray, values: np.ndarray, max_gap_s: float
) -> np.ndarray:
    """Return the values (m,) at ``at_s``; NaN between samples farther apart than the gap.

    At the time of a sample its value is returned unchanged.
    """
    i = np.clip(np.searchsorted(t_s, at_s, side="right") - 1, 0, len(t_s) - 2)
    step = t_s[i + 1] - t_s[i]
    part = np.clip((at_s - t_s[i]) / step, 0.0, 1.0)
    between = values[i] + part * (values[i + 1] - values[i])
    between[step > max_gap_s] = np.nan
    return np.where(part < _SAME, values[i], np.where(part > 1 - _SAME, values[i + 1], between))


def _averaged(
    at_s: np.ndarray, t_s: np.ndarray, values: np.ndarray, max_gap_s: float, *, step_s: float
) -> np.ndarray:
    """Return the means (m,) over ``step_s`` about each of ``at_s``; NaN where there is a gap."""
    starts = at_s - step_s / 2
    means = interval_means(t_s, values, starts, 1 / step_s)
    means[gaps_within(t_s, starts, 1 / step_s, max_gap_s)] = np.nan
    return means
