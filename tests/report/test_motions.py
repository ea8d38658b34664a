"""What moving and resting runs tell: rows, lines, figures and the page, from made-up records."""

import csv
import io
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg

from hbench.records import (
    Breakaway,
    Comparison,
    Decay,
    DistanceTrend,
    DwellLaw,
    Leakage,
    LeakCoefficient,
    Level,
    Loop,
    LoopWidth,
    Motions,
    Series,
    Surface,
    Zero,
    ZeroCheck,
)
from hbench.report.campaign.csv_motions import MOTION_TABLES, motion_tables
from hbench.report.campaign.figures import motions, ramps
from hbench.report.campaign.figures.all_figures import FIGURES
from hbench.report.campaign.figures.motions import breakaways
from hbench.report.campaign.page import report_document
from hbench.report.campaign.page_motions import hold_table
from hbench.report.campaign.page_tables import point_table
from hbench.report.campaign.results_document import results_json
from hbench.report.campaign.terminal import summary_text
from hbench.report.creep_words import creep_facts
from hbench.report.render.figures import Drawing
from hbench.report.render.style import QUIET, RC
from tests.support.report.made_page import page_html
from tests.support.report.spaces import ordinary_spaces

SERIES = Series("seal A", 500.0, 15e5)
BLANK = b'<svg xmlns="http://www.w3.org/2000/svg"/>'
LOST = ((0.0, 0.0, 0.0), (2.0, 6e-10, -4e-10))
PHASE = np.linspace(0, 2 * np.pi, 60, endpoint=False)


def comparison(what, effect, p_holm, ci95_n=4.0):
    a = (0.03, 0.1) if what == "acceleration" else (0.1,)
    half = p_holm and p_holm / 2
    message = "" if p_holm else "one trial: there is no scatter"
    return Comparison(
        what, SERIES, "extend", a, 0.01, 0.09, effect, ci95_n, half, p_holm, 6, message
    )


MOTIONS = Motions(
    comparisons=(
        comparison("acceleration", 12.0, 0.004),
        comparison("acceleration", -2.0, 0.6),
        comparison("steady", 1.5, 0.9),
    ),
    loops=(
        Loop(
            SERIES,
            0.1,
            0.05,
            2,
            1,
            "cycle",
            175.9,
            0.27,
            (LoopWidth(-0.05, -17.6, 1.9, -17.2), LoopWidth(0.05, 32.7, None, None)),
            tuple(
                (0.2 + 0.1 * np.sin(p), 0.1 * np.cos(p), 400 * np.sign(np.cos(p))) for p in PHASE
            ),
            ("0001",),
        ),
    ),
    levels=(
        Level(SERIES, 1, 0.0, 0.05, None, 402.0, 3.0, None, None, 3, ("0002",)),
        Level(SERIES, 2, 0.05, 0.1, 402.0, 428.0, None, 65.8, 0.3, 3, ("0002",)),
    ),
    leakages=(
        Leakage(
            "",
            (
                LeakCoefficient("across_piston", 4e-14, 1e-15, (3.7e-14, 4.3e-14)),
                LeakCoefficient("piston_side_out", 1e-16, 1e-15, (-2e-15, 2.2e-15)),
                LeakCoefficient("rod_side_out", None, None, None),
            ),
            (Decay("0003", SERIES, 45e5, 60e5, -100.0, 50.0, 3e-10, -2e-10, LOST),),
            7e7,
            "conditional on the bench file's bulk modulus",
        ),
    ),
    over_distance=(
        DistanceTrend(
            *("friction_n", SERIES, None, 0.15, None, (1.0, 2.0, 3.0, 4.0, 5.0)),
            *((420.0, 410.0, 403.0, 401.0, 400.0), -4.9, 3.6, 421.5, 0.02, 0.04),
            *(2.0, 403.5, -9.7, 6.6, "settled", "triangle"),
        ),
    ),
    surfaces=(
        Surface(
            "",
            "extend",
            15e5,
            (0.01, 0.05, 0.2),
            (500.0, 1000.0, 5000.0),
            ((400.0, 380.0, 500.0), (410.0, 390.0, 520.0), (450.0, 440.0, 600.0)),
            ((5.0, None, 4.0),) * 3,
        ),
    ),
)


