"""Lines of runs in the journal: YAML that is also JSON, which is read six times as fast.

    - run: '0001'
      plan: {"kind": "steady", ...}
      start: {"at": "2024-05-01T12:00:00+00:00", ...}
      stop: {"at": ..., "outcome": "done", ...}

Where YAML and JSON would read a line differently, or the line is not JSON, the YAML parser reads
all lines: after an edit by hand, and in journals of earlier versions.
"""

import json
import re
from collections.abc import Mapping
from typing import Any

from hbench.untrusted_text import CONTROL

_LINE = re.compile(r"(- run: '([^'\\]*)'|  (plan|from|start|stop): (\{.*\}))")
_MOST_BRACKETS = 50  # of a line; nesting is not deeper
_STRING_OR_POWER = re.compile(r'("(?:[^"\\]|\\.)*")|(?<![\d.])(\d+)e(?=[+-])')


def json_line(value: Mapping[str, Any]) -> str | None:
    """Return a value as JSON on one line; None for what is not JSON, or YAML may refuse.

    A number with an exponent has a point too: YAML 1.1 would read 1e-05 as text.
    """
    try:
        text = json.dumps(value, ensure_ascii=False, allow_nan=False)
    except ValueError:
        return None
    if "e-" in text or "e+" in text:
        text = _STRING_OR_POWER.sub(lambda part: part[1] or f"{part[2]}.0e", text)
    return text if text.isprintable() else None


def parse_run_lines(text: str) -> list[dict[str, Any]] | None:
    """Return the runs in such lines, as YAML would be read; None if YAML has to be parsed."""
    if "\\" in text or CONTROL.search(text):
        return None
    runs: list[dict[str, Any]] = []
    for line in text.removesuffix("\n").split("\n"):
        match = _LINE.fullmatch(line)
        if match is None or line.count("{") + line.count("[") > _MOST_BRACKETS:
            return None
        _, run, key, value = match.groups()
        if run is not None:
            runs.append({"run": run})
        elif not runs or key in runs[-1]:
            return None
        else:
            try:
                runs[-1][key] = json.loads(
                    value,
                    object_pairs_hook=_unique,
                    parse_float=_decimal,
                    parse_constant=_decimal,
                )
            except ValueError:
                return None
    return runs


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    content = dict(pairs)
    if len(content) < len(pairs):
        raise ValueError("duplicate key")
    return content


def _decimal(number: str) -> float:
    if "." not in number or "E" in number:
        raise ValueError("not a number in YAML, or written by another program")
    return float(number)
