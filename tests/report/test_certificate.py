"""The certificate: its fields after ISO/IEC 17025, 7.8, its languages, templates and marks."""

import re
import string
from dataclasses import replace
from datetime import date
from html import unescape
from typing import get_args

import pytest

from hbench.analysis.conformity.certified import (
    certified_trials,
    certified_values,
    why_not_certified,
)
from hbench.analysis.conformity.measured import measurements
from hbench.config.conformity.certificate import Image, completed, parse_certificate, read_logo
from hbench.errors import ConfigError
from hbench.records.conformity.acceptance import (
    ConformityCheck,
    Measurement,
    Requirement,
    UntestedCause,
)
from hbench.records.conformity.certified import Certified
from hbench.records.motions import (
    Breakaway,
    Leakage,
    LeakCoefficient,
    Motions,
    Series,
    Zero,
    ZeroCheck,
)
from hbench.report.conformity.certificate.certificate import Certificate
from hbench.report.conformity.certificate.content import content
from hbench.report.conformity.certificate.page import certificate_page
from hbench.report.conformity.certificate.pdf import certificate_pdf, sheets
from hbench.report.conformity.certificate.words import WORDS
from hbench.report.conformity.text import NOT_IN_U_OF_LEAKAGE, U_OF_LEAKAGE
from hbench.report.render.pdf_pen import LEFT, SHEET_WIDTH, wrapped
from tests.support import ROOT
from tests.support.certificates import FILE, HOSTILE, PNG

README = ROOT / "hbench" / "report" / "conformity" / "README.md"
# A text of the certificate for each clause that the README lists.
CLAUSES = {
    "7.8.2.1 a": "Test certificate",
    "7.8.2.1 b": "Labor & Söhne",
    "7.8.2.1 c": "test hall 2",
    "7.8.2.1 d": "End of certificate L-17",
    "7.8.2.1 e": "Kunde AG",
    "7.8.2.1 f": "Procedure of the laboratory: WI-12.",
    "7.8.2.1 g": "S-4711",
    "7.8.2.1 h": "2025-12-22",
    "7.8.2.1 i": "2026-01-01",
    "7.8.2.1 j": "2026-02-03",
    "7.8.2.1 k": "No sampling plan",
    "7.8.2.1 l": "The results relate only to the item tested",
    "7.8.2.1 m": "Friction ± U (N)",
    "7.8.2.1 n": "No deviations from the schedule.",
    "7.8.2.1 o": "Prof. Prüfer",
    "7.8.2.1 p": "No results from external providers are recorded.",
    "7.8.2.2": "as stated by the customer",
    "7.8.3.1 a": "23 °C, 40 %",
    "7.8.3.1 b": "Statement of conformity",
    "7.8.3.1 c": "U is the expanded uncertainty according to JCGM 100",
    "7.8.3.1 d": "A remark of the laboratory",
    "7.8.3.1 e": "Back pressure: set pressure",
    "7.8.4.1 a": "for a coverage probability of approximately 95 %",
    "7.8.4.1 b": "Oil temperature",
    "7.8.4.1 c": "Traceability to the SI is not stated",
    "7.8.4.1 d": "no adjustment of the item are recorded",
    "7.8.4.1 e": "Statement of conformity",
    "7.8.6.1": "Decision rule: guard band (JCGM 106, 8.3.2; ILAC-G8)",
    "7.8.6.2 a": "The statement applies to the quantities in the table",
    "7.8.6.2 b": "Limits: limits.yaml (SHA-256",
    "7.8.6.2 c": "Decision rule",
    "7.8.8.3": "L-16",
}


def page_text(certificate: Certificate) -> str:
    body = certificate_page(certificate).partition("</head>")[2]
    return flat(unescape(re.sub(r"<[^>]+>", " ", body)))


def pdf_text(certificate: Certificate) -> str:
    return flat(" ".join(t.get_text() for sheet in sheets(certificate) for t in sheet.texts))


def flat(text: str) -> str:
    return " ".join(text.split())


def test_the_readme_lists_each_clause_and_page_and_pdf_contain_its_field(certificate):
    rows = re.findall(r"^\| (7\.8\.[\d.]+(?: [a-p])?) \|", README.read_text(), re.MULTILINE)
    assert rows == list(CLAUSES)
    assert {f"7.8.2.1 {letter}" for letter in string.ascii_lowercase[:16]} <= set(rows)
    made = certificate()
    for text in (page_text(made), pdf_text(made)):
        assert not {clause for clause, field in CLAUSES.items() if field not in text}


