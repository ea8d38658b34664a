"""The report as Markdown and as PDF, and what reconcile left in a campaign's folder."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from typer.testing import CliRunner

from hbench import workflow
from hbench.cli.main import app
from hbench.errors import ConfigError
from hbench.records import WordTable
from hbench.report.campaign.page import report_document
from hbench.report.campaign.reconciled import reconciled_section
from hbench.report.render.document import Document, Section, page
from hbench.report.render.figures import Drawing, as_png, as_svg
from hbench.report.render.markdown import markdown
from hbench.report.render.pdf import pdf, sheets
from hbench.store.campaign.stored_diagnosis import diagnoses
from tests.support.report.spaces import breakable, ordinary_spaces

SAMPLE = Path(__file__).parents[2] / "data_samples" / "bad-runs"


@pytest.fixture(scope="module")
def made(small, drawings):
    return report_document(small, drawings)


@pytest.fixture
def campaign(tmp_path, undrawn):
    return Path(shutil.copytree(SAMPLE, tmp_path / "bad"))


def test_the_folders_name_tells_campaigns_of_one_schedule_apart_in_every_form(campaign):
    campaign = campaign.rename(campaign.with_name("cylinder-7"))
    results = campaign / "results"
    for form in ("html", "md", "pdf"):
        workflow.report(campaign, form=form)
    page_text = breakable((results / "report.html").read_text())
    assert re.search(r"<title>cylinder-7: bad runs \(\w+\)</title>", page_text)
    assert "<h1>bad runs</h1>" in page_text and '<p class="sub">cylinder-7 · ' in page_text
    assert (results / "report.md").read_text().startswith("# bad runs\n\ncylinder-7 · ")
    assert b"cylinder-7: bad runs" in (results / "report.pdf").read_bytes()
    assert "cylinder-7" not in (results / "results.json").read_text()


def test_numbers_stand_at_the_right_of_their_column_in_markdown_and_pdf():
    table = WordTable("", ("name", "value (N)"), (("a", "7"), ("bcd", "1234")))
    made = Document("t", "", (Section("s", tables=(table,)),))
    assert "| --- | ---: |" in markdown(made)
    texts = {text.get_text(): text for sheet in sheets(made) for text in sheet.texts}
    ends = {texts[number].get_position()[0] for number in ("7", "1234", "value (N)")}
    assert len(ends) == 1 and {texts[n].get_ha() for n in ("7", "1234")} == {"right"}
    assert texts["a"].get_position()[0] == texts["bcd"].get_position()[0] < min(ends)


def test_the_index_of_a_symbol_is_below_the_line_and_smaller_in_a_pdf():
    made = Document("t", "", (Section("s", ("Coulomb force F_C in N, of file_C",)),))
    texts = {text.get_text(): text for sheet in sheets(made) for text in sheet.texts}
    before, index, after = (texts[each] for each in ("Coulomb force F", "C", " in N, of file_C"))
    assert before.get_position()[0] < index.get_position()[0] < after.get_position()[0]
    assert index.get_position()[1] < before.get_position()[1] == after.get_position()[1]
    assert index.get_size() < before.get_size()


def test_each_sheet_of_a_pdf_has_cylinder_number_and_date_of_the_test():
    identity = (("Cylinder", "HC-7"), ("Test number", "17"), ("Measured", "2026-01-05 08:00 UTC"))
    (sheet,) = sheets(Document("t", "", (Section("s", ("Text.",)),), identity=identity))
    assert "HC-7 · test 17 · 2026-01-05 · hbench" in texts_of(sheet)
    (sheet,) = sheets(Document("t", "", (Section("s", ("Text.",)),)))
    assert "hbench" in texts_of(sheet)


def test_an_index_is_where_its_symbol_ends_as_it_is_set():
    """Kerning makes a long line shorter than its letters' advances: "AVAVAV" has much of it."""
    made = Document("t", "", (Section("s", ("AVAVAVAVAVAVAVAV F_C, of",)),))
    (sheet,) = sheets(made)
    texts = {text.get_text(): text for text in sheet.texts}
    before, index = texts["AVAVAVAVAVAVAVAV F"], texts["C"]
    renderer = sheet.canvas.get_renderer()
    ends = before.get_window_extent(renderer).x1 - index.get_window_extent(renderer).x0
    assert abs(ends) < 0.1 * before.get_size() * sheet.dpi / 72


def test_each_sheet_of_a_pdf_has_the_documents_name_and_its_number():
    table = WordTable("", ("name", "value (N)"), tuple((f"row {i}", str(i)) for i in range(150)))
    made = Document("stribeck", "", (Section("s", tables=(table,)),), source="simulated")
    filled = sheets(made)
    assert len(filled) >= 2
    for number, sheet in enumerate(filled, start=1):
        texts = [text.get_text() for text in sheet.texts]
        assert "stribeck (simulated)" in texts and f"Page {number} of {len(filled)}" in texts
        assert "value (N)" in texts  # the head of the table is repeated
        assert ("Table 1. s (continued)" in texts) == (number > 1)