PUSHES = tuple(
    Breakaway(
        SERIES, "extend", dwell_s, 500.0, 480.0, ci95_n, u95_n, 2, (478.0, 482.0), 5e-3, 6e6, 3e6,
        500.0, ("0007", "0008"),
    )
    for dwell_s, ci95_n, u95_n in ((1.0, 12.0, 60.0), (60.0, 10.0, None))
)  # fmt: skip
GROWTH = DwellLaw(SERIES, "extend", "power", 470.0, 8.0, 0.02, 0.01, 6.0, 3, 9)
CHECKED = ZeroCheck("0001", 0.0, 2e5, 1e4, (Zero("p_tp_pa", 1e3, 2e5),))


@pytest.fixture
def moving(small):
    """The small campaign with its steady curves, ramps beside, and all that moves."""
    ramps = tuple(
        replace(curve, kind="ramp", a_ref_m_s2=a) for curve in small.curves for a in (0.03, 0.1)
    )
    motions = replace(MOTIONS, breakaways=PUSHES, dwell_laws=(GROWTH,), zero_checks=(CHECKED,))
    return replace(small, curves=small.curves + ramps, motions=motions)


@pytest.mark.parametrize(
    ("breakaway_n", "v_m_s", "explained"),
    [(482.0, 0.008, True), (520.0, 0.008, False), (482.0, 0.001, False), (430.0, 0.008, False)],
)
def test_a_breakaway_below_friction_at_a_crawl_is_explained_by_its_creep(
    moving, breakaway_n, v_m_s, explained
):
    """502 N at 2 mm/s and 443 N at 20 mm/s: friction falls with speed in between."""
    curve = next(c for c in moving.curves if c.kind == "steady" and c.direction == "extend")
    points = [
        replace(curve.points[0], v_m_s=v, friction_n=n, ci95_n=4.0)
        for v, n in ((0.002, 502.0), (0.02, 443.0))
    ]
    series = replace(SERIES, f_load_n=curve.f_load_n, p_lr_ref_pa=curve.p_lr_ref_pa)
    push = replace(PUSHES[0], series=series, breakaway_n=breakaway_n, v_m_s=v_m_s, ci95_n=5.0)
    results = replace(
        moving,
        curves=(replace(curve, points=tuple(points)),),
        motions=replace(moving.motions, breakaways=(push,)),
    )
    said = dict(creep_facts(results))
    assert list(said) == (["Breakaway below friction"] if explained else [])
    if explained:
        words = (
            "Extending, breakaway (482 N) is below the friction of steady runs at 2 mm/s (502 N)."
        )
        assert said["Breakaway below friction"].startswith(words)
        wide = replace(results.motions, breakaways=(replace(push, ci95_n=31.0),))
        ((title, within),) = creep_facts(replace(results, motions=wide))
        assert title == "Breakaway and friction"
        assert within == (
            "Extending, breakaway (482 N) and the friction at 2 mm/s (502 N) are equal within "
            "their trials."
        )


def test_no_title_runs_into_the_word_that_its_figure_is_simulated(moving):
    series = replace(SERIES, label="reversals at 150 mm/s of the last seal")
    loops = (replace(MOTIONS.loops[0], series=series),)
    moving = replace(moving, motions=replace(MOTIONS, loops=loops))
    seen = 0
    for kind in FIGURES:
        with rc_context(RC):
            for figure in kind.draw(moving).values() if kind.applies(moving) else ():
                renderer = FigureCanvasAgg(figure).get_renderer()
                figure.draw(renderer)
                axes = figure.axes[0]
                left, right = axes._left_title, axes._right_title  # no public way to their boxes
                seen += bool(right.get_text())
                boxes = (text.get_window_extent(renderer) for text in (left, right))
                assert not next(boxes).overlaps(next(boxes)), left.get_text()
    assert seen > 8


def test_the_hysteresis_counts_the_runs_and_not_their_means(moving):
    loops = (replace(MOTIONS.loops[0], trials=8, unit="trial"),)
    page = page_of(replace(moving, motions=replace(MOTIONS, loops=loops)))
    assert "8 triangle runs with 176 J of friction work a cycle" in ordinary_spaces(page)
    assert "1 triangle run with 176 J" in ordinary_spaces(page_of(moving))


def page_of(results):
    """The page with a blank in the place of each kind of figure."""
    kinds = [kind for kind in FIGURES if kind.applies(results)]
    return page_html(
        results, [Drawing(k.name, k.section, k.name, k.caption, BLANK, b"") for k in kinds]
    )


def rows(name, results):
    return list(csv.DictReader(io.StringIO(MOTION_TABLES[name](results))))


