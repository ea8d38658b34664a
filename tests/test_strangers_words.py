"""Words from strangers stay words: on a page, in a figure, in a spreadsheet and on a terminal."""

import base64
import csv
import io
import re
import shutil
import sys
from datetime import UTC, datetime
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

from hbench import workflow
from hbench.cli import main
from hbench.store.campaign.folder import load_campaign
from hbench.untrusted_text import as_cell, from_cell, printable

SAMPLES = Path(__file__).parents[1] / "data_samples"
EVIL = "<x-evil onmouseover=alert(1)>\"'><x-evil>$\\frac{x-evil&"
FORMULAS = ["=cmd|' /C calc'!A0", "+1+cmd", "-1+cmd", "@SUM(A1)", "\t=1"]
AT = datetime(2026, 1, 1, tzinfo=UTC)


class Tags(HTMLParser):
    """Collects the names and attributes of a page's elements, and its embedded pictures."""

    def __init__(self, text):
        super().__init__()
        self.names, self.attributes, self.pictures = set(), set(), []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.names.add(tag)
        for name, value in attributes:
            self.attributes.add(name)
            for kind, data in re.findall(r"data:([\w/+]+);base64,([\w+/=]+)", value or ""):
                if "svg" in kind:
                    self.pictures.append(base64.b64decode(data))


@pytest.fixture
def campaign(tmp_path):
    """Return a function that writes a campaign all of whose words are ``words``."""

    def write(words, sample="bad-runs"):
        folder = tmp_path / "campaign"
        shutil.copytree(SAMPLES / sample, folder, ignore=shutil.ignore_patterns("results"))
        path = folder / "campaign.yaml"
        content = yaml.safe_load(path.read_text())
        content |= {"name": words, "created": words, "port": words, "notes": [words], "more": words}
        content["software"] = {words: words}
        content["firmware"] = {words: words}
        content["bench"]["content"]["name"] = words
        content["bench"]["file"] = words
        for run in content["runs"]:
            run["plan"]["label"] = words
            run["start"]["at"] = words
        content["runs"][0]["stop"] |= {"outcome": "failed", "why": words, "at": words}
        path.write_text(yaml.safe_dump(content, sort_keys=False))
        return folder

    return write


def check_page(text):
    """Assert that a page has no element and no attribute of a stranger."""
    page = Tags(text)
    assert "x-evil" not in page.names and "html" in page.names
    handlers = {name for name in page.attributes if name.startswith("on")}
    assert not handlers
    for picture in page.pictures:
        check_figure(picture)
    return page


def check_figure(svg: bytes):
    names = {element.tag.rpartition("}")[2] for element in ElementTree.fromstring(svg).iter()}
    assert not names & {"x-evil", "script", "foreignObject"}


def test_a_report_escapes_every_word_of_the_campaign(campaign):
    folder = campaign(EVIL)
    workflow.report(folder)
    text = (folder / "results" / "report.html").read_text()
    assert "&lt;x-evil" in text, "no word of it is there, so the test tells nothing"
    check_page(text)
    figures = list((folder / "results").rglob("*.svg"))
    assert figures
    for figure in figures:
        check_figure(figure.read_bytes())


def test_a_report_in_markdown_escapes_them_too(campaign, undrawn):
    folder = campaign(EVIL)
    workflow.report(folder, form="md")
    text = (folder / "results" / "report.md").read_text()
    assert r"\<x-evil" in text and not re.search(r"(?<!\\)<x-evil", text)


def test_a_comparison_escapes_every_word_of_both_campaigns(campaign, tmp_path):
    folder = campaign(EVIL, "stribeck-small")
    workflow.write_comparison(tmp_path / "out", workflow.compare(folder, folder))
    (page,) = (tmp_path / "out").glob("*.html")
    assert "&lt;x-evil" in page.read_text()
    check_page(page.read_text())


@pytest.mark.parametrize("formula", FORMULAS)
def test_no_cell_of_a_result_begins_as_a_formula(campaign, tmp_path, formula):
    folder = campaign(formula)
    workflow.analyze(folder)
    workflow.export(folder, tmp_path / "logs", "csv")
    tables = [*(folder / "results").glob("*.csv"), tmp_path / "logs" / "runs.csv"]
    seen = 0
    for table in tables:
        for row in csv.reader(io.StringIO(table.read_text())):
            for cell in row:
                number = re.fullmatch(r"-?\d[\d.e+-]*", cell)
                assert number or not cell.startswith(("=", "+", "-", "@", "\t", "\r")), table
                seen += cell == f"'{formula}"
    assert seen > 0, "the words are nowhere, so the test tells nothing"


@pytest.mark.parametrize("label", [*FORMULAS[:4], "'quoted", "'", "plain", "-10 degC"])
def test_a_label_comes_back_from_an_export_as_it_was(campaign, tmp_path, label):
    folder = campaign(label)
    workflow.export(folder, tmp_path / "logs", "csv")
    workflow.import_runs(tmp_path / "logs", tmp_path / "back", None, lambda: AT)
    labels = {plan.label for plan in load_campaign(tmp_path / "back").plans}
    assert labels == {label}


def test_an_apostrophe_is_put_before_formulas_alone():
    for words in FORMULAS:
        assert as_cell(words) == f"'{words}" and from_cell(as_cell(words)) == words
    for words in ("", "a=1", "0001", "off_reference: -1"):
        assert as_cell(words) == words and from_cell(words) == words


@pytest.fixture
def hbench(monkeypatch, capsys):
    """Return a function that calls a command in this process; it gives all that was told."""

    def call(*arguments):
        monkeypatch.setattr(main, "end_as_by_ctrl_c", lambda: None)
        monkeypatch.setattr(sys, "argv", ["hbench", *map(str, arguments)])
        with pytest.raises(SystemExit):
            main.main()
        return "".join(capsys.readouterr())

    return call


def test_a_terminal_obeys_no_character_of_a_stranger(hbench, tmp_path):
    """Names of files can hold what YAML may not: here they come from folders and tables."""
    folder = tmp_path / "logs\x1b[2J"
    folder.mkdir()
    (folder / "runs.csv").write_text("run,file,v_ref_m_s,x\x1b]0;owned\x07\nr1,a.csv,0.1,1\n")
    (folder / "a.csv").write_text("t_s,x_m,y\x1b[31m\n" + "".join(f"{n},{n},0\n" for n in range(9)))
    (folder / "b\x1b[31m.csv").write_text("t_s,x_m\n0,0\n")

    said = hbench("import", folder, "-o", tmp_path / "out")
    assert "unknown columns" in said
    (tmp_path / "out" / "runs" / "evil\x1b[2J.csv").write_text("")
    told = hbench("analyze", tmp_path / "out")
    assert "evil?[2J" in told
    said += told + hbench("analyze", tmp_path / "no\x1b[2Jthing")
    assert said.count("?[2J") >= 2 and "\x1b" not in said and "\x07" not in said


def test_what_can_be_printed_stays():
    assert printable("Dichtung Ø 40 mm, −10 °C\n\t密封") == "Dichtung Ø 40 mm, −10 °C\n\t密封"
    assert printable("a\rb\x1b[2J\x9b1m\x00") == "a?b?[2J?1m?"
