"""A campaign.yaml that was edited by hand ends in a clear error, never in a traceback."""

import shutil
from pathlib import Path

import pytest
import yaml

from hbench import workflow
from hbench.errors import DataError

SAMPLE = Path(__file__).parents[2] / "data_samples" / "bad-runs"


@pytest.mark.parametrize(
    ("path", "value"),
    [
        *((("bench",), value) for value in (5, [], "x", {}, None, {"content": 5})),
        *((("settings",), value) for value in (5, [], "x", {"content": 5}, {"content": {"x": 1}})),
        (("bench", "content"), {"name": "x"}),
        (("schedule",), 5),
        (("schedule", "content"), {"name": "x"}),
        (("software",), "x"),
        (("firmware",), [1]),
        (("log",), 5),
        (("notes",), 5),
        (("runs",), 5),
        (("source",), "elsewhere"),
        *((("runs", 0, "plan", "v_ref_m_s"), value) for value in ("abc", None, [1], float("nan"))),
        (("runs", 0, "plan", "f_load_n"), "abc"),
        (("runs", 0, "plan", "kind"), 5),
        (("runs", 0, "plan", "specimen", "area_rod_m2"), "x"),
        (("runs", 0, "plan", "specimen"), 5),
        *((("runs", 0, "plan", "kind"), value) for value in ("nan", "creep", [], None)),
        *((("runs", 0, "plan", "label"), value) for value in (5, ["a"], {})),
        *((("runs", 0, "plan", "factors"), value) for value in (5, "a", ["a"], {"a": 1}, {1: "a"})),
        *((("runs", 0, "plan", "trial"), value) for value in (10**400, 0, -1, 1e300, True)),
        *(
            (("runs", 0, "plan", "specimen", "area_piston_m2"), value)
            for value in (-1e-3, 0, 1e300)
        ),
        (("runs", 0, "plan", "specimen", "area_rod_m2"), 2e-3),  # larger than the piston's
        (("runs", 0, "plan", "specimen", "stroke_m"), -0.4),
        (("runs", 0, "plan", "motion", "until"), 5),
        (("runs", 0, "plan", "motion", "segments", 0, "closed"), "no"),
        (("runs", 0, "plan", "colour"), 1),
        *((("runs", 0, "stop", "records"), value) for value in ("7", -1, 0.5, None, [])),
        (("runs", 0, "stop", "outcome"), "well"),
        (("runs", 0, "stop", "at"), 5),
        *((("runs", 0, "run"), value) for value in ("../../x", 5, None, ["0001"])),
        *((("log", "rate_hz"), value) for value in (0, -100, "fast", 10**400, float("nan"))),
        (("log", "flags"), "last"),
        (("log", "flags"), ["last", "last"]),
        *((("log", "channels", 3, "scale"), value) for value in (0, -1, "1", b"hi", float("inf"))),
        *((("log", "channels", 3, "unit"), value) for value in (5, "count?", "Pa", "psi")),
        *((("log", "channels", 10, "unit"), value) for value in ("mm", "count", "V")),
        *((("log", "channels", 3, "name"), value) for value in ([], "y", "v", float("nan"))),
        (("log", "channels", 3, "signed"), "no"),
        (("name",), ["x"]),
    ],
    ids=lambda value: str(value)[:40],
)
def test_a_section_that_is_not_what_was_written_is_named(tmp_path, path, value):
    folder = tmp_path / "campaign"
    shutil.copytree(SAMPLE, folder, ignore=shutil.ignore_patterns("results"))
    journal = folder / "campaign.yaml"
    content = yaml.safe_load(journal.read_text())
    place = content
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    journal.write_text(yaml.dump(content, Dumper=yaml.CSafeDumper, sort_keys=False))
    with pytest.raises(DataError, match=r"campaign\.yaml"):
        workflow.analyze(folder)