def test_a_value_is_stated_with_its_uncertainty_and_factor(certificate):
    measured = Measurement(412.34, u95=27.76, dof=4.0, direction="extend", v_m_s=0.082)
    values = (
        Certified("friction", measured, 2.776, 328_000.0, 22_100.0),
        Certified("breakaway", replace(measured, v_m_s=None, dwell_s=60.0), 2.776),
        Certified("leakage", Measurement(2.5e-16, 5e-17), None, leak="across_piston"),
    )
    for made in (certificate(), certificate(language="de")):
        parts = content(replace(made, values=values)).parts
        point = ["412 ± 28", "2.78", "3.28 ± 0.22"]
        leak = "0.150 ± 0.030"  # 2.5e-16 m^3/(s Pa) is 2.5e-16 * 1e6 * 60 * 1e7 ml/(min 100 bar)
        if made.file.language == "de":
            point = [text.replace(".", ",") for text in point]
            leak = leak.replace(".", ",")
        assert list(parts["friction"].tables[0].rows[0][-3:]) == point
        assert point[0] in parts["breakaway"].tables[0].rows[0]
        assert parts["leakage"].tables[0].rows[0][-1] == leak


def test_the_coverage_factor_is_students_or_two(sample_campaign, sample_results):
    instruments = sample_campaign.setup().instruments
    by_dof, _ = certified_values(sample_results, instruments)
    assert all(1.9599 < value.k < 1.97 for value in by_dof)  # hundreds of degrees of freedom
    two, _ = certified_values(sample_results, instruments.model_copy(update={"expansion": "k_2"}))
    assert {value.k for value in two} == {2.0}


def test_of_many_speeds_three_of_each_series_are_stated(sample_results, certificate):
    values, all_speeds = certified_values(sample_results, None)
    speeds = [v.measurement.v_m_s for v in values if v.quantity == "friction"]
    assert not all_speeds and len(speeds) == 4 * 3
    assert min(speeds) < 0.0081 and max(speeds) > 0.179
    assert "Of each series the lowest" in page_text(certificate())


def test_the_points_of_the_statement_of_conformity_are_among_the_results(sample_results):
    few, _ = certified_values(sample_results, None)
    stated = {value.measurement.v_m_s for value in few}
    every = measurements(sample_results, Requirement("friction", "N", None, None))
    decided = next(each for each in every if each.v_m_s not in stated)
    values, all_speeds = certified_values(sample_results, None, (decided,))
    assert decided in [value.measurement for value in values] and not all_speeds
    assert len(values) == len(few) + 2  # its friction and its efficiency


def checks(certificate, *decisions):
    """The certificate with a check for each quantity and decision; NOT TESTED has no value."""
    made = tuple(
        ConformityCheck(
            Requirement(quantity, "N", None, 9.0, name=f"limit {number}"),
            None if decision == "NOT TESTED" else Measurement(1.0, 0.1, v_m_s=speed),
            1.0,
            decision,
            causes=("load",) if decision == "NOT TESTED" else (),
        )
        for number, (quantity, decision, speed) in enumerate(decisions)
    )
    return replace(certificate, acceptance=replace(certificate.acceptance, checks=made))


def test_the_certificate_states_whether_all_limits_were_tested(certificate):
    whole = checks(certificate(), ("friction", "PASS", None), ("drift", "FAIL", None))
    assert "Limits tested: 2 of 2 (decisions: 2, one for each series)." in page_text(whole)
    part = checks(certificate(), ("friction", "PASS", None), ("leakage", "NOT TESTED", None))
    text = page_text(part)
    assert "Limits tested: 1 of 2 (decisions: 1," in text
    assert "series). Not measured for the others: limit 1: leakage (not at this load)." in text
    assert "The campaign has no runs that measure: breakaway." in text
    none = page_text(replace(part, acceptance=None))
    assert "Limits tested" not in none and "no runs that measure: breakaway; leakage." in none