def test_every_csv_has_the_records_in_si(moving):
    made = {name: rows(name, moving) for name in MOTION_TABLES}
    counts = {name: len(found) for name, found in made.items()}
    assert counts == {
        "comparisons.csv": 3,
        "loops.csv": 2,
        "loop_traces.csv": 60,
        "levels.csv": 2,
        "leakage.csv": 3,
        "decays.csv": 1,
        "decay_traces.csv": 2,
        "breakaways.csv": 2,
        "dwell_laws.csv": 1,
        "zeros.csv": 1,
        "surface.csv": 9,
        "over_distance.csv": 5,
    }
    assert (
        made["breakaways.csv"][0]["ci95_n"] == "12.0" and made["breakaways.csv"][1]["u95_n"] == ""
    )
    assert (
        made["breakaways.csv"][0]["runs"] == "0007 0008"
        and made["zeros.csv"][0]["error"] == "1000.0"
    )
    assert made["comparisons.csv"][0]["a_m_s2"] == "0.03 0.1"
    assert float(made["loops.csv"][0]["width_n"]) == -17.6
    assert made["loops.csv"][1]["ci95_n"] == "" and made["loops.csv"][1]["label"] == "seal A"
    assert made["levels.csv"][0]["before_n"] == ""
    assert made["leakage.csv"][2]["value_m3_s_pa"] == ""
    assert float(made["surface.csv"][8]["friction_n"]) == 600.0
    assert float(made["surface.csv"][8]["f_load_n"]) == 5000.0


def test_tables_without_rows_are_not_written(small, moving):
    assert motion_tables(small) == {}
    assert motion_tables(moving).keys() == MOTION_TABLES.keys()


def test_beside_ramps_steady_rows_say_so_and_alone_they_have_no_kind(small, moving):
    table = point_table(moving)
    kinds = [row[table.head.index("Kind")].text for row in table.rows]
    assert set(kinds) == {"steady", "ramp 0.03 m/s²", "ramp 0.1 m/s²"}
    assert "Kind" not in point_table(small).head


def test_remarks_on_fits_are_folded(small):
    def page_with(messages):
        fit = next(curve.fits[0] for curve in small.curves if curve.fits)
        told = [replace(fit, law="tustin", message=message) for message in messages]
        curves = (replace(small.curves[0], fits=tuple(told)),)
        return page_of(replace(small, curves=curves, joint_fits=()))

    folded = page_with([f"remark {i}" for i in range(13)])
    lid = r'<details class="lid">\n<summary><h2 id="fit-remarks">'
    assert re.search(lid + r"(?:.*[Rr]emark \d){13}", folded, re.DOTALL)
    assert re.search(lid + r".*Alone\.", page_with(["alone"]), re.DOTALL)


def test_results_json_has_them_with_the_series_keys_of_curves(moving, schema_faults):
    document = json.loads(results_json(moving))
    assert not schema_faults(document)
    assert {"kind", "label", "f_load_n", "p_lr_ref_pa"} <= document["comparisons"][0].keys()
    assert document["loops"][0]["widths"][0]["board_n"] == -17.2
    assert document["leakage"][0]["coefficients"][2]["value"] is None
    assert document["leakage"][0]["decays"][0]["f_load_n"] == 500.0
    assert document["surfaces"][0]["friction_n"][2] == [450.0, 440.0, 600.0]
    assert document["levels"][1]["overshoot_n"] == 65.8
    assert [c["a_ref_m_s2"] for c in document["curves"] if c["kind"] == "ramp"][:2] == [0.03, 0.1]


@pytest.mark.usefixtures("wide_terminal")
def test_the_summary_has_lines_for_each_kind_in_plain_ascii(moving):
    text = summary_text(moving)
    assert text.isascii()
    for numbers in (
        r"acceleration: 1 of 2 .*\+12\.0 N, p 0\.0040 \(seal A, 500 N, extend, 10 to 90 mm/s\)",
        r"steady: 0 of 1 ",
        r" 175\.90 \+- 0\.27 J\b.*\b2 cycles\b.*\b1 trial\b",
        r"steps: 2 .*\b65\.8 N, .*\b0\.3 s\b",
        r"leakage \(1 .* piston: 3\.60 \+- 0\.27 ml/min at 15\.0 bar$",
        r" piston side outwards: 0\.03 \+- 0\.57 ml/min at 45\.0 bar, .*\b0\b",
        r" rod side outwards: \D*$",
        r"\(extend\): 3 loads 500 to 5000 N, 3 speeds",
        r"over 5\.0 m \(seal A, 500 N, .* 150 mm/s\): settled, 404 N and -9\.7 \+- 6\.6 N",
        r"ramp 0\.1 m/s\^2 extend",
    ):
        assert re.search(numbers, text, re.MULTILINE), numbers


