"""Documents: sections of words, figures and tables, all of it escaped."""

import re
from html import unescape

import pytest

from hbench.records import WordTable
from hbench.report.render.document import Document, Section, document, numbered
from hbench.report.render.figures import Drawing


def test_columns_of_numbers_are_aligned_as_numbers_and_others_are_not():
    table = WordTable("T", ("load", "who"), (("−1.5", "1 a"), ("none", "b"), ("2 ± 0.1", "3")))
    page = document("D", "", (Section(tables=(table,)),))
    assert re.findall(r'<th scope="col"( class="n")?>(\w+)', page) == [
        (' class="n"', "load"),
        ("", "who"),
    ]
    assert page.count('<td class="n">') == 3


def test_every_text_is_escaped_and_symbols_get_their_subscripts():
    evil = "<script>&P_Tp"
    table = WordTable(evil, (evil,), ((evil,),))
    section = Section(evil, (evil,), (evil,), evil, (), (table,))
    page = document(evil, evil, (section,), evil)
    assert "<script>&" not in page and page.count("<script>") == 1  # the page's own
    assert "P<sub>Tp</sub>" in page


def test_a_table_has_the_same_number_on_page_and_paper_and_the_text_refers_to_it():
    def table(title):
        return WordTable(title, ("head",), (("cell",),))

    hidden = Section("Hidden", tables=(table("on the page alone"),), folded=True, printed=False)
    shown = Section("Shown (3)", tables=(table(""),), folded=True)
    sections = (
        Section("First", ("See [[last]], [[text]] and [[nowhere]].",), tables=(table("one"),)),
        Section("Last", parts=(hidden, shown)),
        Section("Text"),
    )
    titles = {}
    for on_paper in (False, True):
        first, last, _ = numbered(Document("D", "", sections), on_paper).sections
        assert first.paragraphs == ("See Table 2, “Text” and [[nowhere]].",)
        titles[on_paper] = [each.title for part in (first, *last.parts) for each in part.tables]
    assert titles == {
        False: ["Table 1. one", "Table 2. on the page alone", "Table 3. Shown"],
        True: ["Table 1. one", "Table 3. Shown"],
    }


def test_the_link_to_a_figures_data_has_the_number_of_its_caption():
    svg = b'<svg xmlns="http://www.w3.org/2000/svg"/>'
    drawings = [Drawing(n, "", n, "", svg, b"", csv=b"x\n1\n") for n in ("folded", "shown")]
    folded = Section("Folded", drawings=(drawings[0],), folded=True, printed=False)
    page = document("D", "", (Section("A", parts=(folded,)), Section("B", drawings=(drawings[1],))))
    assert "<b>Figure 2. shown.</b>" in page
    assert re.findall(r">Data of (.+) \(CSV\)<", page) == ["figure 1", "figure 2"]


def test_the_emphasised_sentence_of_a_long_verdict_may_end_with_a_unit():
    first = "Friction is 553 N; U does not contain a drift of up to 36 %."
    rest = " ".join(["Use the data with care, and state the tolerances in the bench file."] * 4)
    assert Document("t", "", (), f"{first} {rest}").headline == (first, rest)


def test_a_reference_on_paper_to_a_table_that_is_not_printed_leads_to_the_page():
    table = WordTable("one", ("head",), (("cell",),))
    hidden = Section("All of them (1)", tables=(table,), folded=True, printed=False, anchor="all")
    made = Document("D", "", (Section("S", ("See [[all]].",), parts=(hidden,)),))
    on_page, on_paper = (numbered(made, paper).sections[0].paragraphs for paper in (False, True))
    assert on_page == ("See Table 1.",) and on_paper == ("See “All of them” on the page.",)


def test_a_caption_is_written_once_in_a_section_and_its_parts_that_are_seen():
    def figures(*names):
        return tuple(Drawing(name, "s", name, "Same words.", "<svg/>", b"") for name in names)

    parts = (
        Section("Open", drawings=figures("b")),
        Section("Folded", drawings=figures("c"), folded=True),
    )
    alone = (
        Section("Folded", drawings=figures("d"), folded=True),
        Section("", drawings=figures("e")),
    )
    sections = (Section("S", drawings=figures("a"), parts=parts), Section("T", parts=alone))
    first, second = numbered(Document("t", "", sections)).sections
    captions = [part.drawings[0].caption for part in (first, *first.parts, *second.parts)]
    assert captions == [
        "Same words.", "As for Figure 1.", "As for Figure 1.", "Same words.", "Same words."
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("by HC-0011, and", ["HC-0011"]),
        ("2026-01-05 to 2026-01-18", ["2026-01-05", "2026-01-18"]),
        ("give --propose", ["--propose"]),
        ("PTFE-20 & <b>", ["PTFE-20"]),
        ("hydro-mechanical, ISO 5725-6, -7", []),
        ("a-name-that-does-not-fit-in-a-cell-0001", []),
    ],
)
def test_names_dates_and_options_are_not_broken_at_hyphens(text, kept):
    """A name that is too long for a narrow column is."""
    page = document("title", "", (Section("part", (text,)),))
    paragraph = re.search("<p>(.*)</p>", page)[1]
    assert re.findall('<span class="whole">(.*?)</span>', paragraph) == kept
    assert unescape(re.sub("</?span[^>]*>", "", paragraph)) == text


def test_a_folded_part_states_which_figures_and_tables_it_hides():
    """Else the first table that a reader sees could be the fourth."""
    table = WordTable("", ("a",), (("1",),))
    folded = Section("All gaps", tables=(table, table, table), folded=True)
    words = Section("Terms", facts=(("a", "b"),), folded=True)
    sections = (
        Section("Gap", parts=(folded, words)),
        Section("Effects", tables=(table,)),
        Section("Appendix", tables=(table,), folded=True),
    )
    text = document("Page", "", sections)
    summaries = [
        re.sub("<[^>]+>", "", each) for each in re.findall("<summary>(.*?)</summary>", text)
    ]
    assert summaries == ["All gaps Tables 1–3", "Terms", "Appendix Table 5"]