@pytest.mark.parametrize("language", sorted(WORDS))
def test_rows_that_fail_or_are_marginal_are_bold_on_page_and_sheet(certificate, language):
    decisions = ("PASS", "MARGINAL", "FAIL", "NOT TESTED")
    made = checks(certificate(language=language), *(("friction", each, None) for each in decisions))
    words = WORDS[language]
    bold = {flat(words["MARGINAL"]), flat(words["FAIL"])}
    rows = re.findall(r'<tr class="emphasised">(.*?)</tr>', certificate_page(made), re.DOTALL)
    assert {flat(unescape(re.findall(r">([^<]+)</td>", row)[-1])) for row in rows} == bold
    written = [
        (flat(text.get_text()), text.get_weight())
        for sheet in sheets(made)
        for text in sheet.texts
        if flat(text.get_text()) in {flat(words[each]) for each in decisions}
        and text.get_fontsize() < 10
    ]
    assert {text for text, weight in written if weight == "bold"} == bold
    assert {text for text, weight in written if weight != "bold"} == {
        flat(words["PASS"]),
        flat(words["NOT TESTED"]),
    }


@pytest.mark.parametrize("language", sorted(WORDS))
def test_the_rule_of_the_guard_band_defines_each_decision_of_its_table(language):
    words = WORDS[language]
    rule = words["rule_guard_band"]
    assert all(words[decision] in rule for decision in ("PASS", "MARGINAL", "FAIL"))


def test_a_load_without_a_measurement_is_named(certificate):
    made = checks(certificate(), ("efficiency", "NOT TESTED", None))
    (check,) = made.acceptance.checks
    wanted = replace(check, requirement=replace(check.requirement, f_load_n=5000.0))
    again = replace(made, acceptance=replace(made.acceptance, checks=(wanted,)))
    (row,) = content(again).parts["conformity"].tables[0].rows
    assert "load\N{NO-BREAK SPACE}5000\N{NO-BREAK SPACE}N" in row


def test_a_back_pressure_is_with_a_decision_unless_the_tables_of_results_have_it(certificate):
    made = checks(certificate(), ("friction", "PASS", 0.02), ("speed_ripple", "PASS", 0.02))
    tables = {value.measurement.p_lr_ref_pa for value in made.values}
    for pressures, shown in (
        ((min(tables), min(tables)), False),
        ((min(tables), 777e5), True),  # not in the tables
        ((min(tables), max(tables)), True),  # two of one series
    ):
        each = tuple(
            replace(check, measurement=replace(check.measurement, p_lr_ref_pa=pressure))
            for check, pressure in zip(made.acceptance.checks, pressures, strict=True)
        )
        again = replace(made, acceptance=replace(made.acceptance, checks=each))
        rows = content(again).parts["conformity"].tables[0].rows
        assert any("back pressure" in cell for row in rows for cell in row) == shown


def test_the_method_states_the_rate_of_the_force_and_the_bulk_modulus(certificate):
    """Breakaway depends on the rate; a leakage is proportional to 1 / bulk modulus."""
    series = Series("", 0.0, None)
    rests = tuple(
        Breakaway(series, "extend", 60.0, rate, 480.0, 9.0, 90.0, 3, (), 0.006, None, None, 0.0, ())
        for rate in (200.0, 400.0)
    )
    motions = Motions(leakages=(Leakage("", (), (), 7.0e7, ""),), breakaways=rests)
    values = (
        Certified("breakaway", Measurement(480.0, 90.0, dwell_s=60.0), 1.96),
        Certified("leakage", Measurement(2.5e-16, 5e-17), None, leak="across_piston"),
    )
    for language, words in (
        (
            "en",
            (
                "rising force (200–400 N/s) pushes",
                "bulk modulus (700 bar), air in the oil and hoses included. It is assumed to be ",
            ),
        ),
        (
            "de",
            (
                "Kraft (200–400 N/s) den",
                "Kompressionsmodul (700 bar), einschließlich Luft im Öl und "
                "Schläuchen. Sie wird als laminar angenommen",
            ),
        ),
    ):
        made = certificate(language=language)
        results = replace(made.results, motions=motions)
        text = page_text(replace(made, values=values, results=results))
        assert all(each in text for each in words)
        text = page_text(replace(made, values=values))
        assert "N/s)" not in text and "(700 bar)" not in text and "{" not in text


def test_each_result_has_the_number_of_its_runs_in_both_languages(certificate):
    measured = Measurement(412.3, 27.8, direction="extend", v_m_s=0.08, runs=("1", "2", "3"))
    values = (
        Certified("friction", measured, 2.0),
        Certified("breakaway", replace(measured, v_m_s=None, dwell_s=60.0, runs=("4", "5")), 2.0),
    )
    for language, head in (("en", "Runs"), ("de", "Läufe")):
        parts = content(replace(certificate(language=language), values=values)).parts
        counts = []
        for name in ("friction", "breakaway"):
            table = parts[name].tables[0]
            counts.append(table.rows[0][table.head.index(head)])
        assert counts == ["3", "2"]