def of_rows(name, count):
    rows = tuple((f"{name}{i}", str(i)) for i in range(count))
    return Section(f"Section {name}", tables=(WordTable("", ("row", "value (N)"), rows),))


def texts_of(sheet):
    return [text.get_text() for text in sheet.texts]


@pytest.mark.filterwarnings("ignore:Glyph")
def test_a_sheet_with_letters_that_the_font_lacks_says_that_they_are_boxes():
    def footers(title):
        feet = [t.get_text() for t in sheets(Document(title, "", ()))[0].texts]
        return [text for text in feet if text.startswith("Written by hbench")]

    assert "Boxes" not in str(footers("Zylinder 7, Öl"))
    assert "Boxes stand for letters that the font" in str(footers("油缸 7"))


def test_a_short_table_is_not_divided_nor_apart_from_its_heading_in_a_pdf():
    one, two = sheets(Document("t", "", (of_rows("a", 48), of_rows("b", 5))))
    assert {"Section b", *(f"b{i}" for i in range(5))} <= set(texts_of(two))
    assert "a47" in texts_of(one)


def test_a_long_table_begins_on_the_sheet_that_has_room_in_a_pdf():
    one, two = sheets(Document("t", "", (of_rows("a", 40), of_rows("b", 25))))
    assert {"Section b", "b0", "b5"} <= set(texts_of(one)) and "b24" in texts_of(two)


def test_a_table_of_a_quarter_sheet_leaves_no_such_part_of_a_sheet_empty_in_a_pdf():
    one, two = sheets(Document("t", "", (of_rows("a", 40), of_rows("b", 18))))
    assert {"Table 2. Section b", "b0", "b1"} <= set(texts_of(one))
    assert {"Table 2. Section b (continued)", "b16", "b17"} <= set(texts_of(two))


def test_a_heading_with_its_text_is_not_apart_from_its_table_in_a_pdf():
    second = Section("Second", ("Words.",), tables=of_rows("b", 6).tables)
    for count in range(38, 52):
        pages = list(map(texts_of, sheets(Document("t", "", (of_rows("a", count), second)))))
        (heading,) = [i for i, page in enumerate(pages) if "Second" in page]
        assert {"Words.", "Table 2. Second", "b0", "b1"} <= set(pages[heading])


def test_the_last_fact_is_not_alone_on_a_sheet_of_a_pdf():
    for count in range(50, 90):
        facts = tuple((f"f{i}", "words") for i in range(count))
        last = texts_of(sheets(Document("t", "", (Section("Facts", facts=facts),)))[-1])
        assert f"f{count - 2}" in last


def test_the_contents_of_a_pdf_give_the_page_of_each_section():
    made = Document("t", "", tuple(of_rows(name, 40) for name in "abcd"))
    filled = sheets(made)
    (contents,) = [text for text in texts_of(filled[0]) if text.startswith("Contents:")]
    listed = contents.replace("\N{NO-BREAK SPACE}", " ").removeprefix("Contents: ").split(" · ")
    assert len(listed) == 4 and not listed[-1].endswith(" 1")
    for each in listed:
        title, page = each.rsplit(" ", 1)
        assert title in texts_of(filled[int(page) - 1])
    short = Document("t", "", (of_rows("a", 3),))
    assert not any(text.startswith("Contents") for text in texts_of(sheets(short)[0]))


def test_what_follows_a_figure_without_room_fills_the_sheet_in_a_pdf():
    figure = Figure(figsize=(3, 4))
    drawings = tuple(
        Drawing(name, "", name, "", as_svg(figure), as_png(figure), wide=True)
        for name in ("one", "two")
    )
    section = replace(of_rows("a", 5), paragraphs=("Text.",), drawings=drawings)
    last = Section("Figures alone", drawings=(replace(drawings[0], name="three", title="three"),))
    first, *more = sheets(Document("t", "", (of_rows("b", 36), section, last)))
    assert not first.axes and {"Section a", "Text.", "a4"} <= set(texts_of(first))
    captions = [text for sheet in more for text in texts_of(sheet) if text.startswith("Figure")]
    assert [caption[:9] for caption in captions] == [
        "Figure 1.",
        "Figure 2.",
        "Figures a",
        "Figure 3.",
    ]


def test_only_the_first_sentence_of_a_long_verdict_is_bold_in_a_pdf():
    made = Document("t", "", (), "Friction is 500 N. " + "Use it with care. " * 20)
    (sheet,) = sheets(made)
    weights = {text.get_text().partition(".")[0]: text.get_weight() for text in sheet.texts}
    assert weights["Friction is 500 N"] == "bold" and weights["Use it with care"] == "normal"


