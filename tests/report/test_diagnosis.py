"""A diagnosis in words, as JSON, on its page and as files, from runs of the virtual rig."""

import csv
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgb

from hbench import workflow
from hbench.config.bench import parse_plant
from hbench.config.files.loading import read_yaml
from hbench.config.schedule import parse_schedule
from hbench.model.effects.catalogue import read_effects
from hbench.reconcile.diagnosis_fields import ModelledData, insufficient_data_diagnosis
from hbench.reconcile.measured.balances import BALANCE_UNITS
from hbench.reconcile.measured.window_signals import SIGNALS
from hbench.records import (
    BeforeAfter,
    Candidate,
    Diagnosis,
    FitParameter,
    HeldOutLoad,
    Provenance,
    Region,
    Rival,
)
from hbench.report.diagnosis import names as words
from hbench.report.diagnosis.diagnosis_document import diagnosis_json
from hbench.report.diagnosis.figures.all_figures import draw_diagnosis
from hbench.report.diagnosis.figures.colour_scales import GAPS, RESIDUALS
from hbench.report.diagnosis.figures.gap_figures import (
    gap_figures,
    loads_figure,
    ranking_figure,
    region_figure,
)
from hbench.report.diagnosis.figures.overlay_figures import overlay_figures
from hbench.report.diagnosis.figures.residual_figures import maps_figure, shape_figure
from hbench.report.diagnosis.page import diagnosis_page
from hbench.report.diagnosis.revised_yaml import revised_yaml, schedule_yaml
from hbench.report.diagnosis.sentences import ruled_out_words
from hbench.report.diagnosis.tables.effect_tables import effects_table
from hbench.report.diagnosis.tables.gap_tables import edges_table
from hbench.report.diagnosis.tables.run_gaps import run_gaps_csv, run_table
from hbench.report.diagnosis.terminal import diagnosis_text
from hbench.report.diagnosis.text import diagnosis_tables, gap_line
from hbench.report.diagnosis.verdict import verdict_words
from hbench.report.render import style
from hbench.report.render.document import BANNERS
from hbench.report.render.figures import as_svg
from hbench.units import parse_unit
from tests.support.reconcile import made_diagnosis as made
from tests.support.report.spaces import ordinary_spaces


@pytest.fixture(scope="module")
def named():
    return made.named()


@pytest.fixture(scope="module")
def unknown():
    return made.unknown()


@pytest.fixture(scope="module")
def ambiguous():
    return made.ambiguous()


def test_the_terminal_gets_the_verdict_first_with_the_coefficient_in_the_benchs_unit(named):
    text = diagnosis_text(named)
    first, lead, *_ = text.splitlines()
    assert first == "Internal leakage found: made <up> (simulated, verdict: named)"
    assert lead.startswith("Internal leakage is found, which the model does not contain: ")
    assert "(test cylinder 0.00580 (0.00560 to 0.00610) l/min/bar" in " ".join(text.split())
    assert text.isascii()


@pytest.mark.usefixtures("wide_terminal")
def test_the_terminal_tells_the_gap_the_candidates_and_what_is_missing(named, unknown, ambiguous):
    text = diagnosis_text(named)
    assert "Gap of runs outside the fit" not in text  # the verdict has it
    total = unknown.gap_heldout.total
    before, refitted = map(words.gap_number, (total.before, total.refitted))
    assert re.search(rf": {before} [^,]*, {refitted} ", " ".join(diagnosis_text(unknown).split()))
    assert "584.6" not in text  # the candidates of an effect that is named are on the page
    (best, *_) = unknown.ranking
    row = f"{words.in_words(best.name)} +{best.score:.1f} +{best.threshold:.1f} "
    assert re.search(row, diagnosis_text(unknown))
    (left_out,) = [line for line in text.splitlines() if "presliding" in line]
    assert named.not_tried["presliding"] in left_out
    assert "0007 (steady): speed" in text
    text = diagnosis_text(ambiguous)
    assert text.startswith("Internal leakage or external leakage, not distinguishable: ")
    assert ambiguous.next_experiment in " ".join(text.split())
    assert ambiguous.missing[0] in text