@pytest.mark.usefixtures("wide_terminal")
def test_an_overshoot_that_the_log_does_not_resolve_is_marked_and_not_in_the_summary(moving):
    hidden = replace(
        MOTIONS.levels[1], resolved=False, settling_step_s=0.01, overshoot_ci95_n=7.5, remark="why"
    )
    results = replace(moving, motions=replace(MOTIONS, levels=(hidden,)))
    text = summary_text(results)
    assert "65.8" not in text and "1 overshoots" in text
    assert re.search(r"\b0\.3 s\b.*\b0\.01 s\b", text)
    page = ordinary_spaces(page_of(results))
    assert "not resolved" in page and "65.8 ± 7.5" in page and "why" in page


def test_untested_comparisons_say_why(small):
    untested = replace(MOTIONS, comparisons=(comparison("acceleration", 3.0, None, None),))
    text = summary_text(replace(small, motions=untested))
    assert untested.comparisons[0].message in text


def test_ramps_stand_on_one_figure_with_the_steady_points_of_their_load(moving):
    figures = ramps.ramps(moving)
    assert len(figures) == 4
    axes = figures["Extending-500 N"].axes[0]
    drawn = {bars.get_label(): bars.lines[0].get_data() for bars in axes.containers}
    assert list(drawn) == ["steady", "ramp 0.03 m/s²", "ramp 0.1 m/s²"]
    steady = next(c for c in moving.curves if (c.direction, c.f_load_n) == ("extend", 500.0))
    assert drawn["steady"][0] == pytest.approx([1e3 * p.v_m_s for p in steady.points])
    assert drawn["ramp 0.1 m/s²"][1] == pytest.approx([p.friction_n for p in steady.points])
    back = ramps.ramps(moving)["Retracting-−500 N"].axes[0].containers[0]
    assert (back.lines[0].get_ydata() > 0).all()


def test_a_label_keeps_its_capitals_in_the_titles_of_ramps_and_maps(moving):
    labelled = replace(moving, curves=tuple(replace(c, label="NBR") for c in moving.curves))
    maps = tuple(replace(each, label="NBR") for each in moving.motions.surfaces)
    labelled = replace(labelled, motions=replace(labelled.motions, surfaces=maps))
    for figure in (*ramps.ramps(labelled).values(), *motions.surfaces(labelled).values()):
        title = figure.axes[0].get_title() or figure.axes[0].get_title("left")
        assert re.search(r"(Ramps|Friction map), NBR, (extending|retracting)", title)


def test_a_fit_of_a_ramp_that_is_not_determined_is_grey_and_dashed_and_none_is_no_line(moving):
    ramp = next(c for c in moving.curves if c.kind == "ramp" and c.direction == "extend")
    (fit, *_) = ramp.fits
    unknown = {n: replace(p, se=None, ci95=None, at_bound=None) for n, p in fit.parameters.items()}
    name = next(iter(unknown))
    partly = replace(fit, parameters={**fit.parameters, name: unknown[name]})
    looks = []
    for each in (partly, replace(fit, parameters=unknown)):
        curves = (replace(ramp, fits=(each,)),)
        (figure,) = ramps.ramps(replace(moving, curves=curves)).values()
        lines = [
            line for line in figure.axes[0].lines if str(line.get_label()).startswith("_tustin")
        ]
        drawn = [(line.get_linestyle(), line.get_color() != QUIET) for line in lines]
        words = ordinary_spaces(figure.get_supxlabel())
        looks.append((drawn, "Dashed: a fit" in words, "No line" in words))
    assert looks == [([("--", True)], True, False), ([], False, True)]


def test_differences_that_stand_are_filled_and_others_hollow(moving):
    axes = ramps.comparisons(moving)["acceleration"].axes[0]
    faces = [bars.lines[0].get_markerfacecolor() for bars in axes.containers]
    effects = [bars.lines[0].get_xdata()[0] for bars in axes.containers]
    assert effects == [12.0, -2.0] and faces[0] != "white" and faces[1] == "white"


def test_the_surface_shows_the_measured_points_and_the_loop_its_trace(moving):
    (surface,) = motions.surfaces(moving).values()
    x, y = surface.axes[0].lines[0].get_data()
    assert sorted(set(x)) == pytest.approx([10.0, 50.0, 200.0]) and set(y) == {0.5, 1.0, 5.0}
    (loop,) = motions.loops(moving).values()
    rising, falling = (line.get_ydata() for line in loop.axes[0].lines[:2])
    assert (np.isnan(rising) ^ np.isnan(falling)).all()


