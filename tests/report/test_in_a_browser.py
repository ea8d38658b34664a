"""Pages in a real browser: no errors, no overflow, links that work, points that tell, print."""

import re
from dataclasses import replace
from urllib.parse import unquote_to_bytes

import numpy as np
import pytest

from hbench.records import Line, Panel, Phenomenon, WordTable
from hbench.records.conformity.acceptance import ConformityCheck, Measurement, Requirement
from hbench.report.campaign.figures.all_figures import draw_all
from hbench.report.conformity.certificate.page import certificate_page
from hbench.report.conformity.decision_section import decision_drawings, decision_section
from hbench.report.design.page import design_page
from hbench.report.diagnosis.page import diagnosis_page
from hbench.report.fleet.figures import draw_fleet
from hbench.report.fleet.page import fleet_page
from hbench.report.identification.figures import draw_identification
from hbench.report.identification.page import identification_page
from hbench.report.render.document import Document, Section, document, page
from hbench.report.render.word_tables import Cell, Table
from hbench.report.simulation.figures import draw_phenomenon
from hbench.report.simulation.page import phenomenon_page
from tests.support.reconcile.made_diagnosis import drawings_of_named, named
from tests.support.report.browser import Browser
from tests.support.report.made_design import drawings_of_design, made_design
from tests.support.report.made_fleet import made_table, summary_of
from tests.support.report.made_others import aborted_page, comparison_page, made_identification
from tests.support.report.made_page import page_html

PAGES = (
    *("campaign", "seals", "diagnosis", "phenomenon", "fleet"),
    *("comparison", "identification", "aborted", "design"),
)
PRINTED = 688  # pixels of A4 less the margins
WIDTHS = (360, 400, 768, 1440)
LONG = "W" * 300


@pytest.fixture(scope="module")
def browser(require_tool, tmp_path_factory):
    opened = Browser(require_tool("chromium"), tmp_path_factory.mktemp("profile"))
    yield opened
    opened.close()


@pytest.fixture(scope="module")
def pages(small, seals, drawings, tmp_path_factory):
    """A campaign, one over pressure, a diagnosis, and a page of words too long for any line."""
    x = np.array([1.0, 2.0, 3.0])
    panel = Panel("a", "Force", "Speed (mm/s)", "Force (N)", (Line("l", x, x, points=True),))
    words = WordTable(LONG, (LONG, "b"), ((LONG, "1"),))
    phenomenon = Phenomenon("long", LONG, (LONG,), (panel,), (), (words,))
    found = named()
    texts = {
        "campaign": page_html(small, drawings),
        "seals": page_html(seals, draw_all(seals)),
        "diagnosis": diagnosis_page(found, drawings_of_named()),
        "phenomenon": phenomenon_page(phenomenon, draw_phenomenon(phenomenon)),
    }
    runs = [
        replace(
            run,
            plan=replace(run.plan, label="retracting", p_lr_ref_pa=110e5),
            gap=replace(
                run.gap,
                signals={"force_of_load_cell": run.gap.total},
                open_loop={"position_of_piston": run.gap.total},
            ),
        )
        for run in found.gap_runs
    ]
    texts["gaps"] = diagnosis_page(replace(found, gap_runs=tuple(runs)), ())
    texts["comparison"], laws = comparison_page(small), made_identification(small)
    texts["identification"] = identification_page(laws, draw_identification(laws))
    texts["design"] = design_page(made_design(), drawings_of_design())
    texts["aborted"] = aborted_page(small)
    folder = tmp_path_factory.mktemp("pages")
    fleet = summary_of(made_table(folder, 30, drift_n=90, off={7: 300.0}, failed=(3,), name=LONG))
    texts["fleet"] = fleet_page(fleet, draw_fleet(fleet))
    for name, text in texts.items():
        (folder / f"{name}.html").write_text(text)
    return {name: folder / f"{name}.html" for name in texts}


@pytest.mark.parametrize("name", PAGES)
def test_a_page_fits_every_width_without_an_error_on_the_console(browser, pages, name):
    browser.open(pages[name])
    browser.run("for (const one of document.querySelectorAll('details')) one.open = true")
    for width in WIDTHS:
        browser.width(width)
        wide = browser.run("document.documentElement.scrollWidth")
        assert wide <= width, f"{wide} px on a screen of {width}"
    browser.width(PRINTED)
    browser.ask("Emulation.setEmulatedMedia", media="print")
    wide = browser.run("document.documentElement.scrollWidth")
    browser.ask("Emulation.setEmulatedMedia", media="")
    assert wide <= PRINTED, f"{wide} px on paper of {PRINTED}"
    assert browser.errors == []