def test_the_first_paragraph_of_a_named_effect_says_how_sure_it_is(named):
    sure = "The data favour it over the next best explanation, external leakage, by odds of more"
    assert sure in verdict_words(named)
    (effect,) = named.effects
    alone = replace(effect, runner_up=None)
    assert "The data favour it" not in verdict_words(replace(named, effects=(alone,)))


def test_a_candidate_as_good_as_the_named_effect_has_the_reason_why_it_is_not_named(named):
    (effect, *_) = named.effects
    mine = Candidate(effect.name, effect.score, 1.0, 1.5, {}, "full", threshold=5.0)
    tolerated = replace(mine, name="pressure_gain", size=0.0)
    worse = replace(tolerated, name="pressure_offset", score=effect.score - 10)
    found = ruled_out_words(replace(named, ranking=(mine, tolerated, worse)))
    assert found == (
        "Pressure gain would explain 100 % of the gap too, but is not named: none of its "
        "coefficients alone is beyond its tolerance."
    )


def test_the_score_of_the_next_best_effect_is_that_of_the_candidates(named):
    """41.86 and 25.14 are 16.72 apart, and printed as 41.9 and 25.1 they seem 16.8 apart."""
    effect = replace(named.effects[0], score=41.86, runner_up=Rival("load_cell_offset", 16.72))
    table = effects_table(replace(named, effects=(effect,)))
    assert table.rows[0][-2:] == ("41.9", "load_cell_offset, 25.1")


@pytest.mark.usefixtures("wide_terminal")
def test_a_coefficient_at_its_bound_is_left_to_the_table(named):
    (effect,) = named.effects
    at_bound = FitParameter(0.0, 1e-6, (0.0, 8e-6), "lower", "l/min/bar")
    both = replace(effect, parameters=effect.parameters | {"load": at_bound})
    text = diagnosis_text(replace(named, effects=(both,)))
    assert "load cylinder" not in text.partition("\n\n")[0]
    assert re.search(r"load +.* l/min/bar \(.* lower ", text)


def test_every_verdict_has_its_sentence(named, unknown, ambiguous):
    assert diagnosis_text(unknown).startswith("Unknown deviation: ")
    nothing = replace(unknown, verdict="none", rest=())
    assert diagnosis_text(nothing).startswith("No missing effect found: ")
    both = diagnosis_text(replace(named, alternatives=ambiguous.alternatives))
    assert "internal leakage or external leakage" in " ".join(both.split()).lower()
    rest = replace(named, rest=named.where[:1])
    assert words.balance(named.where[0].name).title in diagnosis_text(rest)


def test_json_has_the_names_that_other_programs_read(named, ambiguous):
    found = json.loads(diagnosis_json(named))
    assert found["schema"] == "hbench.diagnosis/1"
    assert found["verdict"] == "named"
    assert [set(one) >= {"balance", "score", "p_value"} for one in found["where"]] == [True] * 8
    scores = [one["score"] for one in found["where"]]
    assert scores == sorted(scores, reverse=True)
    (effect,) = found["effects"]
    assert effect["name"] == "internal_leakage"
    test = effect["parameters"]["test"]
    assert (test["value"], test["se"], test["ci95"]) == (0.0058, 1e-4, [0.0056, 0.0061])
    assert test["unit"] == "l/min/bar"
    assert effect["gap_before"] > effect["gap_after"] > 0
    assert effect["runner_up"] == {"name": "external_leakage", "margin": 231.0}
    for part in ("heldout", "train"):
        assert set(found["gap"][part]) >= {"before", "after", "floor", "signals"}
        for signal in found["gap"][part]["signals"].values():
            assert set(signal) >= {"before", "after", "floor"}
    assert (found["alternatives"], found["next_experiment"]) == ([], None)
    found = json.loads(diagnosis_json(ambiguous))
    assert [one["name"] for one in found["alternatives"]] == [
        "internal_leakage",
        "external_leakage",
    ]
    assert found["alternatives"][0]["score"] == 812.0
    assert found["next_experiment"].startswith("Hold")


