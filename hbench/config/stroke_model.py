"""Model of a cylinder in steady strokes: areas, friction and effects.

A bench or plant file is accepted too; its other sections are ignored.
"""

from typing import Any

from pydantic import Field

from hbench.config.bench import Bore
from hbench.config.effects import Effects
from hbench.config.files.loading import validate
from hbench.config.friction import Friction
from hbench.config.quantity import ConfigSection

_KEYS = {"test_cylinder": ("piston_diameter", "rod_diameter"), "friction": ("test",)}


class TestFriction(ConfigSection):
    """Friction of the cylinder under test alone."""

    test: Friction


class StrokePlant(ConfigSection):
    """Sections that determine friction in steady strokes."""

    test_cylinder: Bore
    friction: TestFriction
    effects: Effects = Field(default_factory=dict)


def stroke_sections(data: dict[str, Any]) -> dict[str, Any]:
    """Return the sections of a bench or plant file that apply to steady strokes."""
    found = {
        section: {key: value for key, value in data[section].items() if key in keys}
        for section, keys in _KEYS.items()
        if isinstance(data.get(section), dict)
    }
    return found | ({"effects": data["effects"]} if data.get("effects") else {})


def parse_strokes(data: dict[str, Any], source: str) -> StrokePlant:
    """Check the sections of ``stroke_sections``. Raises ``ConfigError``."""
    return validate(StrokePlant, data, source)
