"""Sections of constant speed in a logged motion, found from the position alone.

Speeds are taken over blocks that are as short as the position's noise permits: a fast motion has
short blocks and sharp ends, a slow one long blocks. Speeds that no short block resolves are looked
for with longer ones, in the sections that are left.
"""

from dataclasses import dataclass

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
_ROUNDING = 1e-9
_WANDERING = 0.01  # of the speed: slower changes of it are part of a plateau
_LINE_SIGMAS = 4.0  # of the position's noise: a sample beyond is off the plateau's line


@dataclass(frozen=True)
class Plateau:
    """Samples of constant speed, and that speed."""

    section: slice
    v_m_s: float  # signed


def plateau_at(t_s: np.ndarray, x_m: np.ndarray, v_m_s: float) -> slice:
    """Return the samples in which the speed is ``v_m_s`` within 10 %, noise aside; may be empty.

    Of several sections between reversals, the longest is returned. A stroke that has this mean
    speed, but is faster and slower without a constant speed, as in stick-slip, is returned whole.
    """
    if len(t_s) < 3:
        return slice(0, 0)
    noise = noise_over_motion(t_s, x_m)
    block = _block_for(t_s, noise, v_m_s)
    section = _nearest_section(t_s, x_m, v_m_s, block, noise)
    stroke = _stroke_at(t_s, x_m, v_m_s, block, noise)
    if _length(t_s, section) >= _MOST * _length(t_s, stroke) or not _exceeds(
        block_speeds(t_s[stroke], x_m[stroke], block, noise), v_m_s
    ):
        return section
    constant = [p for p in plateaus(t_s, x_m) if p.v_m_s * v_m_s > 0]
    same = [p.section for p in constant if _is_near(np.array([p.v_m_s]), v_m_s, 0.0).all()]
    longest = max(
        [section, *(same or [p.section for p in constant])], key=lambda s: _length(t_s, s)
    )
    return longest if _length(t_s, longest) >= _LEAST_SHARE * _length(t_s, stroke) else stroke


def _nearest_section(
    t_s: np.ndarray, x_m: np.ndarray, v_m_s: float, block: float, noise: float
) -> slice:
    """Return the longest section at a speed, with the shortest blocks that show one."""
    longest = max(block, _LONGEST_MEAN_S, _longest_block(v_m_s))
    while block <= longest:
        section, share = _longest_at(t_s, x_m, v_m_s, block, noise)
        if share >= _LEAST_SHARE and _length(t_s, section) > 2 * block:
            return section
        block *= 2
    return slice(0, 0)


def _exceeds(speeds: BlockSpeeds, v_m_s: float) -> bool:
    """Return whether any block is faster than ``v_m_s`` by more than the tolerance."""
    faster = speeds.v_m_s * np.sign(v_m_s) - abs(v_m_s)
    return bool((faster > max(SAME_SPEED * abs(v_m_s), _SIGMAS * speeds.noise_m_s)).any())


def _stroke_at(t_s: np.ndarray, x_m: np.ndarray, v_m_s: float, block: float, noise: float) -> slice:
    """Return the longest motion in one direction with about this mean speed, however uneven."""
    speeds = block_speeds(t_s, x_m, block, noise)
    forward = speeds.v_m_s * np.sign(v_m_s) > max(_MOVING * abs(v_m_s), _SIGMAS * speeds.noise_m_s)
    sections = [slice(0, 0)]
    for piece in _between(np.flatnonzero(_against(speeds, v_m_s)), len(forward)):
        blocks = piece.start + np.flatnonzero(forward[piece])
        if len(blocks) < _LEAST:
            continue
        a, b = np.searchsorted(t_s, speeds.t_s[[blocks[0], blocks[-1]]])
        mean = (x_m[b] - x_m[a]) / max(t_s[b] - t_s[a], 1e-12)
        if abs(mean / v_m_s - 1) <= _ABOUT:
            sections.append(slice(int(a), int(b) + 1))
    return max(sections, key=lambda section: _length(t_s, section))


