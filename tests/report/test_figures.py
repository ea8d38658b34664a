"""Figures: what is drawn, with which labels, and that the bytes don't change."""

import io
import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.image import imread

from hbench.report.campaign.figures import efficiency, friction, pressure
from hbench.report.campaign.figures.all_figures import FIGURES, draw_all
from hbench.report.render.style import COLOURS, QUIET, series_style
from tests.support.report.spaces import ordinary_spaces

UNIT = re.compile(r"\((mm/s|mm|k?N|%|bar|V|s|count)\)")


def every_figure(results):
    for kind in FIGURES:
        if kind.applies(results):
            yield from kind.draw(results).values()


def names(results):
    return [drawing.name for drawing in draw_all(results)]


def series(axes):
    """The error-bar series of an axes as {label: (x, y)}."""
    return {bars.get_label(): bars.lines[0].get_data() for bars in axes.containers if bars.lines[0]}


def test_each_campaign_gets_the_figures_that_apply(small, drawings, seals, undrawn):
    assert [drawing.name for drawing in drawings] == [
        "stribeck-extend",
        "stribeck-retract",
        "efficiency-extend",
        "efficiency-retract",
        "rejected-off-reference",
    ]
    assert names(seals) == ["friction-pressure"]
    bare = replace(small, runs=(), curves=(), efficiency=())
    assert names(bare) == []


@pytest.mark.parametrize("name", ["stribeck", "seals"])
def test_every_axis_says_what_it_shows_and_its_unit(name, request):
    for figure in every_figure(request.getfixturevalue(name)):
        lowest = [axes for axes in figure.axes if axes.get_label() != "<colorbar>"][-1]
        assert UNIT.search(lowest.get_xlabel())
        for axes in figure.axes:
            counts = axes.patches  # bars of named reasons have no vertical quantity
            assert counts or UNIT.search(axes.get_ylabel())
            assert axes.title.get_fontsize() >= 10


def test_stribeck_points_are_the_records_in_mm_s_and_newton_with_their_intervals(small):
    figure = friction.friction_magnitude(small)["retract"]
    axes, below = figure.axes
    drawn = series(axes)
    assert set(drawn) == {"−500 N", "−5000 N"}
    curve = next(c for c in small.curves if (c.direction, c.f_load_n) == ("retract", -5000.0))
    x, y = drawn["−5000 N"]
    assert x == pytest.approx([1000 * abs(point.v_m_s) for point in curve.points])
    assert y == pytest.approx([-point.friction_n for point in curve.points])
    bars = next(c for c in axes.containers if c.get_label() == "−5000 N").lines[2][0]
    heights = [np.ptp(segment[:, 1]) / 2 for segment in bars.get_segments()]
    assert heights == pytest.approx([point.ci95_n for point in curve.points])
    assert len(axes.lines) - 3 * 2 == 2  # two fitted lines besides points and caps
    assert len(below.containers) == 2


def test_friction_has_the_band_of_trials_and_instruments(small):
    """Beside the bars of the trials alone, which are much shorter."""

    def known(point):
        return replace(point, u95_n=200.0)

    curves = tuple(replace(c, points=tuple(map(known, c.points))) for c in small.curves)
    wide = replace(small, curves=curves)
    for direction, figure in friction.friction_magnitude(wide).items():
        drawn = [c for c in figure.axes[0].collections if isinstance(c, PolyCollection)]
        assert "U (95 %)" in figure.get_supxlabel()
        shown = friction.by_load(c for c in curves if c.direction == direction)
        for band, curve in zip(drawn, shown, strict=True):
            ends = band.get_paths()[0].vertices[:, 1]
            values = [abs(point.friction_n) for point in curve.points]
            assert (min(ends), max(ends)) == pytest.approx((min(values) - 200, max(values) + 200))
    without = friction.friction_magnitude(small)["extend"]
    assert not any(isinstance(c, PolyCollection) for c in without.axes[0].collections)
    assert "U (95 %)" not in without.get_supxlabel()


