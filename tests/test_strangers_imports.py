"""Import maps and folders of logs from strangers: refused with exit 4 or 2, or imported.

No traceback, and neither time nor memory beyond that of the files' size. Files in binary formats
are tested in store/test_strangers_formats.py.
"""

import os
import re
import sys
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
import yaml

from hbench import workflow
from hbench.cli import main
from hbench.config.files.key_lines import with_lines
from hbench.errors import ConfigError, DataError, HbenchError
from hbench.store.campaign.folder import load_campaign
from hbench.store.importing.resampling import whole_intervals

AT = datetime(2026, 1, 1, tzinfo=UTC)
LOG = "t,x,p\n" + "".join(f"{n / 100},{n},{5 + n % 3}\n" for n in range(100))


@pytest.fixture
def rules():
    """A map for ``LOG`` in a file ``a_1.csv``."""
    return {
        "name": "strange",
        "columns": {
            "t_s": {"column": "t", "unit": "s"},
            "x_m": {"column": "x", "unit": "mm"},
            "p_tp_pa": {"column": "p", "unit": "bar"},
        },
        "series": [
            {"label": "A", "files": "a_{trial}.csv", "cylinder": {"piston_diameter": "40 mm"}}
        ],
    }


@pytest.fixture
def bring_in(tmp_path, rules):
    """Return a function that imports a file by ``rules`` and loads the campaign."""

    def bring_in(name="a_1.csv", text=LOG):
        (tmp_path / "logs").mkdir(exist_ok=True)
        (tmp_path / "logs" / name).write_text(text)
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
        workflow.import_runs(tmp_path / "logs", tmp_path / "out", tmp_path / "map.yaml", lambda: AT)
        return load_campaign(tmp_path / "out")

    return bring_in


@pytest.mark.parametrize("text", ["a:\tb\n", "a: b\tc\n", "{x: 1,\ty: 2, a:\t3}\n"])
def test_tabs_in_yaml_are_read_for_line_numbers_as_for_values(tmp_path, text):
    """Two parsers of YAML would disagree on what a tab is."""
    path = tmp_path / "map.yaml"
    path.write_text(text)
    assert with_lines(f"{path}: a: wrong") == f"{path}: line 1: a: wrong"


@pytest.mark.parametrize("field", [".foo", "[0]", "!r", ":1000000000", ":{load}", "!r:>{load}"])
def test_a_constant_s_braces_contain_only_a_field_s_name(bring_in, rules, field, limited):
    rules["series"][0]["files"] = "a_{trial}_{load}.csv"
    rules["constants"] = {"f_applied_n": f"{{load}}{{load{field}}} N"}
    with limited(), pytest.raises(ConfigError, match=r"constants\.f_applied_n"):
        bring_in("a_1_5.csv")


def test_a_constant_that_overflows_for_a_file_is_refused_with_its_name(bring_in, rules):
    rules["series"][0]["files"] = "a_{trial}_{load}.csv"
    rules["constants"] = {"f_applied_n": "{load}e308 N"}
    with pytest.raises(DataError, match=r"a_1_9\.csv: constants\.f_applied_n"):
        bring_in("a_1_9.csv")


@pytest.mark.parametrize("name", ["1" * 250, "1." * 125, "-1" * 125])
def test_a_name_of_digits_matches_no_pattern_at_great_length(bring_in, rules, name, limited):
    rules["series"][0]["files"] = "{pressure}{load}{speed}{trial}.csv"
    with limited(10), pytest.raises(DataError, match=re.escape(rules["series"][0]["files"])):
        bring_in(name)


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"files": "a_{trial}.csv"}, "a_0.csv"),
        ({"files": "a_{load}.csv"}, "a_99999999999.csv"),
        ({"files": "a_{speed}.csv", "speed_unit": "in/us"}, "a_99999999999.csv"),
        ({"cylinder": {"piston_diameter": "1 um"}}, "a_1.csv"),
    ],
)
def test_what_a_campaign_cannot_contain_is_refused_on_import(
    bring_in, rules, tmp_path, change, name
):
    """Else the import succeeds, and no command reads its campaign."""
    rules["series"][0] |= change
    with pytest.raises(DataError, match=rf"{name}: .*expected"):
        bring_in(name)
    assert not (tmp_path / "out").exists()