def test_u_of_leakage_is_stated_alike_in_certificate_and_acceptance(certificate):
    names = ("across_piston", "rod_side_out")
    leaks = tuple(LeakCoefficient(name, 1e-20, 1e-19, (-8.4e-18, 8.4e-18)) for name in names)
    motions = Motions(leakages=(Leakage("", leaks, (), 7.0e7, "", step_pa=360.0),))
    values = tuple(Certified("leakage", Measurement(0.0, 8.4e-18), None, leak=n) for n in names)
    for language, temperature in (("en", "0.2 K/min"), ("de", "0,2 K/min")):
        made = certificate(language=language)
        results = replace(made.results, motions=motions)
        text = page_text(replace(made, values=values, results=results))
        assert temperature in text
        words = U_OF_LEAKAGE.format(step=" (0.0036 bar)")
        assert (f"U of leakage is {words}. It has no factor k" in text) == (language == "en")
        assert (f"{NOT_IN_U_OF_LEAKAGE}." in text) == (language == "en")
        assert "(0.0036 bar)" in text or "(0,0036 bar)" in text


def test_a_leak_that_is_not_laminar_is_certified_at_the_pressure_of_its_holds(small, certificate):
    """Of an orifice, 1 ml/min at 25 bar is 2 ml/min at 100 bar and 100 at 250 kbar."""
    pressure = 2.5e6
    coefficient = 1e-6 / 60 / pressure
    found = LeakCoefficient("across_piston", coefficient, 1e-17, (0.9 * coefficient,) * 2)
    leakage = Leakage("", (found,), (), 7.0e7, "", exponent=0.5, reference_pa=pressure)
    results = replace(small, motions=Motions(leakages=(leakage,)))
    values, _ = certified_values(results, None)
    (stated,) = (value for value in values if value.quantity == "leakage")
    assert stated.measurement.value == pytest.approx(coefficient)
    text = page_text(replace(certificate(), results=results, values=(stated,)))
    assert "to the pressure to the power 0.5; the values stated are those at 25 bar." in text


def test_what_a_probability_of_conformity_rests_on_is_beside_it(certificate):
    plain = page_text(checks(certificate(), ("breakaway", "PASS", None)))
    assert "for a Student distribution with the 95 % interval of measured value ± U" in plain
    begin = plain.index("Statement of conformity")
    assert "no calibration certificate is recorded for" in plain[begin:][:600]
    ripple = page_text(checks(certificate(), ("speed_ripple", "PASS", 0.02)))
    assert "at the speed with the lowest probability" in ripple
    assert "divided by the mean speed." in ripple
    assert "at the speed with" not in plain


def test_simulated_data_is_marked_on_each_page(certificate):
    made = certificate("simulated")
    mark = WORDS["en"]["simulated_short"]
    assert made.number == "SIM-L-17"
    for sheet in sheets(made):
        marks = [text for text in sheet.texts if mark in text.get_text()]
        along = [text for text in marks if text.get_rotation() == 90]
        assert len(along) == 2 and len(marks) >= 3  # both margins, and the foot
        renderer = sheet.canvas.get_renderer()
        width = sheet.bbox.width
        for box in (text.get_window_extent(renderer) for text in along):
            assert box.x1 < width * LEFT / SHEET_WIDTH or box.x0 > width * (1 - LEFT / SHEET_WIDTH)
    page = certificate_page(made)
    assert f'@bottom-center {{ content: "{mark}"' in page and 'class="along"' in page
    for text in (page_text(certificate()), pdf_text(certificate())):
        assert mark not in text


def test_imported_runs_have_no_schedule_to_deviate_from(certificate):
    made = certificate()
    provenance = replace(made.results.provenance, source="imported")
    text = page_text(replace(made, results=replace(made.results, provenance=provenance)))
    assert "No schedule is recorded; all imported runs count." in text
    assert "No deviations from the schedule" not in text


def test_a_certificate_of_a_simulation_fills_two_sheets_in_both_languages(certificate):
    assert [len(sheets(certificate("simulated", language=each))) for each in ("en", "de")] == [2, 2]


def test_a_certificate_of_many_decisions_fills_two_sheets_in_both_languages(many_decisions):
    made = [many_decisions(language=language) for language in ("en", "de")]
    assert [len(each.acceptance.checks) for each in made] == [17, 17]
    assert [len(sheets(each)) for each in made] == [2, 2]