def test_a_number_that_does_not_exist_is_null(named):
    unseen = replace(named.regions[0], gaps={"flow_tp": float("nan")})
    parameter = {"test": FitParameter(float("nan"), None, None, None, "l/min/bar")}
    effect = replace(named.effects[0], parameters=parameter, runner_up=None)
    text = diagnosis_json(replace(named, regions=(unseen,), effects=(effect,)))
    assert "NaN" not in text
    found = json.loads(text)
    assert found["regions"][0]["gaps"]["flow_tp"] is None
    assert found["effects"][0]["runner_up"] is None


def test_too_little_data_gets_a_page_that_says_what_is_missing(unknown):
    few = Diagnosis(
        provenance=unknown.provenance,
        model=unknown.model,
        verdict="unknown",
        why=unknown.why,
        missing=("load 2",),
    )
    text = diagnosis_text(few)
    assert text.startswith("Too few data for a verdict: ")
    assert "load 2" in text and gap_line(unknown) and gap_line(few) == ""
    assert draw_diagnosis(few) == ()
    page = diagnosis_page(few, ())
    assert "load 2" in page and "<table" not in page and "<h2>Gap" not in page
    assert json.loads(diagnosis_json(few))["gap"]["heldout"]["before"] is None
    assert "nan" not in revised_yaml(few)


def test_balances_and_signals_of_the_report_are_those_of_reconcile_with_units_of_their_kind():
    assert list(words.BALANCE_NAMES) == list(BALANCE_UNITS)
    for name, unit in BALANCE_UNITS.items():
        assert parse_unit(words.BALANCE_NAMES[name].unit).dimension == parse_unit(unit).dimension
    assert set(words.SIGNAL_NAMES) == set(SIGNALS)


def test_a_chambers_edges_are_told_by_the_direction(named):
    """Extending, oil comes from the supply into Tp and goes from Tr to the tank (2.15)."""
    ways = {one.label: one.gaps for one in named.regions if one.axis == "direction"}
    rows = {chamber: cells for chamber, *cells in edges_table(named).rows}
    tp, tr = (rows[words.balance(name).title] for name in ("flow_tp", "flow_tr"))
    assert tp == [words.gap_number(ways[way]["flow_tp"]) for way in ("extend", "retract")]
    assert tr == [words.gap_number(ways[way]["flow_tr"]) for way in ("retract", "extend")]
    assert (words.gap_number(9.274), words.gap_number(24.42)) == ("9.27", "24.4")


@pytest.fixture(scope="module")
def drawings():
    return made.drawings_of_named()


def test_the_page_escapes_everything_and_holds_every_figure(named, drawings):
    page = diagnosis_page(named, drawings)
    assert "made &lt;up&gt;" in page and "<up>" not in page
    assert page.count('class="plot"') == len(drawings) == len({one.name for one in drawings})
    assert page.count('class="wide"') == sum(one.wide for one in drawings)
    assert BANNERS["simulated"] in page
    verdict = (
        r'class="verdict">Internal leakage is found, which the model does not contain: oil leaks '
        r"[^<]*0\.00580"
    )
    assert re.search(verdict, page)
    for table in diagnosis_tables(named):
        numbers = [cell for cell in table.rows[0] if re.fullmatch(r"[\d.]+", cell)]
        assert all(f">{cell}</td>" in page for cell in numbers)
    assert page.index('<h2 id="gap-between') < page.index("Residuals of each quantity")


def test_a_closed_loop_is_told_only_where_signals_were_simulated(named):
    gaps = replace(named.gap_heldout, signals={}, open_loop={})
    assert "simulated in closed loop" in diagnosis_page(named, ())
    assert "simulated in closed loop" not in diagnosis_page(replace(named, gap_heldout=gaps), ())


