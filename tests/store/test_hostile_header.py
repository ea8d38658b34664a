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
        (("runs", 0, "run"), "../../x"),
    ],
    ids=str,
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
    journal.write_text(yaml.safe_dump(content, sort_keys=False))
    with pytest.raises(DataError, match=r"campaign\.yaml"):
        workflow.analyze(folder)
