"""Models of strokes and of a driven mass: the sections of a bench file that they need."""

import pytest
import yaml

from hbench.config.stroke_model import (
    motion_sections,
    parse_motion,
    parse_strokes,
    stroke_sections,
)
from hbench.errors import ConfigError
from tests.support import ROOT


@pytest.mark.parametrize(
    ("file", "kind"), [("import-csv.yaml", "an import map"), ("demo.yaml", "a schedule")]
)
def test_another_kind_of_file_in_place_of_a_model_is_named(file, kind):
    data = yaml.safe_load((ROOT / "configs" / file).read_text())
    for sections, parse in ((stroke_sections, parse_strokes), (motion_sections, parse_motion)):
        with pytest.raises(ConfigError, match=f"m.yaml: is {kind}, not "):
            parse(sections(data), "m.yaml")