def test_the_banner_is_framed_and_the_verdict_has_a_bar_in_a_pdf():
    made = Document("t", "", (), "Friction is low. Use it.", "Simulated.", "simulated")
    (sheet,) = sheets(made)
    (frame,) = (patch for patch in sheet.artists if isinstance(patch, Rectangle))
    (bar,) = (line for line in sheet.artists if isinstance(line, Line2D))
    heights = {text.get_text(): text.get_position()[1] for text in sheet.texts}
    assert {"Simulated.", "Friction is low. Use it."} <= set(heights)
    assert frame.get_y() < heights["Simulated."] < frame.get_y() + frame.get_height()
    low, high = sorted(bar.get_ydata())
    assert low < heights["Friction is low. Use it."] < high < frame.get_y()
    (plain,) = sheets(Document("t", "", (), "Friction is 500 N."))
    assert not any(isinstance(artist, Rectangle) for artist in plain.artists)


def test_markdown_has_every_section_table_and_figure(made, drawings):
    text = markdown(made)
    heads = re.findall(r"^## (.+)$", text, re.MULTILINE)
    assert heads == [section.title for section in made.sections]
    for one in drawings:
        assert f"](figures/{one.name}.svg)" in text and f"[Data](figures/{one.name}.csv)" in text
    assert "| extending | 500 |" in text and "Breakaway ± U (N), extrapolated" in text


@pytest.mark.parametrize(
    "evil",
    ["<script>alert(1)</script>", "[a](javascript:alert(1))", "| a | b |", "# head", "1. item",
     "- item", "`code`", "![x](http://evil)", "a\n\n# b"],
)  # fmt: skip
def test_no_text_of_a_stranger_is_markup_in_markdown(evil):
    section = Section(evil, (evil,), (evil,), tables=(WordTable(evil, (evil,), ((evil,),)),))
    text = markdown(Document(evil, evil, (section,)))
    assert not re.search(r"(?<!\\)(<script|\[a\]|!\[)", text)
    lines = [line for line in text.splitlines() if line]
    assert sum(line.startswith("#") for line in lines) == 2  # the title's and the section's
    assert all(len(re.findall(r"(?<!\\)\|", line)) in (0, 2) for line in lines)
    assert not any(re.match(r"(1\.|- item|`) ", line) for line in lines)


def test_each_figure_of_a_pdf_has_its_own_caption_in_its_column_and_unprinted_parts_are_left_out():
    axes = Figure(figsize=(2, 1)).subplots()
    axes.plot([1, 2])
    svg, png = as_svg(axes.figure), as_png(axes.figure)
    figures = tuple(Drawing(n, "s", n, "Same words.", svg, png) for n in ("One", "Two", "Three"))
    parts = (Section("Kept", ("a",)), Section("Gone", ("b",), folded=True, printed=False))
    (sheet,) = sheets(Document("t", "", (Section("S", drawings=figures, parts=parts),)))
    places = {text.get_text(): text.get_position() for text in sheet.texts}
    one, two, three = (
        places[words]
        for words in (
            "Figure 1. One. Same words.",
            "Figure 2. Two. As for Figure 1.",
            "Figure 3. Three. As for Figure 1.",
        )
    )
    assert one[1] == two[1] > three[1] and one[0] < 0.3 < 0.5 < two[0] == three[0]
    assert "Kept" in places and "Gone" not in places
    assert any("has more tables; the numbering counts them" in words for words in places)
    bare = tuple(Drawing(n, "s", n, "", svg, png) for n in ("One", "Two"))
    (sheet,) = sheets(Document("t", "", (Section("S", drawings=bare),)))
    assert "Figure 2. Two." in {text.get_text() for text in sheet.texts}


def test_a_pdf_has_its_pages_and_is_the_same_twice(made):
    short = replace(made, sections=made.sections[:2])  # letters, a table and figures
    first = pdf(short)
    assert first.startswith(b"%PDF")
    pages = len(re.findall(rb"/Type /Page\b", first))
    assert pages == len(sheets(short)) >= 2
    assert pdf(short) == first


def test_nothing_on_a_sheet_lies_beyond_its_edges(made):
    for sheet in sheets(made):
        renderer = sheet.canvas.get_renderer()
        for text in sheet.texts:
            box = text.get_window_extent(renderer)
            assert 0 <= box.x0 and box.x1 <= sheet.bbox.width, text.get_text()
            assert 0 <= box.y0 and box.y1 <= sheet.bbox.height
        for axes in sheet.axes:
            assert 0 <= axes.get_position().y0 and axes.get_position().y1 <= 1