def _longest_at(
    t_s: np.ndarray, x_m: np.ndarray, v_m_s: float, block: float, noise: float
) -> tuple[slice, float]:
    """Return the longest section at a speed, and the share of its blocks that have this speed."""
    speeds = block_speeds(t_s, x_m, block, noise)
    near = _near(speeds, v_m_s)
    sections = [(slice(0, 0), 0.0)]
    for piece in _between(np.flatnonzero(_against(speeds, v_m_s)), len(near)):
        blocks = piece.start + np.flatnonzero(near[piece])
        if len(blocks):
            share = len(blocks) / (blocks[-1] - blocks[0] + 1)
            sections.append((_section(t_s, x_m, speeds, blocks, noise), float(share)))
    return max(sections, key=lambda found: _length(t_s, found[0]))


def settled(
    t_s: np.ndarray, x_m: np.ndarray, section: slice, settle_s: float, settle_m: float
) -> slice:
    """Return ``section`` after ``settle_s`` and after a travel of ``settle_m``; may be empty.

    Both are needed, because pressures settle in time but the seals' presliding settles in travel.
    """
    t, x = t_s[section], x_m[section]
    if not len(t):
        return slice(0, 0)
    in_time = t - t[0] >= settle_s - _ROUNDING
    after = in_time & (np.abs(x - x[0]) >= settle_m - _ROUNDING)
    return (
        slice(section.start + int(np.argmax(after)), section.stop) if after.any() else slice(0, 0)
    )


def plateaus(
    t_s: np.ndarray, x_m: np.ndarray, least_s: float = 0.3, least_m: float = 0.001
) -> list[Plateau]:
    """Return the sections of constant speed that last ``least_s`` and travel ``least_m``."""
    if len(t_s) < 3:
        return []
    noise = noise_over_motion(t_s, x_m)
    longest = _longest_block(np.ptp(x_m) / max(t_s[-1] - t_s[0], 1e-9))
    block, found, left = _shortest_block(t_s), [], [slice(0, len(t_s))]
    while block <= longest:
        for piece in left:
            found += _plateaus_of(t_s, x_m, piece, block, noise, (least_s, least_m))
        found = _joined(t_s, x_m, found, noise)
        left = _outside([plateau.section for plateau in found], len(t_s))
        block *= 2
    return found


def _plateaus_of(
    t_s: np.ndarray,
    x_m: np.ndarray,
    piece: slice,
    block: float,
    noise: float,
    least: tuple[float, float],
) -> list[Plateau]:
    """Return the plateaus within ``piece`` that blocks of this length resolve."""
    t, x = t_s[piece], x_m[piece]
    speeds = block_speeds(t, x, block, noise)
    v, last, found = speeds.v_m_s, -1, []
    if len(v) < _LEAST:
        return []
    first_blocks = sliding_window_view(v, _LEAST)
    levels = np.median(first_blocks, axis=1)
    resolved = np.abs(v[: len(levels)]) * SAME_SPEED >= _SIGMAS * speeds.noise_m_s
    alike = _is_near(first_blocks, levels[:, np.newaxis], speeds.noise_m_s).all(axis=1)
    for k in np.flatnonzero(resolved & alike).tolist():
        if k <= last:
            continue
        level = float(levels[k])
        blocks = np.arange(k, _end(speeds, k, level))
        last = int(blocks[-1])
        change = np.polyfit(blocks, v[blocks], 1)[0] * len(blocks)
        if abs(change) > _TREND * abs(level) + _SIGMAS * speeds.noise_m_s:
            continue
        section = _section(t, x, speeds, blocks, noise)
        at, to = section.start, section.stop - 1
        if t[to] - t[at] >= least[0] and abs(x[to] - x[at]) >= least[1]:
            v_m_s = mean_speed(t[section], x[section])
            found.append(Plateau(slice(at + piece.start, to + 1 + piece.start), v_m_s))
    return found


def _joined(t_s: np.ndarray, x_m: np.ndarray, found: list[Plateau], noise: float) -> list[Plateau]:
    """Join neighbours of one speed, if the motion between them has that mean speed too."""
    joined: list[Plateau] = []
    for plateau in sorted(found, key=lambda plateau: plateau.section.start):
        last = joined[-1] if joined else None
        if last is not None and _is_near(np.array([plateau.v_m_s]), last.v_m_s, 0.0).all():
            a, b = last.section.stop - 1, plateau.section.start
            between = (x_m[b] - x_m[a]) - last.v_m_s * (t_s[b] - t_s[a])
            margin = SAME_SPEED * abs(last.v_m_s) * max(t_s[b] - t_s[a], 0.0)
            if b <= a or abs(between) <= margin + _SIGMAS * np.sqrt(2) * noise:
                section = slice(last.section.start, plateau.section.stop)
                joined[-1] = Plateau(section, mean_speed(t_s[section], x_m[section]))
                continue
        joined.append(plateau)
    return joined