def test_a_leakage_that_is_decided_at_100_bar_is_not_repeated(certificate):
    """1e-17 m^3/(s Pa) are 6 ul/min at 100 bar."""
    names = ("across_piston", "rod_side_out")
    found = tuple(LeakCoefficient(name, 1e-17, 1e-18, (8e-18, 1.2e-17)) for name in names)
    made = certificate()
    motions = Motions(leakages=(Leakage("", found, (), 7.0e7, ""),))
    values = tuple(Certified("leakage", Measurement(1e-17, 2e-18), None, leak=n) for n in names)
    made = replace(made, values=values, results=replace(made.results, motions=motions))
    assert len(content(made).parts["leakage"].tables[0].rows) == 2
    for pressure, count in ((1e7, 1), (9e6, 2)):
        limit = Requirement(
            "leakage", "ml/min", None, 1e-6, leak="across_piston", pressure_pa=pressure
        )
        check = ConformityCheck(limit, Measurement(pressure * 1e-17, 2e-11), 1.0, "PASS")
        shown = replace(made, acceptance=replace(made.acceptance, checks=(check,)))
        part = content(shown).parts["leakage"]
        rows = part.tables[0].rows
        assert len(rows) == count and rows[-1][0] == "from the rod side outwards"
        reference = "The statement of conformity has the other leakages."
        assert part.paragraphs == (reference,) * (count == 1)


@pytest.mark.parametrize("language", sorted(WORDS))
def test_each_cause_of_no_decision_has_its_words(language):
    undecided = {"impossible", "u_unknown", "u_large"}
    for cause in get_args(UntestedCause):
        key = cause if cause in undecided else f"cause_{cause}"
        assert key in WORDS[language]


def test_each_sheet_has_the_number_and_page_x_of_y(certificate):
    made = sheets(certificate())
    assert len(made) == 2
    for number, sheet in enumerate(made, start=1):
        texts = [text.get_text() for text in sheet.texts]
        assert f"page {number} of 2" in texts and "Certificate no. L-17" in texts


def test_the_decision_and_its_table_are_on_the_first_sheet(certificate):
    for language in ("en", "de"):
        made = certificate(language=language)
        first, *_ = sheets(made)
        text = flat(" ".join(each.get_text() for each in first.texts))
        (table,) = content(made).parts["conformity"].tables
        lead = content(made).parts["conformity"].lead
        assert lead[:40] in text and text.index(lead[:40]) < text.index(made.word("instruments"))
        assert all(flat(row[-1]) in text and flat(row[2]) in text for row in table.rows)
        assert " ".join(table.head) in text
        decision = made.word(made.acceptance.decision)
        sizes = [
            each.get_fontsize() for each in first.texts if each.get_text().startswith(decision)
        ]
        assert max(sizes) > 1.5 * 8.8  # of headings


def test_a_text_without_a_table_is_on_one_sheet(certificate):
    for language in ("en", "de"):
        made = certificate(language=language)
        shown = content(made).parts["method"]
        sheet_of = [
            {
                number
                for number, sheet in enumerate(sheets(made))
                for t in sheet.texts
                if t.get_text() and text.startswith(t.get_text())
            }
            for text in (shown.title, shown.paragraphs[-1])
        ]
        assert sheet_of[0] == sheet_of[1] and len(sheet_of[0]) == 1


def test_no_text_leaves_its_sheet(certificate):
    for sheet in sheets(certificate("simulated", language="de")):
        renderer = sheet.canvas.get_renderer()
        for text in sheet.texts:
            box = text.get_window_extent(renderer)
            assert 0 < box.x0 < box.x1 < sheet.bbox.width, text.get_text()
            assert 0 < box.y0 < box.y1 < sheet.bbox.height, text.get_text()


def test_lines_are_broken_without_loss_also_within_long_words():
    text = "SHA-256 of all: " + "0123456789abcdef" * 8
    lines = wrapped(text, 100.0, 8.0)
    assert len(lines) > 4 and "".join(lines).replace(" ", "") == text.replace(" ", "")


def test_both_languages_have_the_same_words_and_fields():
    english, german = WORDS["en"], WORDS["de"]
    assert english.keys() == german.keys()
    for key in english:
        names = [{f[1] for f in string.Formatter().parse(t)} for t in (english[key], german[key])]
        assert names[0] == names[1], key
    assert {key for key in english if english[key] == german[key]} == {"name", "k"}