def test_an_unknown_disagreement_is_shown_by_place_and_then_against_velocity_position_and_load(
    unknown, undrawn
):
    drawings = draw_diagnosis(replace(unknown, overlays=(), ranking=(), refitted={}))
    page = diagnosis_page(unknown, drawings)
    assert (
        page.index('<h2 id="where')
        < page.index("<h3>Shape of the residuals")
        < page.index('<h2 id="gap-between')
    )
    assert [d.name for d in drawings if d.section == "shape"] == ["shape-flow-tr", "shape-flow-tp"]
    panels = shape_figure(unknown, "flow_tp").axes[:4]
    units = ["mm/s", "mm", "s", "kN"]
    assert [axes.get_xlabel().partition(" (")[2] for axes in panels] == [f"{u})" for u in units]


def test_pairs_of_strokes_are_drawn_by_themselves_and_without_a_position(named):
    """A pair has no direction of its own, and its load is the only held-out one.

    Its residuals are in newtons: one load may repeat much better than the others.
    """
    side = named.residuals_before
    nowhere = np.full_like(side.x_m, np.nan)
    names = "force_middle", *side.names[1:]
    maps = {
        key: replace(getattr(named, key), x_m=nowhere, names=names, unit="N")
        for key in ("residuals_before", "residuals_after")
    }
    gap = replace(named.where[0], name="force_middle")
    strokes = replace(named, where=(gap,), **maps)
    figure = shape_figure(strokes, "force_middle")
    assert {axes.get_ylabel() for axes in figure.axes[:4] if axes.get_ylabel()} == {
        "Residual before\n(N)", "Residual after\n(N)"
    }  # fmt: skip
    assert not any("scatter" in axes.get_title(loc="right") for axes in figure.axes)
    scatters = shape_figure(named, named.where[0].name)
    assert any("repeatability 0" in axes.get_title(loc="right") for axes in scatters.axes)
    labels = [axes.get_xlabel() for axes in figure.axes]
    below = [label for label in labels if label and not label.startswith("Colour")]
    assert below == ["Load (kN)", "Time in the run (s)", "Velocity (mm/s)"]
    lines = [line.get_label() for axes in figure.axes for line in axes.lines]
    assert not [label for label in lines if "medians" in label]
    grey, coloured = figure.axes[0].collections
    assert len(coloured.get_offsets()) == len(side.x_m) and not len(grey.get_offsets())


def test_strokes_have_a_figure_of_force_errors_by_load_in_place_of_gaps_and_regions(named, undrawn):
    """A region of them is a single load, and a gap in scatters hides the newtons."""
    also = {"load_cell_gain": 0.4}
    loads = tuple(
        HeldOutLoad(load, 3.0, 4.0, 1.5, also, {"force_middle": 0.1}) for load in (50.0, 150.0)
    )
    gap = replace(named.where[0], name="force_middle")
    side = replace(
        named.residuals_before, names=("force_middle", *named.residuals_before.names[1:])
    )
    strokes = replace(
        named, where=(gap,), held_out_loads=loads, residuals_before=side, residuals_after=side,
        ranking=(), refitted={}, overlays=(),
    )  # fmt: skip
    assert [each.name for each in draw_diagnosis(strokes)] == ["shape-force-middle", "loads"]
    (axes,) = loads_figure(strokes).axes
    drawn = {line.get_label(): list(line.get_xdata()) for line in axes.lines}
    assert drawn == {
        "as given": [3.0, 3.0],
        "refitted": [4.0, 4.0],
        "with the effects": [1.5, 1.5],
        "with the effects and load cell gain": [0.4, 0.4],
    }
    assert axes.get_xlabel() == "Force error (N)" and axes.get_xlim()[0] == 0