def column(browser, number):
    rows = "[...document.querySelectorAll('table.sortable tbody tr')]"
    return browser.run(f"{rows}.map(row => row.cells[{number}].textContent.trim())")


def test_a_click_or_the_keyboard_sorts_the_campaigns_of_a_fleet(browser, pages):
    browser.open(pages["fleet"])
    heads = browser.run(
        "[...document.querySelectorAll('table.sortable th')].map(h => h.textContent)"
    )
    number = next(i for i, head in enumerate(heads) if head.startswith("Friction, extending"))
    before = column(browser, number)
    button = f"document.querySelectorAll('table.sortable th button')[{number}]"
    browser.run(f"{button}.click()")
    rising = column(browser, number)
    values = [float(text.split()[0]) for text in rising]
    assert values == sorted(values) and sorted(rising) == sorted(before) and rising != before
    sort = f"{button}.parentElement.getAttribute('aria-sort')"
    assert browser.run(sort) == "ascending"
    browser.run(f"{button}.focus()")
    browser.key("Enter")
    assert column(browser, number) == rising[::-1] and browser.run(sort) == "descending"
    browser.run("document.querySelector('table.sortable th button').click()")
    assert browser.run("document.querySelectorAll('[aria-sort]').length") == 1


def test_a_narrow_table_says_that_it_has_more_columns_until_they_are_shown(browser, pages):
    browser.open(pages["fleet"], width=400)
    table = "document.querySelector('table.sortable').parentElement"
    settled = "new Promise(done => requestAnimationFrame(() => setTimeout(done, 50)))"
    browser.ask("Runtime.evaluate", expression=settled, awaitPromise=True)
    assert browser.run(f"{table}.classList.contains('more')")
    browser.run(f"{table}.scrollLeft = 1e5")
    browser.ask("Runtime.evaluate", expression=settled, awaitPromise=True)
    assert not browser.run(f"{table}.classList.contains('more')")
    browser.open(pages["fleet"], width=1440)
    browser.ask("Runtime.evaluate", expression=settled, awaitPromise=True)
    short = "[...document.querySelectorAll('.scroll')].filter(s => s.scrollWidth <= s.clientWidth)"
    assert browser.run(f"{short}.every(s => !s.classList.contains('more'))")


def test_a_table_of_few_columns_is_as_wide_as_its_numbers(browser, pages):
    browser.open(pages["diagnosis"])
    browser.run("for (const one of document.querySelectorAll('details')) one.open = true")
    shares = browser.run(
        "[...document.querySelectorAll('table')].map(t => [t.tHead.rows[0].cells.length, "
        "t.getBoundingClientRect().width / t.closest('section').clientWidth])"
    )
    assert min(share for columns, share in shares if columns <= 3) < 0.6
    assert min(share for columns, share in shares if columns > 5) > 0.9


def test_a_desktop_page_shows_all_columns_of_the_gaps_of_runs(browser, pages):
    browser.open(pages["gaps"], width=1160)
    browser.run("for (const one of document.querySelectorAll('details')) one.open = true")
    table = (
        "[...document.querySelectorAll('.scroll')].find(s => s.textContent.includes('In the fit'))"
    )
    assert browser.run(f"{table}.querySelectorAll('th').length") >= 9
    assert browser.run(f"{table}.scrollWidth - {table}.clientWidth") == 0


def test_a_printed_page_says_that_numbers_of_tables_are_missing_where_some_are(browser, pages):
    note = "document.querySelector('.on-paper')"
    browser.open(pages["diagnosis"])
    assert browser.run(f"{note}.offsetHeight") == 0
    browser.ask("Emulation.setEmulatedMedia", media="print")
    assert browser.run(f"{note}.offsetHeight") > 0
    browser.open(pages["phenomenon"])
    assert browser.run(note) is None
    browser.ask("Emulation.setEmulatedMedia", media="")