def test_the_fitted_line_stays_inside_the_measured_speeds(small):
    axes = friction.friction_magnitude(small)["extend"].axes[0]
    speeds = [1000 * abs(point.v_m_s) for point in small.curves[0].points]
    lines = [line for line in axes.lines if len(line.get_xdata()) > len(speeds)]
    assert len(lines) == 2
    for line in lines:
        assert min(speeds) - 1e-9 <= line.get_xdata().min()
        assert line.get_xdata().max() <= max(speeds) + 1e-9


@pytest.mark.parametrize("direction,sign", [("extend", 1), ("retract", -1)])
def test_residuals_are_measured_less_fitted(small, direction, sign):
    figure = friction.friction_magnitude(small)[direction]
    curve = next(c for c in small.curves if c.direction == direction and abs(c.f_load_n) == 500)
    line = dict(curve.fits[0].line)
    expected = [sign * (p.friction_n - line[p.v_m_s]) for p in curve.points]
    _, residual = figure.axes[1].containers[0].lines[0].get_data()
    assert residual == pytest.approx(expected)


def test_both_directions_share_their_limits(small):
    figures = friction.friction_magnitude(small)
    for panel in (0, 1):
        assert figures["extend"].axes[panel].get_ylim() == figures["retract"].axes[panel].get_ylim()
        assert figures["extend"].axes[panel].get_xlim() == figures["retract"].axes[panel].get_xlim()


def test_a_load_that_helps_is_hollow_and_one_that_opposes_is_filled(small):
    for f_load, direction, hollow in [
        (500.0, "extend", False),
        (-500.0, "extend", True),
        (-500.0, "retract", False),
        (500.0, "retract", True),
    ]:
        curve = replace(small.curves[0], f_load_n=f_load, direction=direction)
        ranks = friction.load_ranks([curve])
        face = friction.load_style(curve, ranks)["markerfacecolor"]
        assert (face == "white") is hollow


def test_curves_of_one_load_are_distinguished_by_their_rod_side_pressure(small, two_rod_sides):
    assert set(series(friction.friction_magnitude(small)["extend"].axes[0])) == {"500 N", "5000 N"}
    loads = {f"{load} N, {bar} bar" for load in (500, 5000) for bar in (15, 60)}
    for draw in (friction.friction_magnitude, efficiency.efficiency):
        figure = draw(two_rod_sides)["extend"]
        bars = figure.axes[0].containers
        assert {one.get_label() for one in bars} == loads
        assert len({one.lines[0].get_color() for one in bars}) == 4
        assert "rod-side" in figure.legends[0].get_title().get_text()


def test_legends_with_rod_side_pressures_stay_inside_the_figure(two_rod_sides, seals):
    curves = [replace(c, label=f"{c.label} 25.7 mm, another batch") for c in seals.curves]
    curves += [replace(c, p_lr_ref_pa=60e5) for c in curves]
    over_pressure = replace(seals, curves=tuple(curves), bands=())
    for figure in [*every_figure(two_rod_sides), *every_figure(over_pressure)]:
        figure.draw_without_rendering()
        for legend in figure.legends:
            box = legend.get_window_extent()
            assert box.x0 >= 0 and box.x1 <= figure.bbox.width


def test_a_rod_side_pressure_for_each_direction_needs_no_words(small):
    curves = tuple(
        replace(c, p_lr_ref_pa=60e5 if c.direction == "extend" else 15e5) for c in small.curves
    )
    axes = friction.friction_magnitude(replace(small, curves=curves))["extend"].axes[0]
    assert set(series(axes)) == {"500 N", "5000 N"}


def test_a_curve_without_fit_or_interval_is_drawn_without_a_residual_panel(small):
    curves = tuple(
        replace(c, fits=(), points=tuple(replace(p, ci95_n=None) for p in c.points))
        for c in small.curves
    )
    figures = friction.friction_magnitude(replace(small, curves=curves))
    assert [len(figure.axes) for figure in figures.values()] == [1, 1]


def test_a_fit_that_did_not_converge_is_dashed(small):
    fit = replace(small.curves[0].fits[0], converged=False)
    results = replace(small, curves=(replace(small.curves[0], fits=(fit,)),))
    axes = friction.friction_magnitude(results)["extend"].axes[0]
    assert "--" in {line.get_linestyle() for line in axes.lines}