def _end(speeds: BlockSpeeds, k: int, level: float) -> int:
    """Return the block after the last of the plateau of speed ``level`` that begins at ``k``."""
    near, outliers, last = _near(speeds, level), 0, k
    for i in range(k, len(near)):
        outliers = 0 if near[i] else outliers + 1
        if outliers > _OUTLIERS:
            break
        last = i if near[i] else last
    return last + 1


def _near(speeds: BlockSpeeds, v_m_s: float) -> np.ndarray:
    return _is_near(speeds.v_m_s, v_m_s, speeds.noise_m_s)


def _is_near(v: np.ndarray, v_m_s: float | np.ndarray, noise_m_s: float) -> np.ndarray:
    margin = np.maximum(SAME_SPEED * np.abs(v_m_s), _SIGMAS * noise_m_s)
    return np.abs(v - v_m_s) <= margin * (1 + 1e-9)


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


def _section(
    t_s: np.ndarray, x_m: np.ndarray, speeds: BlockSpeeds, blocks: np.ndarray, noise_m: float
) -> slice:
    """Return the samples of a plateau, given its blocks.

    Slow blocks at either end belong to a change of speed. The rest is extended to both sides while
    the position stays on the line through its nearer half.
    """
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
        known = slice(stop - half, stop - ends)
        stop = known.stop + _on_line(t_s, x_m, known, slice(known.stop, len(t_s)), noise_m)
        known = slice(start + ends, start + half)
        ahead = slice(known.start - 1, None, -1)
        start = known.start - _on_line(t_s, x_m, known, ahead, noise_m)
    return slice(start, stop)


def _on_line(t_s: np.ndarray, x_m: np.ndarray, known: slice, further: slice, noise_m: float) -> int:
    """Return how many of the ``further`` samples, nearest first, lie on the line through others.

    Where the speed changes, the position leaves the tolerance only after some time, which is taken
    back: that in which a piston that stops at once leaves it, and one block for a slow change.
    """
    t0, x0 = t_s[known].mean(), x_m[known].mean()
    v = mean_speed(t_s[known], x_m[known])
    away = t_s[further] - t0
    off = np.abs(x_m[further] - x0 - v * away)
    beyond = np.abs(away) - (t_s[known.stop - 1] - t_s[known.start]) / 2
    tolerance = _LINE_SIGMAS * noise_m + _WANDERING * abs(v) * np.abs(beyond)
    outside = off > tolerance
    if not outside.any():
        return len(off)
    first = int(np.argmax(outside))
    late = tolerance[first] / max(abs(v), 1e-12) + _BLOCK_S
    return max(int(np.sum(np.abs(away[:first]) < np.abs(away[first]) - late)) - 1, 0)


def _block_for(t_s: np.ndarray, noise_m: float, v_m_s: float) -> float:
    """Return the shortest block that resolves a speed, within the limits of its length."""
    step, resolved = _step(t_s), _RESOLVED * abs(v_m_s)
    block, longest = _shortest_block(t_s), _longest_block(v_m_s)
    while block < longest and noise_m * np.sqrt(2 * step / block) / block > resolved:
        block *= 2
    return block


def _shortest_block(t_s: np.ndarray) -> float:
    return max(_BLOCK_S, _step(t_s))


def _longest_block(v_m_s: float) -> float:
    return max(_LONGEST_S, _LONGEST_M / max(abs(v_m_s), 1e-6))


def _length(t_s: np.ndarray, section: slice) -> float:
    """Return the time [s] from a section's first to its last sample; 0 if it is empty."""
    empty = section.stop <= section.start
    return 0.0 if empty else float(t_s[section.stop - 1] - t_s[section.start])


def _step(t_s: np.ndarray) -> float:
    return float(np.median(np.diff(t_s)))