def test_a_phone_shows_figures_whole_and_scrolls_those_of_a_whole_page(browser, pages):
    """A figure of half a page fits with legible letters; a wide one scrolls, its page does not."""
    inside = (
        "[...document.querySelectorAll('svg.plot')].every(p => p.getBoundingClientRect().width "
        "<= p.parentElement.clientWidth)"
    )
    halves = "[...document.querySelectorAll('figure:not(.wide) svg.plot')]"
    letters = f"Math.min(...{halves}.map(p => 10 * (p.clientWidth - 8) / p.viewBox.baseVal.width))"
    for name, count in (("design", 4), ("identification", 2), ("diagnosis", 8)):
        browser.open(pages[name])
        browser.run("for (const one of document.querySelectorAll('details')) one.open = true")
        assert browser.run("document.querySelectorAll('svg.plot').length") >= count
        assert browser.run(inside)
        for width, least in ((360, 8.5), (400, 9.5)):
            browser.width(width)
            assert browser.run(
                f"{halves}.map(p => p.parentElement).every(c => c.scrollWidth <= c.clientWidth)"
            ), f"{name}, {width} px"
            assert browser.run(letters) >= least  # pixels, at the axes
    canvas = "document.querySelector('figure.wide .canvas')"
    assert browser.run(f"{canvas}.clientWidth") < 400
    assert browser.run(f"{canvas}.scrollWidth") >= 900
    hint = f"getComputedStyle({canvas}, '::after').content"
    browser.run("new Promise(requestAnimationFrame)")
    assert "Scroll sideways" in browser.run(hint)
    assert browser.run("document.documentElement.scrollWidth") <= 400


def test_how_to_read_a_figure_is_in_its_caption_on_a_phone_and_in_the_figure_elsewhere(
    browser, pages
):
    browser.open(pages["campaign"])
    count = browser.run("document.querySelectorAll('svg .read-as').length")
    assert count >= 5 and count == browser.run(
        "document.querySelectorAll('figcaption .read-as').length"
    )

    def shown(where):
        notes = f"[...document.querySelectorAll('{where} .read-as')]"
        return browser.run(f"{notes}.filter(n => getComputedStyle(n).display != 'none').length")

    assert (shown("svg"), shown("figcaption")) == (count, 0)
    browser.ask("Emulation.setEmulatedMedia", media="print")
    assert (shown("svg"), shown("figcaption")) == (count, 0)
    browser.ask("Emulation.setEmulatedMedia", media="")
    browser.width(400)
    assert (shown("svg"), shown("figcaption")) == (0, count)


def test_paper_omits_numbers_that_files_contain_and_nothing_else(browser, pages):
    browser.open(pages["diagnosis"])
    parts = "[...document.querySelectorAll('details')]"
    hidden = f"{parts}.filter(d => !d.checkVisibility()).map(d => d.className)"
    assert browser.run(hidden) == []
    browser.ask("Emulation.setEmulatedMedia", media="print")
    omitted = browser.run(hidden)
    browser.ask("Emulation.setEmulatedMedia", media="")
    assert len(omitted) >= 4 and set(omitted) == {"unprinted"}


def test_a_fleets_tiles_are_two_a_row_on_a_phone_with_nothing_cut_off(browser, pages):
    browser.open(pages["fleet"], width=400)
    tiles = "[...document.querySelectorAll('.tile')]"
    lefts = browser.run(f"{tiles}.map(t => Math.round(t.getBoundingClientRect().left))")
    assert len(lefts) >= 4 and len(set(lefts)) == 2
    assert browser.run(f"{tiles}.every(t => t.scrollWidth <= t.clientWidth)")
    text = browser.run(f"{tiles}.map(t => t.innerText)")
    assert any("failed" in each for each in text) and any("with a step" in each for each in text)
    browser.width(1440)
    lefts = browser.run(f"{tiles}.map(t => Math.round(t.getBoundingClientRect().left))")
    assert len(set(lefts)) >= 4


def test_short_tables_are_lists_on_a_phone_where_they_would_need_scrolling(browser, pages):
    """Each value has its column's head before it; wider, the table is one again."""
    browser.open(pages["comparison"], width=400)
    settled = "new Promise(done => requestAnimationFrame(() => setTimeout(done, 50)))"
    browser.ask("Runtime.evaluate", expression=settled, awaitPromise=True)
    assert browser.run("document.querySelectorAll('.listed').length") >= 1
    lists = "[...document.querySelectorAll('.listed')].map(t => t.closest('.scroll'))"
    assert browser.run(f"{lists}.every(s => s.scrollWidth <= s.clientWidth)")
    cell = "document.querySelector('.listed td.n')"
    head = browser.run(f"{cell}.closest('table').tHead.rows[0].cells[{cell}.cellIndex].textContent")
    assert browser.run(f"{cell}.innerText").startswith(head) and head
    browser.width(1440)
    assert browser.run(f"getComputedStyle({cell}).display") == "table-cell"
    assert not browser.run(f"{cell}.innerText").startswith(head)
    assert browser.errors == []


