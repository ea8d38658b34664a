"""The rows of a fleet while it is made, where they come from, and its table."""

import os
import sqlite3
import subprocess
import sys
from datetime import UTC, datetime

import numpy as np
import pyarrow.parquet as pq
import pytest

from hbench import workflow
from hbench.errors import ConfigError, DataError
from hbench.records import QUANTITIES, FleetNumber, FleetRow
from hbench.store.campaign.discovery import find_campaigns, fingerprint
from hbench.store.fleet.rows import ROWS, FleetRows
from hbench.store.fleet.table import FleetTable, cells_of, shown_path, write_table
from tests.support.cut_campaign import two_curves


def campaign(folder):
    (folder / "runs").mkdir(parents=True)
    (folder / "campaign.yaml").write_text("name: x\n")
    (folder / "runs" / "0001.dat").write_text("1651 1\n")
    return str(folder)


def test_campaigns_are_found_at_any_depth_by_folder_pattern_and_name(tmp_path):
    made = [campaign(tmp_path / name) for name in ("a/1", "a/2", "a/b/c/3", "d[1]/4")]
    (tmp_path / "a" / "empty").mkdir()
    (tmp_path / "a" / "note.txt").write_text("no folder")
    notes = []

    def found(*places):
        return sorted(find_campaigns([str(tmp_path / place) for place in places], notes.append))

    assert found("") == sorted(made)
    assert found("a/*") == made[:3] == found("a/1", "a/2", "a/b")
    assert found("**/[23]") == made[1:3]
    assert found("a/2") == [made[1]]
    assert found("d[1]") == [made[3]], "a name with brackets that is there is no pattern"
    assert notes == []
    assert found("a/empty", "nowhere", "a/note.txt", "z*") == []
    assert ["a/empty", "nowhere", "a/note.txt", "z*"] == [
        note.split(": ")[0].removeprefix(f"{tmp_path}/") for note in notes
    ]


def test_logs_without_a_journal_are_a_campaign_and_links_to_folders_are_not_followed(tmp_path):
    (tmp_path / "fleet" / "lost" / "runs").mkdir(parents=True)
    campaign(tmp_path / "elsewhere")
    (tmp_path / "fleet" / "link").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "fleet" / "circle").symlink_to(tmp_path / "fleet")
    found = list(find_campaigns([str(tmp_path / "fleet")], print))
    assert found == [str(tmp_path / "fleet" / "lost")]


@pytest.mark.parametrize("kind", ["csv", "parquet", "mat", "excel", "modelica"])
def test_an_export_beside_its_campaign_is_no_campaign(tmp_path, kind):
    made = two_curves(tmp_path / "line" / "1")
    workflow.export(made, tmp_path / "line" / "1-exported", kind)
    assert list(find_campaigns([str(tmp_path / "line")], print)) == [str(made)]


def test_a_fingerprint_changes_with_a_file_and_with_who_made_the_row(tmp_path):
    folder = campaign(tmp_path / "a")
    seen = {fingerprint(folder, "1")}

    def changed():
        before = len(seen)
        seen.add(fingerprint(folder, "1"))
        return len(seen) > before

    assert not changed()
    log = tmp_path / "a" / "runs" / "0001.dat"
    log.write_text("1651 2 \n")
    assert changed()
    os.utime(log, ns=(1, 1))
    assert changed()
    log.with_name("0002.dat").write_text("")
    assert changed()
    (tmp_path / "a" / "campaign.yaml").unlink()
    assert changed() and fingerprint(folder, "2") != fingerprint(folder, "1")
    (tmp_path / "a" / "results").mkdir()
    assert not changed(), "what is derived does not count"


def test_a_second_call_misses_what_is_new_or_changed_and_forgets_what_has_gone(tmp_path):
    with FleetRows(tmp_path) as rows:
        rows.register(("/" + name, False) for name in "cab")
        assert list(rows.missing()) == ["/a", "/b", "/c"]
        rows.keep("/b", "f", False, [1])
        rows.keep("/a", "f", True, [2])
        rows.keep("/c", "", True, ["its process died"])
        assert rows.counts() == (3, 3, 2) and list(rows.cells()) == [[2], [1], ["its process died"]]
    with FleetRows(tmp_path) as rows:
        assert [rows.fingerprint(name) for name in ("/a", "/b", "/c", "/d")] == ["f", "f", "", None]
        rows.register([("/a", True), ("/c", False), ("/d", False), ("/a", True)])
        assert list(rows.missing()) == ["/c", "/d"] and list(rows.cells()) == [[2]]
        rows.remove_others()
    with FleetRows(tmp_path) as rows:
        assert rows.fingerprint("/b") is None and rows.fingerprint("/a") == "f"


