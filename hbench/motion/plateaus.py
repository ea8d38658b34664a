"""Sections of constant speed in a logged motion, found from the position alone.

Speeds are taken over blocks that are as short as the position's noise permits: a fast motion has
short blocks and sharp ends, a slow one long blocks. Speeds that no short block resolves are looked
for with longer ones, in the sections that are left.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from hbench.motion.noise import noise_over_motion
from hbench.motion.speeds import BlockSpeeds, block_speeds, mean_speed

SAME_SPEED = 0.10  # of the speed: what differs less is the same plateau
_RESOLVED = 0.03  # of the speed: noise of a block that is long enough
_BLOCK_S = 0.02  # shortest block: one period of the mains
_LONGEST_S = 0.3  # longest block, or the time for this travel:
_LONGEST_M = 0.002
_LONGEST_MEAN_S = 1.0  # longest block where no shorter one has the mean speed, as in stick-slip
_SIGMAS = 3.0  # of a block's noise
_LEAST = 4  # blocks of a plateau
_OUTLIERS = 2  # blocks in a row that do not end a plateau
_MOVING, _ABOUT = 0.2, 0.25  # of the speed: what counts as motion, and as its mean speed
_MOST = 0.8  # of a stroke: a section that long leaves nothing uneven outside
_LEAST_SHARE = 0.5  # of a section's blocks have its speed, or longer blocks are tried
_TREND = 0.05  # of the speed: a larger change along the section is a ramp
_SLOW = 0.03  # of the speed: slower blocks at an end belong to a change of speed
_WANDERING = 0.01  # of the speed: slower changes of it are part of a plateau
_LINE_SIGMAS = 4.0  # of the position's noise: a sample beyond is off the plateau's line


@dataclass(frozen=True)
class Plateau:
    """Samples of constant speed, and that speed."""

    section: slice
    v_m_s: float  # signed


class _Motion(NamedTuple):
    """Logged position over time, and its noise."""

    t_s: np.ndarray  # (n,)
    x_m: np.ndarray  # (n,)
    noise_m: float  # standard deviation

    def part(self, section: slice) -> "_Motion":
        return _Motion(self.t_s[section], self.x_m[section], self.noise_m)

    def speeds(self, block_s: float) -> BlockSpeeds:
        return block_speeds(self.t_s, self.x_m, block_s, self.noise_m)

    def length_s(self, section: slice) -> float:
        """Return the time from a section's first to its last sample; 0 if it is empty."""
        empty = section.stop <= section.start
        return 0.0 if empty else float(self.t_s[section.stop - 1] - self.t_s[section.start])

    def speed(self, section: slice) -> float:
        return mean_speed(self.t_s[section], self.x_m[section])


# ---- the section of a known speed


def plateau_at(t_s: np.ndarray, x_m: np.ndarray, v_m_s: float) -> slice:
    """Return the samples in which the speed is ``v_m_s`` within 10 %, noise aside; may be empty.

    Of several sections between reversals, the longest is returned. A stroke that has this mean
    speed, but is faster and slower without a constant speed, as in stick-slip, is returned whole.
    """
    if len(t_s) < 3:
        return slice(0, 0)
    motion = _Motion(t_s, x_m, noise_over_motion(t_s, x_m))
    block_s = _block_for(motion, v_m_s)
    section = _section_at(motion, v_m_s, block_s)
    stroke = _stroke_at(motion, v_m_s, block_s)
    stroke_s = motion.length_s(stroke)
    if motion.length_s(section) >= _MOST * stroke_s:
        return section
    if not _exceeds(motion.part(stroke).speeds(block_s), v_m_s):
        return section
    constant = [plateau for plateau in plateaus(t_s, x_m) if plateau.v_m_s * v_m_s > 0]
    same = [plateau for plateau in constant if _is_same_speed(plateau.v_m_s, v_m_s)]
    sections = [section, *(plateau.section for plateau in same or constant)]
    longest = max(sections, key=motion.length_s)
    return longest if motion.length_s(longest) >= _LEAST_SHARE * stroke_s else stroke