def test_a_screen_reader_gets_the_name_of_a_table_and_the_heads_of_a_list(browser, pages):
    """On a phone too, where the row of heads is not shown."""
    browser.open(pages["comparison"], width=400)
    settled = "new Promise(done => requestAnimationFrame(() => setTimeout(done, 50)))"
    browser.ask("Runtime.evaluate", expression=settled, awaitPromise=True)
    nodes = browser.ask("Accessibility.getFullAXTree")["nodes"]

    def names(role):
        return [n["name"]["value"] for n in nodes if n.get("role", {}).get("value") == role]

    tables = names("table")
    assert tables and all(name.startswith("Table ") for name in tables)
    heads = browser.run("[...document.querySelectorAll('.listed .head')].map(h => h.innerText)")
    assert heads and set(heads) <= set(names("StaticText"))


def test_a_list_names_the_number_that_its_rows_begin_with(browser, tmp_path):
    head = ("Speed (mm/s)", *(f"Column number {i}" for i in range(6)))
    table = WordTable("Numbers", head, (("8.0", *["12.5 ± 1.5"] * 6), ("24.8", *["3.0 ± 1.5"] * 6)))
    path = tmp_path / "page.html"
    path.write_text(page(Document("Page", "", (Section("Part", tables=(table,)),))))
    browser.open(path, width=400)
    settled = "new Promise(done => requestAnimationFrame(() => setTimeout(done, 50)))"
    browser.ask("Runtime.evaluate", expression=settled, awaitPromise=True)
    firsts = "[...document.querySelectorAll('.listed td:first-child')].map(c => c.innerText)"
    assert browser.run(firsts) == ["Speed (mm/s)8.0", "Speed (mm/s)24.8"]  # a gap is between them


def test_decisions_are_seen_on_a_phone_without_scrolling_in_figure_and_table(browser, tmp_path):
    """Of 16 decisions, in two figures that are side by side on a desktop."""
    checks = [
        ConformityCheck(
            Requirement("friction", "bar", None, 4e5, name="no-load friction at crawling speed"),
            Measurement(4.4e5 if direction == "extend" else 3e5, 3e4, 2.0, f"test {i}", direction),
            0.5,
            "FAIL" if direction == "extend" else "PASS",
        )
        for i in range(8)
        for direction in ("extend", "retract")
    ]
    drawings = decision_drawings(checks, "guard_band", simulated=True)
    section = decision_section("FAIL", checks, "guard_band", drawings=drawings)
    path = tmp_path / "page.html"
    path.write_text(page(Document("Decisions", "", (section,))))
    browser.open(path, width=1440)
    boxes = "[...document.querySelectorAll('figure')].map(f => f.getBoundingClientRect().top)"
    assert len(drawings) == 2 and len(set(browser.run(boxes))) == 1
    browser.width(400)
    settled = "new Promise(done => requestAnimationFrame(() => setTimeout(done, 50)))"
    browser.ask("Runtime.evaluate", expression=settled, awaitPromise=True)
    hidden = (
        "[...document.querySelectorAll('.canvas, .scroll')].map(s => s.scrollWidth - s.clientWidth)"
    )
    assert browser.run(hidden) == [0] * 3
    letters = (
        "Math.min(...[...document.querySelectorAll('svg.plot')].map(p => "
        "9.5 * p.getBoundingClientRect().width / p.viewBox.baseVal.width))"
    )
    assert browser.run(letters) > 10.5  # pixels


def test_a_certificates_tables_are_lists_on_a_phone(browser, certificate, tmp_path):
    """Each value has its column's head before it, and no table needs scrolling."""
    page = tmp_path / "certificate.html"
    page.write_text(certificate_page(certificate()))
    browser.open(page, width=1440)
    cell = "getComputedStyle(document.querySelector('td.n')).display"
    assert browser.run(cell) == "table-cell"
    browser.width(400)
    assert browser.run(cell) == "grid"
    assert browser.run("document.documentElement.scrollWidth") <= 400
    scrollers = "[...document.querySelectorAll('.scroll')]"
    assert browser.run(f"{scrollers}.every(s => s.scrollWidth <= s.clientWidth)")
    heads = browser.run(
        "[...document.querySelectorAll('td.n')].map(c => getComputedStyle(c, '::before').content)"
    )
    assert heads and all(len(head) > 2 for head in heads)
    assert browser.errors == []