def test_the_efficiency_band_is_the_expanded_uncertainty(small):
    axes = efficiency.efficiency(small)["extend"].axes[0]
    assert len(axes.collections) == 2 + 2  # a band and a set of bars for each load
    point = small.efficiency[0].points[0]
    corners = axes.collections[0].get_paths()[0].vertices
    at_first = corners[np.isclose(corners[:, 0], 1000 * point.v_m_s)][:, 1]
    assert at_first.min() == pytest.approx(100 * (point.efficiency - point.u95))
    assert at_first.max() == pytest.approx(100 * (point.efficiency + point.u95))
    low, high = axes.get_ylim()
    points = [p for curve in small.efficiency for p in curve.points if p.efficiency is not None]
    lowest = 100 * min(p.efficiency - (p.u95 or 0.0) for p in points)
    assert high == 100 and low % 10 == 0 and lowest - 20 < low <= lowest


def test_efficiencies_of_one_trial_each_are_not_called_means_with_bars(small):
    curve = small.efficiency[0]
    single = replace(curve, points=tuple(replace(p, ci95=None, u95=None) for p in curve.points))
    for curves, words in (
        (small.efficiency, "means of the trials; bars"),
        ((single,), "one trial"),
    ):
        figure = efficiency.efficiency(replace(small, efficiency=curves))["extend"]
        assert words in ordinary_spaces(figure.get_supxlabel())


def test_bands_are_named_only_where_two_neighbouring_speeds_have_them(small):
    def legend(curve):
        figures = friction.friction_magnitude(replace(small, curves=(curve,)))
        return figures[curve.direction].get_supxlabel()

    curve = small.curves[0]
    curve = replace(curve, points=tuple(replace(p, u95_n=50.0) for p in curve.points))
    first, *others = curve.points
    single = replace(curve, points=(first, *(replace(p, u95_n=None) for p in others)))
    assert "Bands: expanded uncertainty U" in ordinary_spaces(legend(curve))
    assert "Bands" not in legend(single)


def test_an_efficiency_that_does_not_exist_leaves_a_gap(small):
    curve = small.efficiency[0]
    missing = replace(curve.points[1], efficiency=None, sigma=None, sigma_trials=None, reason="low")
    results = replace(
        small, efficiency=(replace(curve, points=(curve.points[0], missing, *curve.points[2:])),)
    )
    _, y = efficiency.efficiency(results)["extend"].axes[0].containers[0].lines[0].get_data()
    assert np.isnan(y[1]) and np.isfinite(np.delete(y, 1)).all()


def test_the_half_band_is_drawn_from_the_bands_with_their_intervals(seals):
    _, below, _ = pressure.friction_pressure(seals)[""].axes
    bars = below.containers[0]
    oring = [band for band in seals.bands if band.label == "O-ring"]
    assert bars.lines[0].get_ydata() == pytest.approx([band.half_n for band in oring])
    heights = [np.ptp(segment[:, 1]) / 2 for segment in bars.lines[2][0].get_segments()]
    assert heights == pytest.approx([0.1, 0.3, 0.5, 0.7])


def test_pressure_series_are_distinguished_by_their_rod_side_pressure(seals):
    again = replace(
        seals,
        curves=seals.curves + tuple(replace(c, p_lr_ref_pa=60e5) for c in seals.curves),
        bands=seals.bands + tuple(replace(b, p_lr_ref_pa=60e5) for b in seals.bands),
    )
    axes, below, _ = pressure.friction_pressure(again)[""].axes
    assert len(axes.containers) == 8 and "NAPN, 60 bar, extending" in series(axes)
    assert [list(bars.lines[0].get_xdata()) for bars in below.containers] == [[1, 3, 5, 7]] * 4


def test_pressure_figure_shows_each_seal_and_direction_in_bar(seals):
    axes, below, _ = pressure.friction_pressure(seals)[""].axes
    drawn = series(axes)
    assert set(drawn) == {
        f"{seal}, {verb}" for seal in ("O-ring", "NAPN") for verb in ("extending", "retracting")
    }
    assert drawn["NAPN, retracting"][0] == pytest.approx([1, 3, 5, 7])
    assert [list(bars.lines[0].get_xdata()) for bars in below.containers] == [[1, 3, 5, 7]] * 2