def _section_at(motion: _Motion, v_m_s: float, block_s: float) -> slice:
    """Return the longest section at a speed, with the shortest blocks that show one."""
    longest_s = max(block_s, _LONGEST_MEAN_S, _longest_block(v_m_s))
    while block_s <= longest_s:
        section, share = _longest_section(motion, v_m_s, block_s)
        if share >= _LEAST_SHARE and motion.length_s(section) > 2 * block_s:
            return section
        block_s *= 2
    return slice(0, 0)


def _longest_section(motion: _Motion, v_m_s: float, block_s: float) -> tuple[slice, float]:
    """Return the longest section at a speed, and the share of its blocks that have this speed."""
    speeds = motion.speeds(block_s)
    has_speed = _are_near(speeds.v_m_s, v_m_s, speeds.noise_m_s)
    sections = [(slice(0, 0), 0.0)]
    for stroke in _between(np.flatnonzero(_against(speeds, v_m_s)), len(has_speed)):
        blocks = stroke.start + np.flatnonzero(has_speed[stroke])
        if len(blocks):
            share = len(blocks) / (blocks[-1] - blocks[0] + 1)
            sections.append((_samples_of(motion, speeds, blocks), float(share)))
    return max(sections, key=lambda pair: motion.length_s(pair[0]))


def _stroke_at(motion: _Motion, v_m_s: float, block_s: float) -> slice:
    """Return the longest motion in one direction with about this mean speed, however uneven."""
    t_s, x_m, _ = motion
    speeds = motion.speeds(block_s)
    least_m_s = max(_MOVING * abs(v_m_s), _SIGMAS * speeds.noise_m_s)
    forward = speeds.v_m_s * np.sign(v_m_s) > least_m_s
    sections = [slice(0, 0)]
    for stroke in _between(np.flatnonzero(_against(speeds, v_m_s)), len(forward)):
        blocks = stroke.start + np.flatnonzero(forward[stroke])
        if len(blocks) < _LEAST:
            continue
        first, last = np.searchsorted(t_s, speeds.t_s[[blocks[0], blocks[-1]]])
        mean = (x_m[last] - x_m[first]) / max(t_s[last] - t_s[first], 1e-12)
        if abs(mean / v_m_s - 1) <= _ABOUT:
            sections.append(slice(int(first), int(last) + 1))
    return max(sections, key=motion.length_s)


# ---- all sections of constant speed


def plateaus(
    t_s: np.ndarray, x_m: np.ndarray, least_s: float = 0.3, least_m: float = 0.001
) -> list[Plateau]:
    """Return the sections of constant speed that last ``least_s`` and travel ``least_m``."""
    if len(t_s) < 3:
        return []
    motion = _Motion(t_s, x_m, noise_over_motion(t_s, x_m))
    longest_s = _longest_block(np.ptp(x_m) / max(t_s[-1] - t_s[0], 1e-9))
    block_s, resolved, unresolved = _shortest_block(t_s), [], [slice(0, len(t_s))]
    while block_s <= longest_s:
        for section in unresolved:
            for plateau in _plateaus_of(motion.part(section), block_s, least_s, least_m):
                resolved.append(_shifted(plateau, section.start))
        resolved = _joined(motion, resolved)
        unresolved = _outside([plateau.section for plateau in resolved], len(t_s))
        block_s *= 2
    return resolved


def _plateaus_of(
    motion: _Motion, block_s: float, least_s: float, least_m: float
) -> Iterator[Plateau]:
    """Yield the plateaus that blocks of this length resolve.

    A plateau begins where a few blocks have the same speed, well above their noise.
    """
    speeds = motion.speeds(block_s)
    v, noise_m_s = speeds.v_m_s, speeds.noise_m_s
    if len(v) < _LEAST:
        return
    beginnings = sliding_window_view(v, _LEAST)
    levels = np.median(beginnings, axis=1)
    is_resolved = np.abs(v[: len(levels)]) * SAME_SPEED >= _SIGMAS * noise_m_s
    is_constant = _are_near(beginnings, levels[:, np.newaxis], noise_m_s).all(axis=1)
    last = -1
    for k in np.flatnonzero(is_resolved & is_constant).tolist():
        if k <= last:
            continue
        level = float(levels[k])
        blocks = np.arange(k, _end(speeds, k, level))
        last = int(blocks[-1])
        change = np.polyfit(blocks, v[blocks], 1)[0] * len(blocks)
        if abs(change) > _TREND * abs(level) + _SIGMAS * noise_m_s:
            continue
        section = _samples_of(motion, speeds, blocks)
        travel_m = abs(motion.x_m[section.stop - 1] - motion.x_m[section.start])
        if motion.length_s(section) >= least_s and travel_m >= least_m:
            yield Plateau(section, motion.speed(section))