@pytest.mark.parametrize("width", [720, 870, 970])
def test_no_column_of_a_certificate_is_hidden_on_a_screen(browser, certificate, tmp_path, width):
    """German heads and decisions are long; the series have labels, too."""
    made = certificate(language="de")
    checks = tuple(
        replace(check, decision="FAIL", measurement=replace(check.measurement, label="no load"))
        for check in made.acceptance.checks
        if check.measurement is not None
    )
    made = replace(made, acceptance=replace(made.acceptance, checks=checks))
    labelled = tuple(
        replace(each, measurement=replace(each.measurement, label="no load"))
        for each in made.values
    )
    page = tmp_path / "certificate.html"
    page.write_text(certificate_page(replace(made, values=labelled)))
    browser.open(page, width=width)
    assert "NICHT\N{NO-BREAK SPACE}BESTANDEN" in page.read_text()
    scrollers = "[...document.querySelectorAll('.scroll')]"
    assert browser.run(f"{scrollers}.map(s => s.scrollWidth - s.clientWidth)") == [0] * browser.run(
        f"{scrollers}.length"
    )


@pytest.mark.parametrize("language", ["en", "de"])
def test_a_printed_certificate_has_two_sheets(browser, certificate, tmp_path, language):
    page = tmp_path / "certificate.html"
    page.write_text(certificate_page(certificate("simulated", language=language)))
    browser.open(page)
    assert len(re.findall(rb"/Type\s*/Page\b", browser.pdf())) == 2


@pytest.mark.parametrize("language", ["en", "de"])
def test_a_printed_certificate_of_many_decisions_has_two_sheets(
    browser, many_decisions, tmp_path, language
):
    page = tmp_path / "certificate.html"
    page.write_text(certificate_page(many_decisions(language=language)))
    browser.open(page)
    assert len(re.findall(rb"/Type\s*/Page\b", browser.pdf())) == 2


def test_an_aborted_campaign_has_its_alarm_on_the_first_screen_of_a_phone(browser, pages):
    browser.open(pages["aborted"], width=400)
    box = browser.run(
        "(({top, bottom, height}) => [top, bottom, height])"
        "(document.querySelector('[role=alert]').getBoundingClientRect())"
    )
    assert 0 < box[0] < 450 and box[2] > 60


def test_an_error_on_the_console_and_an_overflow_would_be_seen(browser, pages):
    browser.open(pages["campaign"])
    browser.run("document.querySelector('h1').style.width = '2000px'")
    assert browser.run("document.documentElement.scrollWidth") >= 2000
    browser.run("const one = document.createElement('script'); one.textContent = '1';"
                "document.body.append(one)")  # fmt: skip
    browser.run("console.error('seen')")
    assert "Content Security Policy" in browser.errors[0] and "seen" in browser.errors[-1]


@pytest.mark.parametrize("name", PAGES)
def test_links_lead_to_an_element_or_hold_the_figures_data(browser, pages, name):
    browser.open(pages[name])
    lost = "[...document.links].map(a => a.getAttribute('href')).filter(h => h[0] == '#' && "
    assert browser.run(lost + "!document.getElementById(decodeURIComponent(h.slice(1))))") == []
    others = "[...document.links].filter(a => a.getAttribute('href')[0] != '#')"
    assert browser.run(f"{others}.every(a => a.href.startsWith('data:text/csv') && a.download)")


def test_the_data_that_a_link_holds_is_the_figures(browser, pages, drawings):
    browser.open(pages["campaign"])
    links = browser.run("[...document.querySelectorAll('a.data')].map(a => a.href)")
    assert [unquote_to_bytes(link.partition(",")[2]) for link in links] == [
        drawing.csv for drawing in drawings
    ]


def test_pointing_at_a_point_tells_its_trials_and_leaving_it_is_silent(browser, pages, small):
    browser.open(pages["campaign"])
    at = browser.run(
        "const point = document.querySelector('.point'); point.scrollIntoView({block: 'center'});"
        "const box = point.getBoundingClientRect(); [box.x + box.width / 2, box.y + box.height / 2]"
    )
    browser.point_at(at[0] + 5, at[1] + 3)
    told = browser.run("document.querySelector('.tip').innerText")
    first = small.curves[0].points[0]
    assert f"runs: {' '.join(first.runs)}" in told
    assert all(f"{trial:.1f}" in told for trial in first.trials_n)
    browser.point_at(5, 5)
    assert browser.run("document.querySelector('.tip').hidden")


