"""Models of a part of a bench: a cylinder in steady strokes, and a driven mass.

A bench or plant file is accepted too; its other sections are ignored.
"""

from collections.abc import Mapping
from typing import Any

from pydantic import Field

from hbench.config import quantity as q
from hbench.config.bench import Bore
from hbench.config.effects import Effects
from hbench.config.files.loading import validate
from hbench.config.friction import Friction
from hbench.config.quantity import ConfigSection

_STROKES = {"test_cylinder": ("piston_diameter", "rod_diameter"), "friction": ("test",)}
_MOTION = {"moving_mass": ("test",), "friction": ("test",)}


class TestFriction(ConfigSection):
    """Friction of the cylinder under test alone."""

    test: Friction


class StrokePlant(ConfigSection):
    """Sections that determine friction in steady strokes."""

    test_cylinder: Bore
    friction: TestFriction
    effects: Effects = Field(default_factory=dict)


class TestMass(ConfigSection):
    """Moving mass of the test side alone."""

    test: q.Mass


class MotionPlant(ConfigSection):
    """Sections that determine the motion of a mass under the force of its drive."""

    moving_mass: TestMass
    friction: TestFriction
    effects: Effects = Field(default_factory=dict)


def stroke_sections(data: dict[str, Any]) -> dict[str, Any]:
    """Return the sections of a bench or plant file that apply to steady strokes."""
    return _sections(data, _STROKES)


def motion_sections(data: dict[str, Any]) -> dict[str, Any]:
    """Return the sections of a bench or plant file that apply to the motion of a driven mass."""
    return _sections(data, _MOTION)


def _sections(data: dict[str, Any], wanted: Mapping[str, tuple[str, ...]]) -> dict[str, Any]:
    found = {
        section: {key: value for key, value in data[section].items() if key in keys}
        for section, keys in wanted.items()
        if isinstance(data.get(section), dict)
    }
    found |= {"effects": data["effects"]} if data.get("effects") else {}
    return found or data  # of another kind of file: its check then names that kind


def parse_strokes(data: dict[str, Any], source: str) -> StrokePlant:
    """Check the sections of ``stroke_sections``. Raises ``ConfigError``."""
    return validate(StrokePlant, data, source)


def parse_motion(data: dict[str, Any], source: str) -> MotionPlant:
    """Check the sections of ``motion_sections``. Raises ``ConfigError``."""
    return validate(MotionPlant, data, source)