@pytest.mark.parametrize("form", ["html", "md", "pdf"])
def test_the_command_writes_the_form_that_was_asked_for(campaign, form):
    done = CliRunner().invoke(app, ["report", str(campaign), "--format", form])
    assert done.exit_code == 0 and f"report.{form}" in done.stderr
    written = {path.name for path in (campaign / "results").glob("report.*")}
    assert written == {f"report.{form}"}


def test_a_working_speed_is_read_with_its_unit_and_used(campaign):
    done = CliRunner().invoke(app, ["report", str(campaign), "--speed", "0.1 m/s"])
    assert done.exit_code == 0
    first = (campaign / "results" / "report.html").read_text().partition(">Summary</h2>")[2]
    assert re.search(r"<td[^>]*>100\.0</td>", first.partition("</table>")[0]), "at the speed"
    for wrong in ("100", "1 bar", "0 mm/s", "-5 mm/s", "10 m/s"):
        done = CliRunner().invoke(app, ["report", str(campaign), "--speed", wrong])
        assert isinstance(done.exception, ConfigError) and "--speed" in done.exception.message


DIAGNOSIS = {
    "schema": "hbench.diagnosis/1",
    "verdict": "named",
    "why": "because <b>",
    "effects": [
        {
            "name": "internal_leakage",
            "parameters": {
                "test": {"value": 0.0058, "ci95": [0.0056, 0.0061], "unit": "l/min/bar"}
            },
            "gap_before": 12.3,
            "gap_after": 1.1,
        }
    ],
    "gap": {
        "heldout": {
            "before": 9.8,
            "after": 1.2,
            "floor": 1.0,
            "signals": {"v": {"before": 4.5, "after": 1.05, "floor": 1.0}},
        }
    },
    "next_experiment": None,
}  # fmt: skip


def test_a_diagnosis_in_the_campaigns_folder_is_told_before_and_after(campaign):
    (campaign / "model").mkdir()
    (campaign / "model" / "diagnosis.json").write_text(json.dumps(DIAGNOSIS))
    workflow.report(campaign)
    text = ordinary_spaces((campaign / "results" / "report.html").read_text())
    section = reconciled_section("model", DIAGNOSIS)
    assert f">{section.title}<" in text and "because &lt;b&gt;" in text
    assert "test = 0.00580 l/min/bar (95 %: 0.00560 to 0.00610)" in text
    assert re.search(r"\b12\.30 to 1\.10\b", text)
    cells = "".join(f'<td class="n">{gap}</td>' for gap in ("4.50", "1.05", "–"))
    assert cells in text


def test_an_effect_whose_gap_does_not_fall_is_stated_as_not_confirmed():
    (effect,) = DIAGNOSIS["effects"]
    worse = DIAGNOSIS | {"effects": [effect | {"gap_before": 1.02, "gap_after": 1.04}]}
    for content, confirmed in ((DIAGNOSIS, True), (worse, False)):
        text = " ".join(reconciled_section("model", content).paragraphs)
        assert ("falls from" in text) is confirmed
        assert ("runs outside the fit do not confirm it: 1.02 to 1.04." in text) is not confirmed


def test_without_a_diagnosis_there_is_no_such_section(campaign):
    workflow.report(campaign)
    title, _, _ = reconciled_section("model", DIAGNOSIS).title.partition(" (")
    assert title not in (campaign / "results" / "report.html").read_text()


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{", "null", '{"schema": "other"}', "[" * 100_000, "\udcff", '{"a": NaN}'],
)
def test_a_diagnosis_that_can_not_be_read_is_said_so(campaign, text):
    (campaign / "model").mkdir()
    (campaign / "model" / "diagnosis.json").write_bytes(text.encode(errors="surrogateescape"))
    ((name, reason),) = diagnoses(campaign)
    assert name == "model" and isinstance(reason, str)
    section = reconciled_section(name, reason)
    assert reason in section.paragraphs[0] and not section.tables


@pytest.mark.parametrize(
    "wrong", [None, 3, "x", [], [[]], {"a": 1}, [1], True, float("inf"), 10**400]
)
def test_parts_of_another_form_than_they_should_have_are_left_out(wrong):
    for key in ("effects", "gap", "verdict", "why", "next_experiment"):
        section = reconciled_section("m", DIAGNOSIS | {key: wrong})
        assert page(Document("t", "", (section,)))
    effect = DIAGNOSIS["effects"][0] | {"parameters": {"p": wrong}, "gap_before": wrong}
    held = {"signals": {"v": wrong}, "before": wrong, "balances": wrong}
    content = DIAGNOSIS | {"effects": [effect], "gap": {"heldout": held}}
    assert page(Document("t", "", (reconciled_section("m", content),)))


def test_a_link_out_of_the_campaign_is_not_followed(campaign, tmp_path):
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "diagnosis.json").write_text(json.dumps(DIAGNOSIS))
    (campaign / "link").symlink_to(outside)
    assert diagnoses(campaign) == []
