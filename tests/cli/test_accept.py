"""``hbench accept``: decision, files and exit codes."""

import json
import re
from xml.etree import ElementTree

import jsonschema
import pytest
import yaml
from typer.testing import CliRunner

from hbench import workflow
from hbench.cli.main import app
from hbench.report.schemas import schema_text
from tests.support.cut_campaign import one_load

MET = {"quantity": "friction", "max": "10 kN", "name": "A.1"}
MISSED = {"quantity": "friction", "max": "1 N"}
NOT_MEASURED = {"quantity": "breakaway", "max": "5 bar"}


@pytest.fixture
def accept(tmp_path):
    one_load(tmp_path / "campaign")

    def run(*limits, rule="guard_band", product="P", arguments=()):
        file = tmp_path / "limits.yaml"
        file.write_text(yaml.safe_dump({"product": product, "rule": rule, "limits": list(limits)}))
        line = ["accept", str(tmp_path / "campaign"), "--limits", str(file), *arguments]
        return CliRunner().invoke(app, line)

    return run


@pytest.mark.parametrize(
    ("limits", "decision", "code"),
    [
        ([MET], "PASS", 0),
        ([MET, MISSED], "FAIL", 6),
        ([MET, NOT_MEASURED], "NOT TESTED", 6),
        ([MISSED, NOT_MEASURED], "FAIL", 6),
    ],
)
def test_the_worst_decision_counts_and_fail_gives_the_exit_code(accept, limits, decision, code):
    said = accept(*limits)
    assert said.exit_code == 0
    assert said.stdout.startswith(f"{decision}, data poor: ")
    assert accept(*limits, arguments=["--fail"]).exit_code == code


def test_the_table_fits_100_columns_with_decision_value_limit_and_probability(accept):
    name = "A requirement of the customer with a long name, paragraph 5.3.2"
    said = accept(MET | {"name": name}, NOT_MEASURED).stdout
    lines = said.splitlines()
    assert max(map(len, lines)) <= 100
    head = next(line for line in lines if line.startswith("decision"))
    first = next(line for line in lines if line.startswith("PASS "))
    cells = re.split(r" {2,}", first)
    assert cells[0] == "PASS" and re.fullmatch(r"\d+ \+- \d+ N|[\d.]+ \+- [\d.]+ kN", cells[1])
    assert cells[2] == "> 99.9 %"
    assert first.index("> 99.9 %") == head.index("conforms")  # in columns
    above = lines[lines.index(head) + 1]  # once for all its decisions
    assert above.startswith(f"{name}: friction") and "limit at most 10000 N" in " ".join(
        said.split()
    )


def test_the_files_hold_each_decision(accept, tmp_path):
    said = accept(MET, MISSED, NOT_MEASURED, arguments=["--json"])
    folder = tmp_path / "campaign" / "results"
    assert (folder / "acceptance.json").read_text() == said.stdout.rstrip("\n") + "\n"
    document = json.loads(said.stdout)
    jsonschema.validate(document, json.loads(schema_text("acceptance")))
    suite = ElementTree.parse(folder / "acceptance.xml").getroot()
    tags = {"PASS": [], "FAIL": ["failure"], "MARGINAL": ["failure"], "NOT TESTED": ["error"]}
    cases = suite.findall("testcase")
    assert len(cases) == len(document["checks"]) == int(suite.get("tests"))
    for case, check in zip(cases, document["checks"], strict=True):
        figures = ["system-out"] if check["measurement"] is not None else []
        assert [each.tag for each in case] == tags[check["decision"]] + figures
    assert int(suite.get("failures")) > 0 and suite.get("errors") == "1"
    assert cases[0].get("name").startswith("A.1: friction")
    assert suite.get("name").endswith("(simulated)")


def test_the_report_begins_with_the_decision_and_lists_the_checks(accept, tmp_path, undrawn):
    def reported():
        workflow.report(tmp_path / "campaign", form="md")
        return (tmp_path / "campaign" / "results" / "report.md").read_text()

    assert "Decision" not in reported()
    accept(MET, MISSED, NOT_MEASURED)
    before, _, after = reported().partition("## Decision")
    document = json.loads((tmp_path / "campaign" / "results" / "acceptance.json").read_text())
    failed = [check["decision"] for check in document["checks"]].count("FAIL")
    outcome = "fails" if failed == 1 else "fail"
    assert f"FAIL: {failed} of {len(document['checks'])} checks {outcome} (" in before
    assert before.rstrip().count("Next step: continue the campaign") == 1  # it was cut short
    table = after[: after.index("## Summary")]
    assert "applied by the last hbench accept" in table
    assert "at most 1 N" in table and "at most 10 kN" in table.replace("10000 N", "10 kN")
    assert "| FAIL |" in table and "NOT TESTED" in table
    (tmp_path / "campaign" / "results" / "acceptance.json").unlink()
    assert "Decision" not in reported()
    figures = tmp_path / "campaign" / "results" / "figures"
    assert not list(figures.glob("decisions.*")), (
        "a figure that the report does not have is removed"
    )


def test_a_friction_in_bar_says_over_which_area(accept):
    words = "friction in bar: the force over the driven area"
    assert words in accept({"quantity": "friction", "max": "100 bar"}).stdout
    assert words not in accept(MET).stdout


def test_no_line_of_the_decisions_is_wider_than_a_terminal(accept):
    ripple = {"quantity": "speed_ripple", "max": "50 %"}
    product = "hydraulic cylinder of the series 50/36 with a stroke of 250 mm and seals of NBR 70"
    shown = accept(MET, ripple, product=product).stdout
    assert max(map(len, shown.splitlines())) <= 80 and product in " ".join(shown.split())


@pytest.mark.usefixtures("wide_terminal")
def test_the_table_states_how_a_speed_was_chosen_and_what_u_contains(accept):
    """A limit without a speed is decided at the worst one; U of a ripple has no instruments."""
    ripple = {"quantity": "speed_ripple", "max": "50 %"}
    said = accept(MET, ripple).stdout
    assert "U of speed ripple: of the trials alone" in said
    assert "each series is decided at the speed with the lowest probability" in said
    assert "note: data rated 'with care'; " in said or "note: data rated 'poor'; " in said
    one_speed = accept(MET | {"speed": "85 mm/s"}).stdout
    assert "lowest probability" not in one_speed and "trials alone" not in one_speed


def test_the_report_states_the_probability_of_conformity_and_the_rule(accept, tmp_path, undrawn):
    accept(MET, MISSED, NOT_MEASURED)
    workflow.report(tmp_path / "campaign", form="md")
    report = (tmp_path / "campaign" / "results" / "report.md").read_text()
    document = json.loads((tmp_path / "campaign" / "results" / "acceptance.json").read_text())
    known = [c["probability"] for c in document["checks"] if c["probability"] is not None]
    table = report[report.index("## Decision") : report.index("## Summary")].replace("\\", "")
    assert min(known) < 0.001 and max(known) > 0.999
    assert table.count("> 99.9 %") == sum(p > 0.999 for p in known)
    lowest = ", probability of conformity < 0.1 %."
    report = report.replace("\\", "")
    assert report.count(lowest) == 1 and lowest in report.partition("## Decision")[0]
    assert f"**Limits:** The file {document['limits']}" in table and "**Rule:** " in table