def test_a_speed_near_zero_is_refused(bring_in, rules):
    rules["series"][0]["speed"] = "1e-300 mm/s"
    with pytest.raises(ConfigError, match=r"speed = '1e-300 mm/s'.*1e-06"):
        bring_in()


@pytest.mark.parametrize("gap_s", [900_000, 60])
def test_a_long_gap_costs_nothing_to_resample(bring_in, rules, gap_s, limited):
    rules["resample"] = "100 Hz"
    with limited(10):
        (run,) = bring_in(text=f"{LOG}{gap_s},100,5\n").runs()
    np.testing.assert_allclose(run.t_s, np.arange(99) / 100 + 0.005)


def test_more_means_than_any_file_has_samples_are_refused(bring_in, rules, limited):
    rules |= {"resample": "20 kHz", "screening": {"max_gap": "3600 s"}}
    lines = [f"{n * 1e-5:.5f},{n}" for n in range(20)] + [
        f"{n * 3000},{n + 20}" for n in range(1, 9)
    ]
    with limited(10), pytest.raises(DataError, match=r"a_1\.csv: resample.*limit 10000000"):
        bring_in(text="t,x,p\n" + "".join(f"{line},5\n" for line in lines))


def test_a_resampling_without_any_interval_is_refused(bring_in, rules):
    rules["resample"] = "1e-300 Hz"
    with pytest.raises(DataError, match=r"a_1\.csv: resample"):
        bring_in()


def test_intervals_are_those_without_a_gap():
    rng = np.random.default_rng(0)
    for _ in range(100):
        t = np.cumsum(rng.choice([0.01, 0.02, 0.1, 0.5, 3.0], rng.integers(1, 30)))
        rate, longest = rng.choice([0.3, 5, 33.3, 100]), rng.choice([0.05, 0.1, 0.6])
        starts = t[0] + np.arange(np.floor((t[-1] - t[0]) * rate + 1e-9)) / rate
        first = np.searchsorted(t, starts, side="right") - 1
        last = np.searchsorted(t, starts + 1 / rate - 1e-12)
        whole = [
            start
            for start, a, b in zip(starts, first, last, strict=True)
            if not (np.diff(t[a : b + 1]) > longest).any()
        ]
        assert whole_intervals(t, rate, longest).tolist() == whole


@pytest.fixture
def hbench(monkeypatch, capfdbinary):
    """Return a function that calls a command in this process; it gives its exit code and output."""

    def call(*arguments):
        monkeypatch.setattr(main, "end_as_by_ctrl_c", lambda: None)
        monkeypatch.setattr(sys, "argv", ["hbench", *map(str, arguments)])
        monkeypatch.setattr(sys, "stdout", open(os.dup(1), "w", encoding="utf-8"))
        with pytest.raises(SystemExit) as end:
            main.main()
        sys.stdout.close()
        return end.value.code, b"".join(capfdbinary.readouterr())

    return call


def test_names_that_are_not_utf8_are_read_and_written(hbench, tmp_path, rules, undrawn):
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
    base = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\xff"))
    logs, out, again, logs_again = (base / f"\udcfe{name}" for name in "abcd")
    logs.mkdir(parents=True)
    (logs / "a_1.csv").write_text(LOG)
    (logs / "\udcfc.csv").write_text(LOG)
    for command in (
        ("import", logs, "-o", out, "--map", tmp_path / "map.yaml"),
        ("report", out),
        ("export", out, "-o", logs_again),
        ("import", logs_again, "-o", again, "--json"),
    ):
        code, told = hbench(*command)
        assert not code and b"Traceback" not in told, told
    assert load_campaign(again).header["folder"].endswith("/?/?d")
    rules["series"][0]["files"] = "b.csv"
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
    code, told = hbench("import", logs, "-o", base, "--map", tmp_path / "map.yaml")
    assert code == 4 and b"?.csv" in told


@pytest.mark.parametrize("count", [1, 1000])
def test_a_map_s_series_and_files_cost_time_by_their_number(bring_in, rules, count, limited):
    rules["series"] = [{**rules["series"][0], "files": f"{n}_{{trial}}.csv"} for n in range(count)]
    with limited(20), pytest.raises(HbenchError):
        bring_in("no.csv")
