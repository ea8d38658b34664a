"""The digital calibration certificate: structure of DCC 3.3.0, units of D-SI, values in SI."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import pytest

from hbench.errors import ConfigError
from hbench.records.conformity.acceptance import Measurement
from hbench.records.conformity.certified import Certified
from hbench.report.conformity.certificate.dcc import dcc_xml
from hbench.report.conformity.certificate.dcc_elements import DCC, SI
from tests.support.certificates import HOSTILE

# Children in the order of the schema, those that it requires with "!"; "a|b": in any order.
# Read from PTB's dcc.xsd 3.3.0, for the elements that hbench writes.
CONTACT = "name! eMail phone location!"
STATEMENT = "name norm declaration valid conformity data"
STRUCTURE = {
    "digitalCalibrationCertificate": "administrativeData! measurementResults! comment document",
    "administrativeData": "dccSoftware!|coreData!|items!|calibrationLaboratory!|respPersons!"
    "|customer!|statements",
    "dccSoftware": "software!",
    "usedSoftware": "software!",
    "software": "name! release! type description",
    "coreData": "countryCodeISO3166_1! usedLangCodeISO639_1! mandatoryLangCodeISO639_1! "
    "uniqueIdentifier! identifications receiptDate beginPerformanceDate! endPerformanceDate! "
    "performanceLocation! issueDate reportAmendedSubstituted previousReport",
    "reportAmendedSubstituted": "typeOfChange! replacedUniqueIdentifier!",
    "identifications": "identification!",
    "identification": "issuer! value! name",
    "items": "name item!",
    "item": "name! equipmentClass description owner installedSoftwares manufacturer model "
    "identifications! itemQuantities subItems",
    "itemQuantities": "itemQuantity!",
    "itemQuantity": "name description real!",
    "calibrationLaboratory": "calibrationLaboratoryCode contact!",
    "contact": CONTACT,
    "customer": CONTACT,
    "person": "name! location",
    "manufacturer": "name! location",
    "location": "countryCode|further",
    "respPersons": "respPerson!",
    "respPerson": "person! description role mainSigner",
    "statements": "statement!",
    "statement": STATEMENT,
    "measurementResults": "measurementResult!",
    "measurementResult": "name! description usedMethods usedSoftware measuringEquipments "
    "influenceConditions results! measurementMetaData",
    "usedMethods": "usedMethod!",
    "usedMethod": "name! description norm reference",
    "measuringEquipments": "name measuringEquipment!",
    "measuringEquipment": "name! description certificate manufacturer model identifications",
    "influenceConditions": "influenceCondition!",
    "influenceCondition": "name! description status certificate data!",
    "results": "result!",
    "result": "name! description data!",
    "data": "text|quantity|list",
    "list": "name description quantity!",
    "quantity": "name description noQuantity|real",
    "real": "value! unit! measurementUncertaintyUnivariate",
    "measurementUncertaintyUnivariate": "expandedMU!",
    "expandedMU": "valueExpandedMU! coverageFactor! coverageProbability!",
    **dict.fromkeys(("name", "description", "declaration", "further", "noQuantity"), "content!"),
}
TEXTS = {
    "countryCodeISO3166_1": r"[A-Z]{2}",
    "countryCode": r"[A-Z]{2}",
    "usedLangCodeISO639_1": r"[a-z]{2}",
    "mandatoryLangCodeISO639_1": r"[a-z]{2}",
    "issuer": "manufacturer|calibrationLaboratory|customer|owner|other",
    "typeOfChange": "amended|substituted",
    "performanceLocation": "laboratory|customer|laboratoryBranch|customerBranch|other",
    "conformity": "pass|fail|conditionalPass|conditionalFail|noPass|noFail",
    "mainSigner": "true|false",
    **dict.fromkeys(
        ("receiptDate", "beginPerformanceDate", "endPerformanceDate", "issueDate"),
        r"\d{4}-\d\d-\d\d",
    ),
    **dict.fromkeys(
        ("uniqueIdentifier", "replacedUniqueIdentifier", "role", "norm"), r"\S+(\s+\S+)*"
    ),
    "release": r"[a-zA-Z] ?(\d{1,3}\.){0,3}\d{1,3}",  # a rule of PTB's Schematron file
    **dict.fromkeys(("value", "valueExpandedMU", "coverageFactor"), r"\S+(\s+\S+)*"),
    "coverageProbability": r"0\.95",
    # D-SI: products of units with powers
    "unit": r"(\\(metre|second|newton|pascal|kelvin|one)(\\tothe\{-?\d\})?)+",
}


def local(element):
    return element.tag.rpartition("}")[2]


def faults(root):
    """Yield what contradicts the structure."""
    for element in root.iter():
        name, children = local(element), [local(child) for child in element]
        if not children:
            if name in TEXTS and not re.fullmatch(TEXTS[name], element.text or ""):
                yield f"{name}: {element.text!r}"
            continue
        parts = re.split(r"[ |]", STRUCTURE[name])
        order = [part.rstrip("!") for part in parts]
        yield from (f"{name}: {child}" for child in children if child not in order)
        needed = [part[:-1] for part in parts if part.endswith("!")]
        yield from (f"{name} without {part}" for part in needed if part not in children)
        places = [order.index(child) for child in children if child in order]
        if "|" not in STRUCTURE[name] and places != sorted(places):
            yield f"{name}: order {children}"


@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize("source", ["real", "simulated"])
def test_the_structure_is_that_of_the_schema(certificate, language, source):
    root = ElementTree.fromstring(dcc_xml(certificate(source, language=language)))
    assert root.tag == f"{{{DCC}}}digitalCalibrationCertificate"
    assert root.get("schemaVersion") == "3.3.0"
    assert list(faults(root)) == []
    marks = [
        e
        for e in root.iter(f"{{{DCC}}}content")
        if (e.text or "").startswith(("SIMULATED", "SIMULIERT"))
    ]
    number = root.find(f".//{{{DCC}}}uniqueIdentifier").text
    assert bool(marks) == number.startswith("SIM-") == (source == "simulated")


def test_the_check_of_the_structure_finds_faults(certificate):
    text = dcc_xml(certificate())
    for old, new in (
        ("dcc:role", "dcc:rank"),
        (r"\newton", "N"),
        ("<dcc:issueDate>2026-02-03</dcc:issueDate>", ""),
        (">pass<", ">PASS<"),
        ("dcc:release", "dcc:version"),
    ):
        assert old in text
        broken = ElementTree.fromstring(text.replace(old, new))
        assert bool(list(faults(broken))) == ("issueDate" not in old)  # not required


def test_each_value_is_in_si_with_its_uncertainty(certificate):
    at = Measurement(412.34, 27.76, dof=4.0, direction="extend", f_load_n=500.0, v_m_s=0.082)
    leak = Measurement(2.5e-13, 5e-14)
    values = (
        Certified("friction", at, 2.776, 328_000.0, 22_100.0),
        Certified("efficiency", replace(at, value=0.8, u95=0.02), 2.0),
        Certified("leakage", leak, None, leak="across_piston"),
    )
    root = ElementTree.fromstring(dcc_xml(replace(certificate(), values=values)))
    lists = root.findall(f".//{{{DCC}}}list")
    found = [[_real(real) for real in each.iter(f"{{{SI}}}real")] for each in lists]
    speed, load = (0.082, r"\metre\second\tothe{-1}"), (500.0, r"\newton")
    assert found[0] == [
        load,
        speed,
        (412.34, r"\newton", 27.76, 2.776),
        (328_000.0, r"\pascal", 22_100.0, 2.776),
    ]
    assert found[1] == [load, speed, (0.8, r"\one", 0.02, 2.0)]
    unit = r"\metre\tothe{3}\second\tothe{-1}\pascal\tothe{-1}"
    assert found[2] == [(2.5e-13, unit)]  # D-SI has no interval without a factor


def _real(real):
    texts = [e.text for e in real.iter() if not len(e)]
    return float(texts[0]), texts[1], *map(float, texts[2:4])


def test_each_decision_has_its_status(certificate):
    made = certificate()
    root = ElementTree.fromstring(dcc_xml(made))
    statuses = [e.text for e in root.iter(f"{{{DCC}}}conformity")]
    decisions = [check.decision for check in made.acceptance.checks]
    assert "NOT TESTED" in decisions and "PASS" in decisions
    assert len(statuses) == sum(decision != "NOT TESTED" for decision in decisions)


def test_hostile_texts_and_control_characters_are_plain_text(certificate):
    made = certificate(remarks=[HOSTILE])
    first = replace(made.values[0].measurement, label="a\x00b\x1b")
    made = replace(made, values=(replace(made.values[0], measurement=first),))
    root = ElementTree.fromstring(dcc_xml(made))
    texts = {e.text for e in root.iter(f"{{{DCC}}}content")}
    assert HOSTILE in texts and any("a?b?" in (text or "") for text in texts)


def test_imported_logs_need_the_date_of_the_test(certificate):
    with pytest.raises(ConfigError, match="date of the test"):
        dcc_xml(certificate("imported"))
    text = dcc_xml(certificate("imported", test={"date": "2025-12-01"}))
    assert "<dcc:beginPerformanceDate>2025-12-01" in text