def test_gaps_ranking_and_regions_are_drawn_as_they_are(named):
    axes = gap_figures(named)["Flows and forces"].axes[0]
    drawn = {line.get_label(): line.get_xdata() for line in axes.lines}
    table = named.gap_heldout
    for step in ("before", "after"):
        assert drawn[words.STEPS[step]][0] == getattr(table.total, step)
    bars = ranking_figure(named).axes[0]
    assert [bar.get_width() for bar in bars.patches] == [one.score for one in named.ranking]
    panels = region_figure(named).axes[:10]
    sides = ((panels[0], named.regions), (panels[5], named.regions_after))
    for axes, regions in sides:
        assert axes.texts[0].get_text() == f"{regions[0].gaps[named.where[0].name]:.1f}"
        assert axes.images[0].get_clim() == panels[0].images[0].get_clim()


def test_a_narrow_region_has_bounds_of_more_digits_and_a_single_value_is_one_number(named):
    ends = {(50.0, 50.0): "0.0500", (145.0, 149.0): "0.145\nto\n0.149", (-500.0, 600.0): None}
    regions = tuple(
        Region("load_n", "", low, high, 9, dict(named.regions[0].gaps)) for low, high in ends
    )
    both = replace(named, regions=regions, regions_after=regions)
    labels = region_figure(both).axes[1].get_xticklabels()  # of the lower table, for both
    texts = [label.get_text() for label in labels]
    assert texts == [*list(ends.values())[:2], "−0.5\nto\n0.6"]


def _contrast(one, other):
    """Return the contrast of two colours after WCAG 2.1: 1 is none, 4.5 that of small text."""
    parts = np.array([to_rgb(one), to_rgb(other)])
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    low, high = sorted(linear @ (0.2126, 0.7152, 0.0722))
    return (high + 0.05) / (low + 0.05)


def _over(colour, page):
    """Return a colour that is partly transparent as it is seen on a page."""
    *solid, alpha = colour
    return tuple(alpha * np.array(solid) + (1 - alpha) * np.array(to_rgb(page)))


@pytest.mark.parametrize("page", ["#ffffff", style.DARK["#ffffff"]])
def test_small_gaps_fade_into_a_light_or_dark_page_and_numbers_in_all_cells_are_legible(
    named, page
):
    dark = page != "#ffffff"
    for axes in region_figure(named).axes[:10]:
        (image,) = axes.images
        cells = image.to_rgba(image.get_array()).reshape(-1, 4)
        for text, cell in zip(axes.texts, cells, strict=True):
            ink = to_hex(text.get_color())
            ink = style.DARK[ink] if dark else ink
            assert _contrast(ink, _over(cell, page)) > 4
    assert _contrast(page, _over(GAPS(0.0), page)) < 1.01 < 3 < _contrast(page, GAPS(1.0)[:3])
    assert _contrast(page, _over(RESIDUALS(0.5), page)) < 1.02
    for end in (0.0, 1.0):
        assert _contrast(page, RESIDUALS(end)[:3]) > 3


def test_overlays_are_shown_in_the_benchs_units_with_what_they_are_off(named):
    run = named.overlays[0].run
    axes = overlay_figures(named)[run].axes
    pressure = next(one for one in named.overlays if (one.run, one.signal) == (run, "p_tp"))
    row = [one.signal for one in named.overlays if one.run == run].index("p_tp")
    left, right = axes[2 * row : 2 * row + 2]
    np.testing.assert_allclose(left.lines[0].get_ydata(), pressure.measured / 1e5)
    off = (pressure.after - pressure.measured) / 1e5
    *_, samples, means = right.lines
    np.testing.assert_allclose(samples.get_ydata(), off)
    assert means.get_xdata()[0] == pytest.approx(pressure.t_s[:16].mean())  # 16 samples of 10 ms
    np.testing.assert_allclose(means.get_ydata()[:2], [off[:16].mean(), off[16:32].mean()])
    assert means.get_linewidth() > samples.get_linewidth()
    assert "(bar)" in left.get_ylabel()