def test_one_direction_alone_is_drawn_without_a_half_band(seals):
    curves = tuple(c for c in seals.curves if c.direction == "extend")
    alone = replace(seals, curves=curves, bands=(), band_trends=())
    axes, *below = pressure.friction_pressure(alone)[""].axes
    assert len(axes.containers) == 2 and not below


def test_two_speeds_at_each_pressure_are_two_series(seals):
    def with_fast(curve):
        (point,) = curve.points
        return replace(curve, points=(point, replace(point, v_m_s=4 * point.v_m_s)))

    fast = tuple(replace(band, v_m_s=4 * band.v_m_s) for band in seals.bands)
    both = replace(
        seals,
        curves=tuple(map(with_fast, seals.curves)),
        bands=seals.bands + fast,
        band_trends=(),
    )
    axes, below, _ = pressure.friction_pressure(both)[""].axes
    assert {"O-ring, 20.0 mm/s, extending", "O-ring, 80.0 mm/s, extending"} <= set(series(axes))
    for bars in (*axes.containers, *below.containers):
        assert list(bars.lines[0].get_xdata()) == [1, 3, 5, 7]  # each pressure once


def test_a_direction_that_lost_speeds_is_drawn_over_speed_beside_the_other(small):
    lost = [c for c in small.curves if c.direction == "retract"]
    kept = tuple(c for c in small.curves if c.direction == "extend")
    short = replace(small, curves=kept + tuple(replace(c, points=c.points[:2]) for c in lost))
    assert not pressure.has_pressures(short)
    figures = friction.friction_magnitude(short)
    assert set(figures) == {"extend", "retract"}
    assert len(figures["retract"].axes[0].containers[0].lines[0].get_xdata()) == 2


def test_the_lines_of_half_band_and_middle_are_drawn_over_their_pressures(seals):
    _, *panels = pressure.friction_pressure(seals)[""].axes
    (oring, _) = seals.band_trends
    for panel, line in zip(panels, (oring.half, oring.middle), strict=True):
        (drawn,) = (x for x in panel.lines if x.get_label() == "_O-ring, line")
        bars = np.array([1, 3, 5, 7])
        assert drawn.get_xdata() == pytest.approx(bars)
        assert drawn.get_ydata() == pytest.approx(line.intercept_n + line.slope_n_pa * 1e5 * bars)


def test_simulated_figures_say_so_and_others_do_not(small):
    def marks(results):
        return {f.axes[0].get_title("right") for f in every_figure(results)}

    assert marks(small) == {"simulated"}
    assert marks(replace(small, provenance=replace(small.provenance, source="real"))) == {""}


def test_the_same_results_give_the_same_bytes_without_a_date(small, drawings):
    first, second = drawings, draw_all(small, png=True)
    assert [(d.svg, d.png) for d in first] == [(d.svg, d.png) for d in second]
    assert all(b"<dc:date>" not in d.svg for d in first)
    assert imread(io.BytesIO(first[0].png)).shape[1] == 1040


def test_names_are_unique_and_fit_for_files_whatever_the_label(small, undrawn):
    labels = ["../../etc/passwd", "$x_{", "", "ÆØ", "a" * 300, "=1+1"]
    curves = tuple(replace(small.curves[0], label=label) for label in labels)
    found = names(replace(small, runs=(), curves=curves, efficiency=()))
    assert len(found) == len(set(found)) == len(labels)
    assert all(re.fullmatch(r"[a-z0-9-]{1,70}", name) for name in found)


def test_every_series_of_a_large_campaign_looks_different():
    looks = {(s["color"], s["marker"]) for s in map(series_style, range(len(COLOURS) ** 2))}
    assert len(looks) == 49


def _determined(fit):
    known = {
        name: replace(
            p, se=0.1 * p.value, ci95=(0.8 * p.value, 1.2 * p.value), at_bound=None, wide=False
        )
        for name, each in fit.parameters.items()
        for p in [replace(each, value=each.value or 1.0)]
    }
    return replace(fit, converged=True, parameters=known)