def test_rows_that_a_killed_process_has_kept_are_there(tmp_path):
    script = (
        "import os, sys; from pathlib import Path; from hbench.store.fleet.rows import FleetRows\n"
        "rows = FleetRows(Path(sys.argv[1])); rows.register([('/a', False), ('/b', False)])\n"
        "rows.keep('/a', 'f', False, [1]); os.kill(os.getpid(), 9)"
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    subprocess.run([sys.executable, "-c", script, tmp_path], env=environment)
    with FleetRows(tmp_path) as rows:
        assert rows.fingerprint("/a") == "f"


def test_names_of_any_bytes_are_kept_and_shown_as_text(tmp_path):
    odd = ["/a\udcff\udcfe", "/b\n\x1b[31m", "/ä=1+1,\"'<b>", "/\u2028"]
    with FleetRows(tmp_path) as rows:
        rows.register((path, False) for path in odd)
        assert sorted(rows.missing()) == sorted(odd)
    assert shown_path(odd[0]) == "/a\\xff\\xfe"
    write_table(tmp_path / "t.parquet", (cells_of(FleetRow(path)) for path in odd))
    shown = pq.read_table(tmp_path / "t.parquet")["path"].to_pylist()
    assert shown == [shown_path(path) for path in odd] and "\x1b" not in shown[1]


def test_two_at_once_and_a_file_of_another_kind_are_errors_with_a_hint(tmp_path):
    with FleetRows(tmp_path), pytest.raises(ConfigError, match="another hbench"):
        FleetRows(tmp_path)
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / ROWS).write_bytes(b"no database at all, but text " * 200)
    with pytest.raises(DataError, match=str(tmp_path)) as error:
        FleetRows(tmp_path / "other")
    assert "delete the file" in error.value.hint
    (tmp_path / "file").write_text("")
    with pytest.raises(DataError, match=str(tmp_path)):
        FleetRows(tmp_path / "file")


def test_a_table_holds_each_number_with_its_interval_in_si_and_the_same_bytes_twice(tmp_path):
    numbers = {
        ("friction_n", "extend"): FleetNumber(400.0, 380.0, 420.0, 5.0),
        ("b_viscous_n_s_m", "retract"): FleetNumber(2700.0, float("-inf"), None, None),
    }
    when = datetime(2026, 3, 1, 12, 0, 0, 250000, tzinfo=UTC)
    rows = [cells_of(FleetRow("/a", started=when, seed=3, runs=9, numbers=numbers))]
    rows += [cells_of(FleetRow(f"/b{i:05d}", failed="why")) for i in range(12_000)]
    for name in ("1", "2"):
        write_table(tmp_path / name, iter(rows))
    assert (tmp_path / "1").read_bytes() == (tmp_path / "2").read_bytes()
    table = pq.read_table(tmp_path / "1")
    assert len(table) == 12_001 and len(set(table.column_names)) == len(table.column_names)
    assert sum(name.endswith("_se") for name in table.column_names) == sum(
        len(quantity.sides) for quantity in QUANTITIES
    )
    first = table.slice(0, 1).to_pylist()[0]
    assert first["friction_extend_n"] == 400.0 and first["friction_extend_n_high"] == 420.0
    assert first["b_viscous_retract_n_s_m"] == 2700.0
    assert first["b_viscous_retract_n_s_m_low"] is None and first["efficiency_extend"] is None
    assert first["started"] == when and first["seed"] == 3
    read = FleetTable(tmp_path / "1")
    assert read.counts("failed") == [("why", 12_000), ("", 1)]
    assert read.moments()[0] == when.timestamp()
    assert np.isnan(read.numbers("friction_extend_n")[1:]).all()


def test_a_columns_name_ends_in_its_unit():
    column = {quantity.name: quantity.column for quantity in QUANTITIES}
    assert column["b_viscous_n_s_m"]("extend") == "b_viscous_extend_n_s_m"
    assert column["v_stribeck_m_s"]("retract") == "v_stribeck_retract_m_s"
    assert column["efficiency"]("extend") == "efficiency_extend"
    assert column["half_band_n"](None) == "half_band_n"


def test_rows_of_another_layout_are_analyzed_again(tmp_path):
    with FleetRows(tmp_path) as rows:
        rows.register([("/a", False)])
        rows.keep("/a", "print", False, ["/a"])
    with FleetRows(tmp_path) as rows:
        assert rows.fingerprint("/a") == "print"
    with sqlite3.connect(tmp_path / ROWS) as older:
        older.execute("PRAGMA user_version = 1")
    older.close()
    with FleetRows(tmp_path) as rows:
        assert rows.fingerprint("/a") is None