def test_the_page_has_a_section_for_each_and_a_bare_campaign_has_none(moving, small):
    page = page_of(moving)
    for word in ("ramps", "hysteresis", "steps", "leakage"):
        assert f'<h2 id="{word}">' in page and f'href="#{word}"' in page
    assert "differs" in page and "not determined" in page and "bulk modulus" in page
    bare = page_of(small)
    assert not any(f'<h2 id="{word}">' in bare for word in ("ramps", "hysteresis", "leakage"))


def test_a_campaign_without_steady_runs_shows_what_it_has(moving):
    ramps = tuple(curve for curve in moving.curves if curve.kind == "ramp")
    only = replace(moving, curves=ramps, efficiency=(), bands=())
    page = page_of(only)
    assert '<h2 id="ramps">' in page and '<h2 id="friction">' in page
    nothing = replace(only, curves=())
    assert summary_text(nothing).partition("\n\n")[2].startswith("ramps' acceleration")


def test_the_oil_over_time_is_a_line_for_each_side_at_its_highest_pressure(moving):
    (leak,) = moving.motions.leakages
    (hold,) = leak.decays
    again = replace(hold, run="0004", trace=tuple((t, 3 * p, r) for t, p, r in hold.trace))
    low = replace(hold, run="0005", series=replace(SERIES, f_load_n=0.0), p_p_pa=1e5, p_r_pa=1e5)
    leaks = (replace(leak, decays=(hold, again, low)),)
    results = replace(moving, motions=replace(moving.motions, leakages=leaks))
    (figure,) = motions.leakage(results).values()
    _, volumes = figure.axes[:2]
    piston, rod = (line.get_ydata() for line in volumes.lines[:2])
    t, lost_p, lost_r = np.array(hold.trace).T
    assert piston == pytest.approx(2e6 * lost_p) and rod == pytest.approx(1e6 * lost_r)
    assert len(volumes.lines) == 3  # with that at 0


def test_a_report_of_breakaway_alone_explains_what_it_has_and_nothing_else(small):
    motions = replace(MOTIONS, breakaways=PUSHES, zero_checks=(CHECKED,))
    none = replace(small, curves=(), joint_fits=(), efficiency=(), bands=(), motions=motions)
    sections = {each.title: each for each in report_document(none, ()).sections}
    assert "Uncertainty of friction" not in sections, "there is no table of its parts"
    assert sections["Zeros of the sensors"].tables[0].rows
    methods = dict(sections["How each number was computed"].facts)
    assert "averaged over its noise" in methods["Breakaway"] and "Friction" not in methods
    assert "Breakaway ± U (N)" in sections["Breakaway"].tables[0].head
    apart = tuple(replace(push, dwell_s=1.0 + i) for i, push in enumerate(PUSHES))
    over_time = replace(none, motions=replace(motions, breakaways=apart))
    (legend,) = breakaways(over_time)[""].legends
    names = [text.get_text() for text in legend.get_texts()]
    assert names and all(name.endswith(", extending") for name in names)
    pushes = tuple(replace(push, u95_n=None) for push in PUSHES)
    bare = replace(none, motions=replace(motions, breakaways=pushes))
    breakaway = next(s for s in report_document(bare, ()).sections if s.title == "Breakaway")
    assert "Breakaway ± trials (N)" in breakaway.tables[0].head


def test_single_holds_are_not_written_finer_than_u_of_the_leaks(moving):
    (leakage,) = moving.motions.leakages
    (decay, *_) = leakage.decays
    tiny = replace(decay, out_p_m3_s=1e-12, out_r_m3_s=-2e-12)  # 0.00006 and -0.00012 ml/min
    held = replace(leakage, decays=(tiny,))
    table = hold_table(replace(moving, motions=replace(moving.motions, leakages=(held,))))
    flows = [held.flow_m3_s(each, held.highest_pa(each.name)) for each in held.coefficients]
    halves = [60e6 * flow[1] for flow in flows if flow is not None]
    shown = [cell.text for cell in table.rows[0][-3:]]
    assert min(halves) > 0.001
    assert all(len(text.partition(".")[2]) <= 3 for text in shown), shown
    drawings = [Drawing("leakage", "leakage", "Leakage", "", BLANK, b"")]
    page = ordinary_spaces(page_html(moving, drawings))
    assert re.search(r"in each hold, without U\. Table \d+ has the leaks with U\.", page)