def test_a_signal_that_hardly_changes_has_its_values_on_the_axis_and_no_offset(named):
    shown = next(each for each in named.overlays if each.signal == "p_tp")
    steady = replace(shown, measured=np.full_like(shown.measured, 149.8e5))
    steady = replace(steady, before=steady.measured - 400.0, after=steady.measured)
    figure = overlay_figures(replace(named, overlays=(steady,)))[shown.run]
    figure.canvas.draw()
    axis = figure.axes[0].yaxis
    assert not axis.get_offset_text().get_text()
    assert any("149.79" in label.get_text() for label in axis.get_ticklabels())


def test_a_signal_that_a_model_without_effects_reproduces_in_its_run_is_not_drawn(unknown, undrawn):
    shown = unknown.overlays[0]
    (gaps,) = (each for each in unknown.gap_runs if each.plan.run == shown.run)

    def drawn(gap):
        table = replace(
            gaps.gap, signals={**gaps.gap.signals, shown.signal: BeforeAfter(9.0, gap, gap, gap)}
        )
        found = replace(unknown, overlays=(shown,), gap_runs=(replace(gaps, gap=table),))
        return overlay_figures(found)

    assert not drawn(0.83)
    assert list(drawn(9.13)) == [shown.run]


def test_a_figure_of_a_held_out_run_says_what_the_run_was_and_why_it_is_shown(named, drawings):
    shown = [drawing for drawing in drawings if drawing.section == "overlay"]
    plans = {each.plan.run: each.plan for each in named.gap_runs}
    for drawing, run in zip(shown, dict.fromkeys(o.run for o in named.overlays), strict=True):
        speed = f"{1e3 * plans[run].v_ref_m_s:.0f} mm/s".replace("-", "−")
        assert drawing.title.startswith(f"Run {run}: ") and speed in drawing.title
        assert "What is added to the model reduces its gap there." in drawing.caption


def test_a_held_out_run_without_a_reduced_gap_does_not_claim_one(named, unknown, undrawn):
    def caption(diagnosis):
        drawings = draw_diagnosis(replace(diagnosis, where=(), ranking=(), refitted={}))
        (first, *_) = (drawing for drawing in drawings if drawing.section == "overlay")
        assert "reduces its gap" not in first.caption
        return first.caption

    largest = tuple(replace(each, shrank=False) for each in named.overlays[:1])
    assert "Each signal is shown in one run outside the fit." in caption(unknown)
    worse = caption(replace(named, overlays=largest))
    assert "What is added to the model reduces the gap of none." in worse


def test_figures_are_the_same_twice(named):
    assert as_svg(maps_figure(named)) == as_svg(maps_figure(named))


def test_the_revised_model_reads_back_and_says_where_its_numbers_come_from(named, tmp_path):
    revised = {
        "valve": {"gain": "7.27e-7 m^2/V"},
        "friction": {"test": {"law": "lugre", "viscous": "2400 N s/m"}},
        "effects": made.FOUND,
    }
    path = tmp_path / "model.yaml"
    path.write_text(revised_yaml(replace(named, revised=revised, why="Because:\n# it's so")))
    assert read_yaml(path) == revised
    plant = parse_plant(made.BENCH, read_yaml(path), "model")
    assert plant.valve.gain == 7.27e-7
    assert read_effects(plant.effects)["internal_leakage"]["test"] == pytest.approx(
        9.667e-13, rel=1e-3
    )
    text = path.read_text()
    assert "SIMULATED" in text and "made <up>" in text and "2026-01-01" in text
    line = next(line for line in text.splitlines() if "gain:" in line)
    assert "# refitted: " in line and line.endswith("0.9780 ± 0.0040")
    assert "0.00580 (0.00560 to 0.00610) l/min/bar" in text
    (effect,) = named.effects
    assert f"# {effect.description}; form: {effect.shape}" in text


def test_a_model_that_needs_no_revision_is_still_a_file_that_reads_back(unknown, tmp_path):
    whole = {key: made.BENCH[key] for key in ("valve", "oil", "supply", "friction")}
    path = tmp_path / "model.yaml"
    path.write_text(revised_yaml(replace(unknown, revised=whole)))
    assert read_yaml(path) == whole