def test_the_keyboard_walks_the_points_of_a_figure(browser, pages, small):
    browser.open(pages["campaign"])
    browser.run("document.querySelector('svg.plot').focus()")
    tip = "document.querySelector('.tip').innerText"
    for number, key in ((0, "ArrowRight"), (1, "ArrowRight"), (0, "ArrowLeft")):
        browser.key(key)
        assert f"runs: {' '.join(small.curves[0].points[number].runs)}" in browser.run(tip)
        label = browser.run("document.activeElement.getAttribute('aria-label')")
        assert label == browser.run("document.querySelector('.tip').textContent")
    browser.key("Escape")
    assert browser.run("document.querySelector('.tip').hidden")
    assert browser.run("document.activeElement.matches('svg.plot')")


def test_the_footer_explains_pointing_where_a_figure_has_points(browser, pages, tmp_path):
    (tmp_path / "words.html").write_text(document("Words", "", (Section("Some", ("text",)),)))
    for each, explained in ((pages["campaign"], True), (tmp_path / "words.html", False)):
        browser.open(each)
        assert ("Point at a mark" in browser.run("document.body.innerText")) is explained


def test_figures_and_page_are_light_or_dark_as_the_reader_wants(browser, pages):
    brightness = {}
    for dark in (False, True):
        browser.open(pages["campaign"], dark=dark)
        back = browser.run("getComputedStyle(document.body).backgroundColor")
        paper = browser.run("getComputedStyle(document.querySelector('.plot path')).fill")
        ink = browser.run("getComputedStyle(document.querySelector('.plot')).fill")
        brightness[dark] = [
            sum(map(int, re.findall(r"\d+", one)[:3])) for one in (back, paper, ink)
        ]
    assert brightness[False][0] > 600 and brightness[False][1] > 600 and brightness[False][2] < 100
    assert brightness[True][0] < 150 and brightness[True][1] < 150 and brightness[True][2] > 600


def test_paper_is_a4_and_only_long_tables_are_broken_after_two_rows_at_least(browser, tmp_path):
    tables = tuple(
        Table(("a", "b"), tuple((Cell(str(row)), Cell("1")) for row in range(count)), frozenset())
        for count in (6, 7)
    )
    path = tmp_path / "tables.html"
    path.write_text(page(Document("t", "", (Section("s", tables=tables),))))
    browser.open(path)
    (box,) = set(re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", browser.pdf()))
    assert [float(side) for side in box] == pytest.approx([595.3, 841.9], abs=1)  # 210 x 297 mm
    browser.ask("Emulation.setEmulatedMedia", media="print")
    style = "getComputedStyle"
    of_tables = f"[...document.querySelectorAll('table')].map(t => {style}(t).breakInside)"
    rows = "[...document.querySelectorAll('table')[1].tBodies[0].rows]"
    inside, after, before = (
        browser.run(f"{rows}.map(row => {style}(row).{name})")
        for name in ("breakInside", "breakAfter", "breakBefore")
    )
    kept = browser.run(of_tables)
    browser.ask("Emulation.setEmulatedMedia", media="")
    assert kept == ["avoid", "auto"] and set(inside) == {"avoid"}
    assert after == ["avoid"] * 2 + ["auto"] * 5
    assert before == ["auto"] * 5 + ["avoid"] * 2
    assert browser.run(of_tables) == ["auto", "auto"]  # on a screen


@pytest.mark.parametrize("dark", [False, True])
def test_print_has_every_page_in_light_colours_and_nothing_folded(browser, pages, dark):
    browser.open(pages["campaign"], dark=dark)
    text = browser.pdf()
    assert text.startswith(b"%PDF") and len(re.findall(rb"/Type\s*/Page\b", text)) >= 3
    browser.ask("Emulation.setEmulatedMedia", media="print")
    assert browser.run("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert browser.run("getComputedStyle(document.querySelector('.plot path')).fill") in (
        "rgb(255, 255, 255)"
    )
    browser.run("window.dispatchEvent(new Event('beforeprint'))")
    assert browser.run("document.querySelectorAll('details:not([open])').length") == 0
    browser.ask("Emulation.setEmulatedMedia", media="")
