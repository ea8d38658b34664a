"""Documents: sections of words, figures and tables, all of it escaped."""

import re

from hbench.records import WordTable
from hbench.report.render.document import Section, document


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