def test_every_run_has_its_gaps_of_every_view_in_json_and_csv(named):
    """30 runs, 8 balances and 12 signals; 8 of these in open loop, for held-out runs."""
    runs = json.loads(diagnosis_json(named))["gap"]["runs"]
    assert [one["run"] for one in runs] == [one.plan.run for one in named.gap_runs]
    assert {one["run"] for one in runs if one["held_out"]} == set(named.heldout_runs)
    steady = next(one for one in runs if one["kind"] == "steady" and one["held_out"])
    assert (len(steady["balances"]), len(steady["signals"])) == (8, 12)
    assert {one["run"] for one in runs if one["open_loop"]} == set(named.heldout_runs)
    assert set(steady["open_loop"]) == {"x", "v", "p_tp", "p_tr", "p_lp", "p_lr", "f_applied"} | {
        "friction"
    }
    rows = list(csv.DictReader(run_gaps_csv(named).splitlines()))
    assert len(rows) == sum(
        1 + sum(len(one[part]) for part in ("balances", "signals", "open_loop")) for one in runs
    )
    row = next(row for row in rows if (row["run"], row["name"]) == (steady["run"], "flow_tp"))
    assert float(row["before"]) == steady["balances"]["flow_tp"]["before"]
    assert (row["of"], row["trial"], float(row["f_load_n"])) == ("balances", "1", 500.0)


def test_a_leak_stands_in_each_run_and_goes_with_the_effect(named):
    for one in named.gap_runs:
        flow = one.gap.balances["flow_tp"]
        assert flow.refitted > max(3, 5 * flow.after)
    heldout = [one.gap.balances["flow_tp"].refitted for one in named.gap_runs if one.held_out]
    together = named.gap_heldout.balances["flow_tp"].refitted
    assert min(heldout) < together < max(heldout)


def test_the_worst_runs_are_first_on_the_page_and_not_on_the_terminal(named, drawings):
    assert all(one.head[0] != "run" for one in diagnosis_tables(named))
    table = run_table(named, 8)
    assert "8 of 20)" in table.title
    gaps = [float(row[table.head.index(words.STEPS["after"])]) for row in table.rows]
    assert gaps == sorted(gaps, reverse=True) and len(gaps) == 8
    assert gaps[0] == pytest.approx(max(one.gap.total.after for one in named.gap_runs), abs=0.01)
    page = diagnosis_page(named, drawings)
    title = table.title.partition(" (")[0]
    assert re.search(rf"<h\d>{title}", page) and "gaps_by_run.csv" in page


def test_balances_and_signals_are_written_with_articles_within_a_sentence():
    said = [words.in_sentence(name) for name in ("flow_tp", "force_load", "f_applied", "p_tp")]
    assert said[0] == "the flow to the test piston side"
    assert said[1:] == ["the force of the load cylinder", "the load cell's force", "P_Tp"]


def test_the_law_of_an_effect_explains_its_coefficients(named):
    effect = replace(named.effects[0], law="Q = G (P_p - P_r)")
    page = diagnosis_page(replace(named, effects=(effect,)), ())
    assert "Law of internal leakage" in page and "Law of" not in diagnosis_page(named, ())


def test_a_refused_refit_has_its_reason_and_no_marks_of_its_own(named):
    assert "refitted" in words.steps_of(named)
    refused = replace(named, refit_refused="The refit is refused.")
    assert list(words.steps_of(refused)) == ["before", "after", "floor"]
    for figure in gap_figures(refused).values():
        assert words.STEPS["refitted"] not in {line.get_label() for line in figure.axes[0].lines}
    page = diagnosis_page(refused, ())
    first = page[: page.index("<h2", page.index("<h2") + 1)]
    assert "The refit is refused." not in first and "The refit is refused. " in page
    assert "refitted model" not in page
    assert "only if it reduces the gap of runs outside the fit, by whatever amount." in page
    assert "the model with the effects and values fitted with them" in page
    assert "The refit is refused." in diagnosis_text(refused)
    assert json.loads(diagnosis_json(refused))["refit_refused"] == refused.refit_refused
    assert json.loads(diagnosis_json(named))["refit_refused"] is None