def _shifted(plateau: Plateau, start: int) -> Plateau:
    """Return a plateau of the part of a log that begins at ``start``, in samples of the log."""
    section = plateau.section
    return Plateau(slice(section.start + start, section.stop + start), plateau.v_m_s)


def _joined(motion: _Motion, found: list[Plateau]) -> list[Plateau]:
    """Join neighbours of one speed, if the motion between them has that mean speed too."""
    joined: list[Plateau] = []
    for plateau in sorted(found, key=lambda plateau: plateau.section.start):
        if joined and _is_continued(motion, joined[-1], plateau):
            section = slice(joined[-1].section.start, plateau.section.stop)
            joined[-1] = Plateau(section, motion.speed(section))
        else:
            joined.append(plateau)
    return joined


def _is_continued(motion: _Motion, plateau: Plateau, following: Plateau) -> bool:
    """Return whether a plateau goes on to the next one at its speed."""
    if not _is_same_speed(following.v_m_s, plateau.v_m_s):
        return False
    end, start = plateau.section.stop - 1, following.section.start
    if start <= end:
        return True
    gap_s = motion.t_s[start] - motion.t_s[end]
    off_m = motion.x_m[start] - motion.x_m[end] - plateau.v_m_s * gap_s
    margin_m = SAME_SPEED * abs(plateau.v_m_s) * max(gap_s, 0.0)
    return bool(abs(off_m) <= margin_m + _SIGMAS * np.sqrt(2) * motion.noise_m)


def _end(speeds: BlockSpeeds, k: int, level: float) -> int:
    """Return the block after the last of the plateau of speed ``level`` that begins at ``k``."""
    has_speed = _are_near(speeds.v_m_s, level, speeds.noise_m_s)
    outliers, last = 0, k
    for i in range(k, len(has_speed)):
        outliers = 0 if has_speed[i] else outliers + 1
        if outliers > _OUTLIERS:
            break
        last = i if has_speed[i] else last
    return last + 1


# ---- speeds of blocks


def _are_near(v: np.ndarray, v_m_s: float | np.ndarray, noise_m_s: float) -> np.ndarray:
    """Return whether speeds ``v`` are the same as ``v_m_s`` within 10 % and their noise."""
    margin = np.maximum(SAME_SPEED * np.abs(v_m_s), _SIGMAS * noise_m_s)
    return np.abs(v - v_m_s) <= margin * (1 + 1e-9)


def _is_same_speed(speed_m_s: float, v_m_s: float) -> bool:
    return bool(_are_near(np.array(speed_m_s), v_m_s, 0.0))


def _exceeds(speeds: BlockSpeeds, v_m_s: float) -> bool:
    """Return whether any block is faster than ``v_m_s`` by more than the tolerance."""
    faster = speeds.v_m_s * np.sign(v_m_s) - abs(v_m_s)
    return bool((faster > max(SAME_SPEED * abs(v_m_s), _SIGMAS * speeds.noise_m_s)).any())


def _against(speeds: BlockSpeeds, v_m_s: float) -> np.ndarray:
    """Return the blocks of a motion against ``v_m_s``, noise aside."""
    back = -speeds.v_m_s * np.sign(v_m_s)
    return back > max(0.5 * abs(v_m_s), _SIGMAS * speeds.noise_m_s)


def _between(ends: np.ndarray, n: int) -> list[slice]:
    """Return the sections of ``range(n)`` between the numbers ``ends``."""
    edges = [-1, *ends.tolist(), n]
    return [slice(a + 1, b) for a, b in zip(edges[:-1], edges[1:], strict=True) if b > a + 1]


