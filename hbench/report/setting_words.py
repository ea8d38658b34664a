"""Words for the keys and values of bench files, schedules and campaign files."""

import json
import re
from collections.abc import Mapping
from typing import Any

from hbench.report.render.numbers import with_minus, with_powers

_WORDS = {
    "acceleration": "acceleration by default",
    "adc": "A/D converter",
    "amplifier": "amplifier gain",
    "bits": "bits of a sample",
    "by": "controlled by",
    "feedforward": "velocity feedforward",
    "heartbeat": "longest time without a message of the host",
    "level": "level shift",
    "log_rate": "rate of the log",
    "noisy": "with noise",
    "of": "relative to",
    "output": "output at full span",
    "oversampling": "samples averaged",
    "plant": "plant file of the virtual rig",
    "poisson": "Poisson's ratio",
    "port": "port of the board",
    "pressure_filter": "time constant of the pressure filter",
    "pressure_max": "highest pressure",
    "pressure_slew": "rate of change of the pressure references",
    "seed": "seed of the simulated noise",
    "speed_error": "largest deviation of the speed from its reference",
    "speed_error_time": "longest time of a larger deviation of the speed",
    "speed_max": "highest speed",
    "travel_max": "largest position",
    "travel_min": "smallest position",
    "velocity_filter": "time constant of the velocity filter",
    "youngs_modulus": "Young's modulus",
}
_QUANTITY = re.compile(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?(?: \D.*)?$")  # a number, with its unit
_POWER = re.compile(r"(?<=[a-z])\^([234])(?!\d)")
_RAISED = str.maketrans("234", "²³⁴")


def key_words(key: Any) -> str:
    """Write a key, such as ``youngs_modulus``, in words."""
    text = str(key)
    return _WORDS.get(text, text.replace("_", " ").replace("sha256", "checksum"))


def value_words(value: Any) -> str:
    """Write a value that is neither a section nor a list, with its unit."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    text = value if isinstance(value, str) else json.dumps(value, default=str, ensure_ascii=False)
    if _QUANTITY.match(text):
        text = with_minus(with_powers(text))
    return _POWER.sub(lambda found: found[1].translate(_RAISED), text)


def section_words(value: Any, inside: bool = False) -> str:
    """Write a section of a file in a line."""
    if not isinstance(value, Mapping):
        return value_words(value)
    entries = [_entry(name, entry) for name, entry in value.items()]
    return f"({', '.join(entries)})" if inside else "; ".join(entries)


def _entry(key: Any, value: Any) -> str:
    if isinstance(value, bool):  # "quantised", "not enabled"
        return key_words(key) if value else f"not {key_words(key)}"
    return f"{key_words(key)} {section_words(value, inside=True)}"