def test_a_single_gap_has_no_figure(named):
    balances = dict(list(named.gap_heldout.balances.items())[:1])
    alone = replace(named, gap_heldout=replace(named.gap_heldout, balances=balances))
    assert "Flows and forces" in gap_figures(named) and "Flows and forces" not in gap_figures(alone)


def test_a_signal_that_the_effects_make_worse_is_named_with_the_gaps(named):
    worse = BeforeAfter(5.5, 5.4, 6.7, float("nan"))
    table = replace(named.gap_heldout, signals=named.gap_heldout.signals | {"v": worse})
    page = ordinary_spaces(diagnosis_page(replace(named, gap_heldout=table), ()))
    place = page.index("velocity in closed loop (5.40 to 6.70)")
    assert page.index('<h2 id="gap-between') < place < page.index('<h2 id="the-effects')
    better = replace(worse, after=5.5)
    table = replace(table, signals=table.signals | {"v": better})
    assert "velocity in closed loop" not in diagnosis_page(replace(named, gap_heldout=table), ())


def test_the_next_schedule_reads_back_as_a_schedule(ambiguous, tmp_path):
    path = tmp_path / "next.yaml"
    path.write_text(schedule_yaml(ambiguous))
    assert f"# {ambiguous.next_experiment}" in path.read_text()
    assert read_yaml(path) == ambiguous.next_schedule
    assert parse_schedule(read_yaml(path), "next").experiments[0].kind == "steady"


def test_the_folder_gets_page_numbers_figures_and_a_model(named, ambiguous, tmp_path, undrawn):
    for found, more in ((named, set()), (ambiguous, {"next.yaml"})):
        folder = tmp_path / found.verdict
        workflow.write_diagnosis(folder, replace(found, overlays=(), where=()))
        written = {path.name for path in folder.iterdir()}
        every = {"report.html", "diagnosis.json", "model.yaml", "gaps_by_run.csv", "figures"}
        assert written == every | more
        parse_plant(made.BENCH, read_yaml(folder / "model.yaml"), "model")
        assert json.loads((folder / "diagnosis.json").read_text())["verdict"] == found.verdict


@pytest.fixture
def quick():
    """Return a diagnosis without figures."""
    about = Provenance("made", "simulated", "bench", "sim", "2026-01-01T00:00:00", "")
    task = ModelledData(provenance=about, model="model.yaml", plant_data={})
    return insufficient_data_diagnosis(task, ("load 2",), ())


def test_a_diagnosis_leaves_nothing_of_an_earlier_one_in_its_folder(quick, tmp_path):
    """But what else lies there stays."""
    schedule = {"name": "next", "experiments": []}
    workflow.write_diagnosis(tmp_path, replace(quick, next_schedule=schedule))
    assert (tmp_path / "next.yaml").exists()
    (tmp_path / "figures").mkdir()
    for name in ("run-0007.svg", "run-0007.csv"):
        (tmp_path / "figures" / name).write_text("old")
    (tmp_path / "notes.txt").write_text("mine")
    workflow.write_diagnosis(tmp_path, quick)
    left = {path.name for path in tmp_path.rglob("*") if path.is_file()}
    assert left == {"report.html", "diagnosis.json", "model.yaml", "notes.txt"}


def test_a_schedule_that_no_diagnosis_left_stays(quick, tmp_path):
    (tmp_path / "next.yaml").write_text("mine")
    workflow.write_diagnosis(tmp_path, quick)
    assert (tmp_path / "next.yaml").read_text() == "mine"


def test_the_column_of_an_import_map_remains_the_key_that_is_to_be_written():
    text = "set f_applied_n to 0 N; valve_lag changes p_s and flow_tp"
    flow = words.balance("flow_tp").title
    expected = f"set f_applied_n to 0 N; valve lag changes supply pressure and {flow}"
    assert words.keys_in_words(text) == expected
