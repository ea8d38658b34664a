"""``hbench certificate``: forms, archive and refusals."""

import hashlib
import json
import shutil
import subprocess
import zipfile
from datetime import UTC, datetime
from urllib.request import pathname2url

import pytest
import yaml
from typer.testing import CliRunner

from hbench import workflow
from hbench.cli.main import app
from hbench.config.conformity.certificate import parse_certificate
from hbench.errors import ConfigError, DataError
from hbench.store.campaign.folder import load_campaign
from hbench.store.campaign.raw_logs import raw_data
from hbench.store.exporting import ro_crate
from hbench.store.exporting.settings import exported_settings
from tests.support import ROOT
from tests.support.certificates import FILE, LIMITS

SAMPLE = ROOT / "data_samples" / "stribeck-small"

pytestmark = pytest.mark.usefixtures("fitted_once")
STATED = {"issued": "2026-02-03", "limits": "limits.yaml"}


@pytest.fixture
def file(tmp_path):
    (tmp_path / "limits.yaml").write_text(LIMITS)
    path = tmp_path / "certificate.yaml"
    path.write_text(yaml.safe_dump(FILE | STATED, allow_unicode=True))
    return path


def test_the_command_prints_the_number_and_what_is_missing(file, tmp_path):
    output = tmp_path / "c.html"
    line = ["certificate", str(SAMPLE), "--with", str(file), "-o", str(output), "--json"]
    said = CliRunner().invoke(app, line)
    assert said.exit_code == 0
    document = json.loads(said.stdout)
    assert document["number"] == "SIM-L-17" and document["simulated"]
    assert "instruments.force.calibration.certificate" in document["missing"]
    assert "SIM-L-17" in output.read_text()


def test_the_archive_lists_each_file_with_its_checksum_and_is_a_campaign(file, tmp_path):
    for name in ("a.zip", "b.zip"):
        workflow.certify(SAMPLE, file, tmp_path / name)
    assert (tmp_path / "a.zip").read_bytes() == (tmp_path / "b.zip").read_bytes()
    with zipfile.ZipFile(tmp_path / "a.zip") as archive:
        archive.extractall(tmp_path / "crate")
    crate = tmp_path / "crate"
    graph = json.loads((crate / "ro-crate-metadata.json").read_text())["@graph"]
    listed = {entity["@id"]: entity for entity in graph if entity["@type"] == "File"}
    there = {p.relative_to(crate).as_posix() for p in crate.rglob("*") if p.is_file()}
    assert there == {*listed, "ro-crate-metadata.json"}
    assert {"campaign.yaml", "results.json", "certificate.html", "certificate.xml"} <= there
    for name, entity in listed.items():
        data = (crate / name).read_bytes()
        assert entity["sha256"] == hashlib.sha256(data).hexdigest()
        assert entity["contentSize"] == str(len(data))
    root = next(entity for entity in graph if entity["@id"] == "./")
    assert {part["@id"] for part in root["hasPart"]} == set(listed)
    assert root["identifier"] == "SIM-L-17"
    assert raw_data(load_campaign(crate)) == raw_data(load_campaign(SAMPLE))
    recipe = "sha256sum runs/*.dat | LC_ALL=C sort -k2 | sha256sum"
    said = subprocess.run(recipe, shell=True, cwd=crate, capture_output=True, text=True, check=True)
    assert said.stdout.split()[0] == root["sha256"]


def test_the_rocrate_library_reads_the_archive(file, tmp_path):
    rocrate = pytest.importorskip("rocrate.rocrate")
    workflow.certify(SAMPLE, file, tmp_path / "crate")
    crate = rocrate.ROCrate(tmp_path / "crate")
    assert crate.root_dataset["identifier"] == "SIM-L-17"
    assert crate.get(pathname2url("runs/0001.dat"))["encodingFormat"] == "text/plain"
    assert len(crate.root_dataset["hasPart"]) == 72 + 4


def test_a_changed_or_missing_log_is_refused(file, tmp_path):
    copy = tmp_path / "campaign"
    shutil.copytree(SAMPLE, copy)
    log = copy / "runs" / "0003.dat"
    log.write_bytes(log.read_bytes()[:-3] + b"0\r\n")
    with pytest.raises(DataError, match="0003"):
        raw_data(load_campaign(copy))
    log.unlink()
    with pytest.raises(DataError, match="0003"):
        workflow.certify(copy, file, tmp_path / "c.html")
    assert not (tmp_path / "c.html").exists()


def test_poor_data_and_unknown_forms_are_refused(file, tmp_path):
    with pytest.raises(DataError, match="'poor'"):
        workflow.certify(ROOT / "data_samples" / "bad-runs", file, tmp_path / "c.pdf")
    with pytest.raises(ConfigError, match="no form"):
        workflow.certify(SAMPLE, file, tmp_path / "c.docx")


@pytest.mark.parametrize(
    ("dates", "fault"),
    [
        ({"received": "2026-01-03"}, "received = 2026-01-03: the test began on 2026-01-01"),
        ({"issued": "2025-12-30"}, "issued = 2025-12-30: the test ended on 2026-01-01"),
    ],
)
def test_dates_that_contradict_that_of_the_test_are_refused(file, tmp_path, dates, fault):
    file.write_text(yaml.safe_dump(FILE | STATED | dates, allow_unicode=True))
    with pytest.raises(ConfigError, match=fault):
        workflow.certify(SAMPLE, file, tmp_path / "c.html")
    assert not (tmp_path / "c.html").exists()