def test_names_of_files_are_printed_as_the_certificate_file_has_them(certificate):
    measured = Measurement(1.0, 0.1, label="no load", v_m_s=0.02)
    made = certificate(language="de")
    requirement = Requirement("friction", "N", None, 9.0, name="no-load friction")
    check = ConformityCheck(requirement, measured, 1.0, "PASS")
    acceptance = replace(made.acceptance, checks=(check,), product="demo cylinder")
    made = replace(made, acceptance=acceptance, values=(Certified("friction", measured, 2.0),))
    names = {
        "no load": "ohne Last",
        "no-load friction": "Reibung ohne Last",
        "demo cylinder": "Musterzylinder",
        made.results.provenance.name: "Stribeck-Kurven",
    }
    named = replace(made, file=made.file.model_copy(update={"names": names}))
    for text in (page_text(named), pdf_text(named)):
        assert all(printed in text for printed in names.values())
        assert not [name for name in names if re.search(rf"\b{re.escape(name)}\b", text)]
        assert "sind die des Labors" not in text
    assert "sind die des Labors" in page_text(made)


def test_german_results_have_decimal_commas(certificate):
    shown = content(certificate(language="de"))
    cells = {c for p in shown.parts.values() for t in p.tables for row in t.rows for c in row}
    assert any("," in cell for cell in cells)
    assert not [cell for cell in cells if re.search(r"\d\.\d", cell)]
    assert shown.title == "Prüfzertifikat" and 'lang="de"' in certificate_page(
        certificate(language="de")
    )


def test_hostile_texts_are_escaped(certificate):
    made = certificate(
        remarks=[HOSTILE],
        laboratory=FILE["laboratory"] | {"name": HOSTILE},
        test={"operator": HOSTILE},
    )
    page = certificate_page(made)
    assert "<script" not in page and HOSTILE in page_text(made)
    assert "default-src 'none'" in page
    assert flat(HOSTILE) in pdf_text(made)


def test_a_number_that_could_end_a_style_sheet_is_refused():
    with pytest.raises(ConfigError, match="60 letters"):
        parse_certificate(FILE | {"number": '"} body{'}, "c.yaml")


OWN = "{{ parts.customer.facts[0][1] }} {{ certificate.number }} {{ certificate.mark }}"


def test_a_laboratorys_template_replaces_the_page(certificate):
    made = certificate(customer={"name": HOSTILE})
    assert certificate_page(made, OWN).startswith("&lt;script&gt;")


@pytest.mark.parametrize(
    ("template", "message"),
    [
        ("{{ ''.__class__.__mro__ }}", "unsafe"),
        ("{{ certificate.rows.__class__.__subclasses__() }}", "unsafe"),
        ("{% include '/etc/hostname' %}", "loader"),
        ("line\n{% if %}", "line 2"),
        ("{{ no_such_name }}", "no_such_name"),
        ("nothing", "does not contain 'SIM-L-17'"),
        ("{{ certificate.number }}", "does not contain 'SIMULATED"),
        ("{{ 1 / 0 }}", "ZeroDivisionError"),
    ],
)
def test_a_template_runs_in_a_sandbox_and_shows_number_and_mark(certificate, template, message):
    with pytest.raises(ConfigError, match=re.escape(message)):
        certificate_page(certificate("simulated"), template, "own.j2")


def test_a_logo_is_embedded_as_an_image(certificate, tmp_path):
    (tmp_path / "logo.png").write_bytes(PNG)
    (tmp_path / "logo.svg").write_text('<svg xmlns="x"><script>alert(1)</script></svg>')
    png, svg = (read_logo(tmp_path / name) for name in ("logo.png", "logo.svg"))
    page = certificate_page(replace(certificate(), logo=svg))
    assert "data:image/svg+xml;base64," in page and "<script" not in page  # an image runs none
    assert len(sheets(replace(certificate(), logo=png))[0].axes) == 1
    with pytest.raises(ConfigError, match="PNG file only"):
        certificate_pdf(replace(certificate(), logo=svg))
    with pytest.raises(ConfigError, match="logo"):
        certificate_pdf(replace(certificate(), logo=Image("image/png", PNG[:40])))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (PNG[:16] + (9000).to_bytes(4, "big") + PNG[20:], "9000 x 1 pixels"),
        (b"GIF89a", "neither a PNG nor an SVG"),
        (PNG + bytes(400_000), "limit 0.3 MB"),
    ],
)
def test_a_logo_that_is_too_large_or_no_image_is_refused(tmp_path, data, message):
    (tmp_path / "logo.png").write_bytes(data)
    with pytest.raises(ConfigError, match=message):
        read_logo(tmp_path / "logo.png")


