"""A suggested import map as YAML text, with a comment on each guess."""

import json
from collections.abc import Iterator

from hbench.config.import_map import UNFILLED
from hbench.config.schedule import Screening
from hbench.store.suggesting.choice import GUESS, LIKELY, SURE
from hbench.store.suggesting.map_yaml.columns import column_lines, table_lines
from hbench.store.suggesting.map_yaml.commented_yaml import comment_lines, line, scalar
from hbench.store.suggesting.map_yaml.series import series_lines
from hbench.store.suggesting.map_yaml.suggested_map import SuggestedMap
from hbench.store.suggesting.motion import Motion

_SETTLE_M, _MAX_GAP_S = Screening().settle_travel, Screening().max_gap
_CONSTANTS = {  # by channel: value, and when it applies
    "p_tr_pa": ("0 bar", "if the rod side is open to the air"),
    "p_tp_pa": ("0 bar", "if the piston side is open to the air"),
    "f_applied_n": (
        '"{load} N"',
        "a known load, such as a weight; 0 N without a load or if it is unknown",
    ),
}


def map_text(suggested: SuggestedMap) -> str:
    """Return the map as YAML."""
    sections = (
        _head(suggested),
        _format(suggested),
        column_lines(suggested),
        _constants(suggested),
        series_lines(suggested),
        _motion(suggested),
        table_lines(suggested),
    )
    return "\n\n".join(filter(None, map("\n".join, sections))) + "\n"


def _head(suggested: SuggestedMap) -> Iterator[str]:
    yield from comment_lines(
        f"Import map suggested from {len(suggested.files)} of {suggested.count} files in "
        f"{suggested.folder}. Replace each {UNFILLED} by a value. {SURE.capitalize()}, {LIKELY} "
        f"and {GUESS} say how well a choice is founded: check what is not sure, then look at the "
        "result of `hbench import FOLDER --map FILE --preview DIR`."
    )
    yield f"name: {scalar(suggested.folder)}"
    if suggested.motion is not None and suggested.motion.has_constant_speed:
        yield line("kind: steady", f"{LIKELY}: the files contain sections of constant speed")
    elif suggested.motion is not None and suggested.motion.reverses:
        yield line(
            "kind: triangle",
            f"{GUESS}: reversals without constant speed; if it is nearly constant, write kind: "
            "steady and cut: reversals",
        )
    elif _is_at_rest(suggested):
        yield line("kind: hold", f"{GUESS}: the position changes by no more than its noise")
    else:
        few = "few sections of constant speed; or ramp, triangle, steps, hold, breakaway"
        yield line("kind: steady", f"{GUESS}: {few}")


def _format(suggested: SuggestedMap) -> Iterator[str]:
    if suggested.layout is None:
        yield line("", f"{suggested.format_name} files need no section 'format'.").strip()
        return
    given = suggested.layout.model_dump(exclude_defaults=True)
    if suggested.format_name != "text":
        given.pop("separator", None)
    else:
        given = {"separator": suggested.layout.separator, **given}
    if not given:
        return
    comments = {
        "separator": f"{SURE}: all rows have the same number of columns",
        "sheet": "the first with a table of numbers",
        "preamble": "lines before the header",
        "units_row": "the row below the header has units",
        "header": "columns are numbered from 1",
        "comment": "lines that begin with this are skipped",
        "skip_rows": "rows between header and data",
        "decimal": "decimal mark",
        "thousands": "groups of three digits",
    }
    yield "format:"
    for key, value in given.items():
        text = json.dumps(value) if not isinstance(value, str) else scalar(value)
        yield line(f"  {key}: {text}", comments.get(key, ""))


def _constants(suggested: SuggestedMap) -> Iterator[str]:
    """Yield constants of channels that are not logged: assumed ones, and comments on others."""
    if suggested.is_driven:
        return
    missing = {
        name: constant for name, constant in _CONSTANTS.items() if name not in suggested.choices
    }
    for channel in suggested.assumed_constants:
        value, _ = missing.pop(channel)
        yield "constants:"
        comment = f"{GUESS}: not logged; remove it unless open to the air"
        yield line(f"  {channel}: {value}", comment)
    if missing:
        yield line("# constants:", "known values that are not logged; remove the sign #")
        for channel, (value, when) in missing.items():
            yield line(f"#   {channel}: {value}", when)


def _motion(suggested: SuggestedMap) -> Iterator[str]:
    motion, time = suggested.motion, suggested.time
    if time.repeats:
        yield line("repeated_times: drop", "the clock is coarse: some times are equal")
    if _is_at_rest(suggested):
        yield from comment_lines("For the leakage add stroke to the cylinder, and this line:")
        volumes = "dead_volume_piston: ??? cm^3, dead_volume_rod: ??? cm^3"
        yield f"# chambers: {{bulk_modulus: ??? bar, {volumes}}}"
    yield from _screening(suggested)
    if motion is None:
        return
    yield line(f"cut: {motion.cut}", f"{LIKELY}: {motion.reason}; {_about(suggested, motion)}")
    if motion.min_stroke_m is not None:
        text = f"min_stroke: {1e3 * motion.min_stroke_m:g} mm"
        yield line(text, "a quarter of the travel; shorter strokes are left out")
    if motion.rest_s:
        yield from comment_lines(
            f"The files begin with at least {motion.rest_s:.1f} s at rest. If no load or pressure "
            "acts there, add zero: rest to force and pressures: the mean at rest is subtracted."
        )


def _screening(suggested: SuggestedMap) -> Iterator[str]:
    """Yield the limits of a log that samples slowly and of short strokes."""
    motion, lines = suggested.motion, []
    has_runs = motion is not None or _is_at_rest(suggested)
    if has_runs and _is_timed(suggested) and (step_s := 1 / suggested.time.rate_hz) > _MAX_GAP_S:
        why = f"{LIKELY}: twice the time between samples; default {_MAX_GAP_S:g} s"
        lines.append(line(f"  max_gap: {2 * step_s:.2g} s", why))
    if motion is not None and motion.stroke_m < 2 * _SETTLE_M:
        why = f"{GUESS}: a quarter of a stroke; default {1e3 * _SETTLE_M:g} mm"
        lines.append(line(f"  settle_travel: {1e3 * motion.stroke_m / 4:.2g} mm", why))
    if lines:
        yield "screening:"
        yield from lines


def _is_at_rest(suggested: SuggestedMap) -> bool:
    """Return whether a position was logged that shows no motion."""
    has_times = any(len(t_s) for t_s in suggested.time.t_s)
    return suggested.motion is None and "x_m" in suggested.choices and has_times


def _about(suggested: SuggestedMap, motion: Motion) -> str:
    """Return the usual length and the speeds of the strokes."""
    factor, unit = (1.0, "rad") if suggested.is_rotary else (1e3, "mm")
    speeds = dict.fromkeys(f"{factor * speed:.3g}" for speed in motion.speeds_m_s)
    about = f"about {factor * motion.stroke_m:.3g} {unit}"
    return f"{about}, {' to '.join(speeds)} {unit}/s" if _is_timed(suggested) else about


def _is_timed(suggested: SuggestedMap) -> bool:
    """Return whether the unit of the times is known."""
    return suggested.time.choice is None or suggested.time.choice.scale is not None
