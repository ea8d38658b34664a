"""Acceptance of a cylinder as JUnit XML, for production servers."""

from xml.etree import ElementTree

from hbench.records.conformity.acceptance import Acceptance
from hbench.report.conformity.text import (
    check_words,
    limit_words,
    measured_words,
    probability_words,
)
from hbench.untrusted_text import printable


def junit_xml(acceptance: Acceptance) -> str:
    """Return a test suite of the cylinder, a case for each decision; only PASS is no failure."""
    checks = acceptance.checks
    failed = [check for check in checks if check.decision in ("FAIL", "MARGINAL")]
    untested = [check for check in checks if check.decision == "NOT TESTED"]
    about = [acceptance.provenance.name]
    about += [f"cylinder {acceptance.serial}"] if acceptance.serial else []
    suite = ElementTree.Element(
        "testsuite",
        name=printable(f"hbench accept {', '.join(about)} ({acceptance.provenance.source})"),
        tests=str(len(checks)),
        failures=str(len(failed)),
        errors=str(len(untested)),
    )
    for check in checks:
        case = ElementTree.SubElement(
            suite,
            "testcase",
            classname=printable(acceptance.product or acceptance.limits),
            name=printable(check_words(check.requirement, check.measurement)),
        )
        if check.decision != "PASS":
            tag = "error" if check.decision == "NOT TESTED" else "failure"
            words = measured_words(check) if check.measurement is not None else ""
            words += f"{'; ' * bool(words)}limit {limit_words(check.requirement)}"
            message = "; ".join(filter(None, (check.reason, words)))
            ElementTree.SubElement(case, tag, type=check.decision, message=printable(message))
        if check.measurement is not None:
            figures = (
                f"measured {measured_words(check)}; limit {limit_words(check.requirement)}; "
                f"conforms {probability_words(check.probability)}"
            )
            ElementTree.SubElement(case, "system-out").text = printable(figures)
    ElementTree.indent(suite)
    return ElementTree.tostring(suite, encoding="unicode", xml_declaration=True) + "\n"