@pytest.mark.parametrize("unnamed", [{"name": ""}, {"address": [""]}])
def test_a_laboratory_without_name_or_address_is_refused(unnamed):
    content = FILE | {"laboratory": FILE["laboratory"] | unnamed}
    with pytest.raises(ConfigError, match=r"laboratory\."):
        parse_certificate(content, "c.yaml")


def test_a_name_that_nothing_in_campaign_and_limits_has_is_refused_with_the_known_ones(
    file, tmp_path
):
    content = FILE | STATED | {"names": {"P-1": "Muster", "no laod": "ohne Last"}}
    file.write_text(yaml.safe_dump(content, allow_unicode=True))
    with pytest.raises(ConfigError, match="'no laod' is no series") as refused:
        workflow.certify(SAMPLE, file, tmp_path / "c.html")
    assert "'P-1'" in refused.value.hint


def test_the_example_file_is_valid_and_its_keys_are_known():
    text = (ROOT / "configs" / "certificate.yaml").read_text()
    with_comments = "\n".join(
        line[2:] if line.startswith("# ") and ":" in line.split("#")[1][:12] else line
        for line in text.splitlines()
    )
    for data in (yaml.safe_load(text), yaml.safe_load(with_comments)):
        parse_certificate(data, "certificate.yaml")
    assert yaml.safe_load(with_comments).keys() >= {"number", "replaces", "logo", "template"}


@pytest.mark.parametrize("kind", ["csv", "mat"])
def test_a_simulated_campaign_stays_simulated_when_it_is_exported_and_imported(kind, tmp_path):
    exported, again = tmp_path / "exported", tmp_path / "again"
    workflow.export(SAMPLE, exported, kind)
    workflow.import_runs(exported, again, None, lambda: datetime.now(UTC))
    assert load_campaign(again).provenance().source == "simulated"
    assert exported_settings(load_campaign(again))["simulated"] is True


OWN = "<p>{{ certificate.number }}</p><p>{{ certificate.mark }}</p>"


def with_template(file):
    (file.parent / "own.j2").write_text(OWN)
    file.write_text(file.read_text() + "\ntemplate: own.j2\n")


def test_a_browser_prints_the_page_of_an_own_template(file, tmp_path, require_tool):
    require_tool("chromium")
    with_template(file)
    workflow.certify(SAMPLE, file, tmp_path / "own.pdf")
    workflow.certify(SAMPLE, file, tmp_path / "own.html")
    made = (tmp_path / "own.pdf").read_bytes()
    assert made.startswith(b"%PDF-") and b"HeadlessChrome" in made
    assert "SIM-L-17" in (tmp_path / "own.html").read_text()


def test_without_a_browser_an_own_template_is_no_pdf(file, tmp_path, monkeypatch):
    with_template(file)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ConfigError, match=r"own\.j2.*Chromium") as error:
        workflow.certify(SAMPLE, file, tmp_path / "own.pdf")
    assert ".html" in error.value.hint and not (tmp_path / "own.pdf").exists()


def test_a_browser_that_fails_is_named_with_its_words(file, tmp_path, monkeypatch):
    with_template(file)
    browser = tmp_path / "bin" / "chromium"
    browser.parent.mkdir()
    browser.write_text("#!/bin/sh\necho no display >&2\nexit 3\n")
    browser.chmod(0o755)
    monkeypatch.setenv("PATH", str(browser.parent))
    with pytest.raises(ConfigError, match=r"exit code 3; no display"):
        workflow.certify(SAMPLE, file, tmp_path / "own.pdf")


def test_a_second_certificate_into_the_same_folder_waits_its_turn_and_takes_no_file(tmp_path):
    """It would remove the files of the first, whose archive would lack them without an error."""
    crate = tmp_path / "crate"
    with ro_crate._folder(crate) as put:
        put("runs/0001.dat", b"1")
        with pytest.raises(ConfigError, match="crate: another hbench is writing") as refused:
            with ro_crate._folder(crate):
                pass
        assert refused.value.hint == "Wait until it has ended."
        put("runs/0002.dat", b"2")
    assert {path.name for path in crate.rglob("*.dat")} == {"0001.dat", "0002.dat"}
    assert list(tmp_path.iterdir()) == [crate]


def test_what_a_killed_certificate_left_is_replaced(tmp_path):
    crate, old = tmp_path / "crate", tmp_path / ".crate.part" / "crate" / "runs"
    old.mkdir(parents=True)
    (old / "old.dat").write_bytes(b"old")
    with ro_crate._folder(crate) as put:
        put("new.dat", b"new")
    assert [path.name for path in crate.rglob("*.dat")] == ["new.dat"]
    assert list(tmp_path.iterdir()) == [crate]


def test_a_link_in_the_place_of_the_hidden_folder_is_refused(tmp_path):
    (tmp_path / "mine" / "crate").mkdir(parents=True)
    (tmp_path / "mine" / "crate" / "notes.txt").write_text("kept")
    (tmp_path / ".crate.part").symlink_to(tmp_path / "mine")
    with pytest.raises(DataError, match=r"\.crate\.part: can't be written"):
        with ro_crate._folder(tmp_path / "crate"):
            pass
    assert (tmp_path / "mine" / "crate" / "notes.txt").read_text() == "kept"