def test_points_of_one_trial_have_no_bars_and_neither_has_their_legend(small):
    def legend_bars(results):
        axes = friction.friction_magnitude(results)["extend"].axes[0]
        return [
            getattr(handle, "has_yerr", False) for handle in axes.get_legend_handles_labels()[0]
        ]

    single = tuple(
        replace(curve, points=tuple(replace(point, ci95_n=None) for point in curve.points))
        for curve in small.curves
    )
    assert any(legend_bars(small)) and not any(legend_bars(replace(small, curves=single)))


def test_a_fit_that_is_not_determined_is_not_drawn_as_a_result(small):
    """It is dashed without extrapolation; with no interval at all it is not drawn."""
    curve = small.curves[0]
    whole = _determined(replace(curve.fits[0], beyond=(((0.2, 560.0), (0.24, 620.0)),)))
    name = next(iter(whole.parameters))
    none = {key: replace(p, se=None, ci95=None) for key, p in whole.parameters.items()}
    partly = replace(whole, parameters={**whole.parameters, name: none[name]})
    looks = []
    for fit in (whole, partly, replace(whole, parameters=none)):
        results = replace(small, curves=(replace(curve, fits=(fit,)),))
        figure = friction.friction_magnitude(results)["extend"]
        lines = [
            line for line in figure.axes[0].lines if str(line.get_label()).startswith("_tustin")
        ]
        said = "does not determine" in ordinary_spaces(figure.get_supxlabel())
        looks.append(([(line.get_linestyle(), line.get_color() != QUIET) for line in lines], said))
    assert looks == [
        ([("-", True), (":", True)], False),
        ([("--", True)], True),
        ([], False),
    ]
    assert len(figure.axes) == 1  # no residuals


def test_what_is_extrapolated_is_dotted_and_said_below_the_axis(small):
    curve = small.curves[0]
    beyond = (((0.0, 480.0), (0.005, 470.0)), ((0.2, 560.0), (0.24, 620.0)))
    fit = _determined(replace(curve.fits[0], beyond=beyond))
    figure = friction.friction_magnitude(replace(small, curves=(replace(curve, fits=(fit,)),)))[
        "extend"
    ]
    dotted = [line for line in figure.axes[0].lines if line.get_linestyle() == ":"]
    assert [line.get_xdata().tolist() for line in dotted] == [[0.0, 5.0], [200.0, 240.0]]
    assert "dotted: extrapolated" in figure.axes[-1].get_xlabel()
    plain = friction.friction_magnitude(small)["extend"]
    assert "extrapolated" not in plain.axes[-1].get_xlabel()


def test_an_efficiency_map_has_a_dot_for_each_measured_point_and_says_its_units(stribeck):
    from hbench.report.campaign.figures.efficiency_map import efficiency_map

    found = efficiency_map(stribeck)
    assert list(found) == ["Extending", "Retracting"]
    for direction, figure in zip(("extend", "retract"), found.values(), strict=True):
        curves = [c for c in stribeck.efficiency if c.direction == direction]
        dots = figure.axes[0].lines[-1].get_xydata()
        assert len(dots) == sum(len(curve.points) for curve in curves)
        assert {round(1e3 * load) for load in dots[:, 1]} == {abs(c.f_load_n) for c in curves}
        labels = {axes.get_ylabel() for axes in figure.axes}
        assert len([label for label in labels if label.endswith(" (%)")]) == 2
    one, other = found.values()
    for axes, same in zip(one.axes, other.axes, strict=True):  # maps and their bars of colours
        assert axes.get_xlim() == same.get_xlim() and axes.get_ylim() == same.get_ylim()


def test_no_level_is_written_where_the_colours_of_a_map_end(stribeck):
    """White on white, a part of the number would be missing."""
    from hbench.report.campaign.figures.efficiency_map import efficiency_map

    labels = []
    for figure in efficiency_map(stribeck).values():
        figure.draw_without_rendering()
        for axes in (each for each in figure.axes if each.get_ylabel().startswith("Load")):
            inside = axes.dataLim.transformed(axes.transData).padded(1.0)
            for text in axes.texts:
                box = text.get_window_extent()
                labels.append(text.get_text())
                assert inside.count_contains(box.corners()) == 4, text.get_text()
    assert labels


def test_two_loads_make_no_efficiency_map(small):
    from hbench.report.campaign.figures.efficiency_map import has_efficiency_map

    assert not has_efficiency_map(small)