def test_letters_that_the_pdf_would_print_as_boxes_are_refused(certificate):
    """Greek, Cyrillic and Vietnamese are in the font; Japanese is not, and the page has it."""
    name = "株式会社日本油圧"
    assert sheets(certificate(customer={"name": "Żółć Лаборатория Παπαδόπουλος Nguyễn Thị Ánh"}))
    japanese = certificate(customer={"name": name})
    with pytest.raises(ConfigError, match=f"does not have all letters of '{name}'") as found:
        certificate_pdf(japanese)
    assert "Write the certificate as .html" in found.value.hint
    assert name in certificate_page(japanese)


def test_the_same_campaign_gives_the_same_bytes(certificate):
    assert certificate_page(certificate()) == certificate_page(certificate())
    assert certificate_pdf(certificate()) == certificate_pdf(certificate())


def test_a_derived_number_changes_with_all_that_the_document_states(certificate):
    made = certificate("simulated", number="", replaces="")
    assert re.fullmatch(r"SIM-HB-20260203-[0-9A-F]{10}", made.number)
    others = [
        certificate(number="", replaces=""),
        certificate("simulated", number="", replaces="", language="de"),
        replace(made, issued=date(2026, 2, 4)),
        replace(made, raw=replace(made.raw, sha256="0")),
        replace(made, raw=replace(made.raw, record_sha256="0")),
        replace(made, acceptance=None),
    ]
    assert len({made.number, *(other.number for other in others)}) == 7


def test_an_amended_certificate_needs_a_number():
    for number in ("", "L-16"):
        with pytest.raises(ConfigError, match="of its own"):
            parse_certificate(FILE | {"number": number, "replaces": "L-16"}, "c.yaml")


def test_the_file_adds_to_the_record_and_cannot_change_it():
    file = parse_certificate(FILE, "c.yaml")
    specimen, _ = completed(file, {"specimen": {"seals": "NBR", "serial": "S-4711"}}, "c.yaml")
    assert (specimen.serial, specimen.seals) == ("S-4711", "NBR")
    with pytest.raises(ConfigError, match="the campaign has 'S-1'"):
        completed(file, {"specimen": {"serial": "S-1"}}, "c.yaml")


def test_what_is_not_stated_is_listed_and_printed(certificate):
    made = certificate(customer={}, specimen={}, test={}, method="")
    assert {"customer.name", "specimen.serial", "test.place", "method"} <= set(made.missing)
    facts = dict(content(made).parts["specimen"].facts)
    assert facts["Serial number"] == "not stated"
    assert not {"customer.name", "test.date"} & set(certificate().missing)


def test_decided_ripple_has_no_table_of_its_own_but_its_runs_and_factor(certificate):
    measured = Measurement(0.0047, 0.00073, 2.0, direction="extend", v_m_s=0.002, runs=("1", "2"))
    fewer = replace(measured, dof=1.0, u95=0.003, direction="retract", runs=("3",))
    requirement = Requirement("speed_ripple", "%", None, 0.1)
    for language, alike, unlike in (
        (
            "en",
            "speed ripple (2 runs each, k = 4.30) is",
            "; 1 run, k = 12.71: retracting at 2 mm/s",
        ),
        (
            "de",
            "Für Ungleichförmigkeit (je 2 Läufe, k = 4,30) enthält",
            "; 1 Lauf, k = 12,71: einfahrend bei 2 mm/s",
        ),
    ):
        made = certificate(language=language)
        for ripples, words in (((measured,), alike), ((measured, fewer), unlike)):
            each = tuple(ConformityCheck(requirement, m, 1.0, "PASS") for m in ripples)
            values = (*made.values, *certified_trials(each))
            decided = replace(made.acceptance, checks=each)
            shown = replace(made, values=values, acceptance=decided)
            parts = content(shown).parts
            assert "speed_ripple" not in parts
            cells = [cell for row in parts["conformity"].tables[0].rows for cell in row]
            assert any("0.470 ± 0.073" in cell.replace(",", ".") for cell in cells)
            assert words in page_text(shown)