def _outside(sections: list[slice], n: int) -> list[slice]:
    """Return the sections of ``range(n)`` outside ``sections``, which rise."""
    starts = [0, *(section.stop for section in sections)]
    stops = [*(section.start for section in sections), n]
    return [slice(a, b) for a, b in zip(starts, stops, strict=True) if b - a > 2]


# ---- from blocks to samples


def _samples_of(motion: _Motion, speeds: BlockSpeeds, blocks: np.ndarray) -> slice:
    """Return the samples of a plateau, given its blocks.

    Slow blocks at either end belong to a change of speed. The rest is extended to both sides while
    the position stays on the line through its nearer half.
    """
    t_s = motion.t_s
    v = np.abs(speeds.v_m_s[blocks])
    slow = v < (1 - _SLOW) * np.median(v) - _SIGMAS * speeds.noise_m_s
    if not slow.all():
        fast = np.flatnonzero(~slow)
        blocks = blocks[fast[0] : fast[-1] + 1]
    start = int(np.searchsorted(t_s, speeds.t_s[blocks[0]]))
    stop = int(np.searchsorted(t_s, speeds.t_s[blocks[-1]], side="right"))
    stop = max(stop, start + 1)
    half = (stop - start) // 2
    # The last block at either end can contain the begin of a change of speed.
    ends = int(np.searchsorted(t_s, t_s[start] + _BLOCK_S)) - start
    if half > ends + 2:
        second_half = slice(stop - half, stop - ends)
        ahead = slice(second_half.stop, len(t_s))
        stop = second_half.stop + _on_line(motion, second_half, ahead)
        first_half = slice(start + ends, start + half)
        before = slice(first_half.start - 1, None, -1)
        start = first_half.start - _on_line(motion, first_half, before)
    return slice(start, stop)


def _on_line(motion: _Motion, known: slice, further: slice) -> int:
    """Return how many of the ``further`` samples, nearest first, lie on the line through ``known``.

    Where the speed changes, the position leaves the tolerance only after some time, which is taken
    back: that in which a piston that stops at once leaves it, and one block for a slow change.
    """
    t_s, x_m, noise_m = motion
    t0, x0 = t_s[known].mean(), x_m[known].mean()
    v, half_s = motion.speed(known), (t_s[known.stop - 1] - t_s[known.start]) / 2
    times, positions = t_s[further], x_m[further]
    looked_at = 2 * (known.stop - known.start)
    while True:  # the line mostly ends soon, and the log is long
        away = np.abs(times[:looked_at] - t0)
        off = np.abs(positions[:looked_at] - x0 - v * (times[:looked_at] - t0))
        tolerance = _LINE_SIGMAS * noise_m + _WANDERING * abs(v) * np.abs(away - half_s)
        outside = off > tolerance
        if outside.any():
            break
        if looked_at >= len(times):
            return len(times)
        looked_at *= 2
    first = int(np.argmax(outside))
    late = tolerance[first] / max(abs(v), 1e-12) + _BLOCK_S
    return max(int(np.sum(away[:first] < away[first] - late)) - 1, 0)


# ---- lengths of blocks


def _block_for(motion: _Motion, v_m_s: float) -> float:
    """Return the shortest block that resolves a speed, within the limits of its length."""
    step_s, resolved_m_s = _step(motion.t_s), _RESOLVED * abs(v_m_s)
    block_s, longest_s = _shortest_block(motion.t_s), _longest_block(v_m_s)
    while (
        block_s < longest_s
        and motion.noise_m * np.sqrt(2 * step_s / block_s) / block_s > resolved_m_s
    ):
        block_s *= 2
    return block_s


def _shortest_block(t_s: np.ndarray) -> float:
    return max(_BLOCK_S, _step(t_s))


def _longest_block(v_m_s: float) -> float:
    return max(_LONGEST_S, _LONGEST_M / max(abs(v_m_s), 1e-6))


def _step(t_s: np.ndarray) -> float:
    return float(np.median(np.diff(t_s)))