def test_remarks_on_accepted_runs_and_an_unchecked_load_cell_are_stated(certificate):
    made = certificate()
    first, *others = made.results.runs
    noted = replace(first, notes=("a valve was at its limit in 863 of 8048 records",))
    zeros = ZeroCheck("1", 0.0, 1e5, 100.0, (Zero("p_tp_pa", 10.0, 100.0),))
    results = replace(made.results, runs=(noted, *others), motions=Motions(zero_checks=(zeros,)))
    text = page_text(replace(made, results=results))
    remark = f"{first.run.plan.run}: a valve was at its limit in 863 of 8048 records."
    assert remark in text and "U contains no zero error of the load cell: its tolerance is" in text
    assert "0.1 % of its full scale (12 kN) would change friction by 12 N" in text
    assert "Remarks on accepted runs" not in page_text(made)
    cell = replace(zeros, zeros=(*zeros.zeros, Zero("f_applied_n", 1.0, 9.0)))
    checked = replace(made.results, motions=Motions(zero_checks=(cell,)))
    assert "zero error of the load cell" not in page_text(replace(made, results=checked))


def test_notes_of_the_record_are_on_the_certificate(certificate):
    made = replace(certificate(), warnings=("section bench was edited",))
    assert "Notes of the record: section bench was edited" in page_text(made)


def test_an_overdue_calibration_gives_no_traceability(certificate):
    made = certificate()
    stated = {"certificate": "D-K-1", "calibrated": date(2025, 1, 1), "due": date(2025, 12, 31)}
    force, pressure = made.instruments.force, made.instruments.pressure

    def with_due(due):
        calibration = force.calibration.model_copy(update=stated | {"due": due})
        changed = {
            "force": force.model_copy(update={"calibration": calibration}),
            "pressure": pressure.model_copy(update={"calibration": calibration}),
        }
        return pdf_text(replace(made, instruments=made.instruments.model_copy(update=changed)))

    assert "make the results traceable" in with_due(date(2026, 12, 31))
    overdue = with_due(date(2025, 12, 31))
    assert "2025-12-31 (overdue)" in overdue and "is not given" in overdue


def test_without_tolerances_the_uncertainty_is_said_to_be_incomplete(certificate):
    text = page_text(replace(certificate(), instruments=None))
    assert "no complete uncertainty according to JCGM 100" in text
    assert "errors of the instruments are not recorded" in text.lower()


def test_incomplete_and_poor_campaigns_are_not_certified(sample_results):
    assert why_not_certified(sample_results) == ()
    quality = sample_results.quality
    missing = replace(quality.completeness, not_completed=("0072",))
    poor = replace(sample_results, quality=replace(quality, grade="poor", completeness=missing))
    reasons = "; ".join(why_not_certified(poor))
    assert "1 of 72 planned runs were not completed" in reasons and "'poor'" in reasons
    rejected = tuple(replace(run, reasons=("no",)) for run in sample_results.runs)
    assert "no run was accepted" in why_not_certified(replace(sample_results, runs=rejected))


def test_a_reservation_of_the_data_stands_beside_the_decision(certificate):
    made = certificate()
    quality = made.results.quality
    for grade in ("good", "with care"):
        checks = tuple(replace(check, grade="good") for check in quality.checks[1:])
        graded = replace(
            quality, grade=grade, checks=(replace(quality.checks[0], grade=grade), *checks)
        )
        shown = replace(made, results=replace(made.results, quality=graded))
        lead = flat(page_text(shown)).partition("Limits: ")[2][:300]
        assert ("“with care”" in lead) == (grade == "with care")
        alone = flat(page_text(replace(shown, acceptance=None)))
        assert ("“with care”" in alone) == (grade == "with care")


def test_no_efficiency_without_load_is_stated_and_a_remark_gives_the_reason(certificate):
    made = certificate()
    loaded, _ = certified_values(made.results, None)
    assert any(value.quantity == "efficiency" for value in loaded)
    assert "No efficiency is stated" not in page_text(made)

    def unloaded(curves):
        return tuple(replace(curve, f_load_n=0.0) for curve in curves)

    results = replace(
        made.results,
        curves=unloaded(made.results.curves),
        efficiency=unloaded(made.results.efficiency),
    )
    values, _ = certified_values(results, None)
    assert {value.quantity for value in values} == {"friction"}
    text = page_text(replace(made, results=results, values=values))
    assert (
        "No efficiency is stated at a load of 0 N" in text
        and "Results: friction at constant" in text
    )
    assert "Efficiency ±" not in text and "hydro-mechanical" not in text
    (missing,) = re.findall(r"no runs that measure: ([^.]*)", text)
    assert "efficiency" not in missing
