"""Figures of residuals: points, medians, scales and bars of colours."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.report.diagnosis.figures.residual_figures import maps_figure, shape_figure
from tests.support.reconcile import made_diagnosis as made


@pytest.fixture(scope="module")
def named():
    return made.named()


@pytest.fixture(scope="module")
def unknown():
    return made.unknown()


def test_no_median_lies_between_groups_of_points(unknown):
    """Alternate windows are at -10 and at 40 repeatabilities, and their median at 15."""
    side = unknown.residuals_before
    value = side.value.copy()
    column = side.names.index("flow_tp")
    groups = np.where(np.arange(len(value)) % 2, 40.0, -10.0)
    value[:, column] = np.where(side.v_m_s > 0, groups, 5.0)

    def medians(way):
        found = replace(unknown, residuals_before=replace(side, value=value))
        figure = shape_figure(found, "flow_tp")
        lines = [line for axes in figure.axes for line in axes.lines]
        chosen = [line for line in lines if line.get_label() == f"_medians, {way}"]
        return np.concatenate([line.get_ydata() for line in chosen])

    assert set(np.round(medians("extending"), 6)) <= {-10.0, 40.0}
    assert set(medians("retracting")) == {5.0}


def test_a_bar_of_colours_lies_below_its_panels_and_not_beside_the_next_one(unknown):
    figure = shape_figure(unknown, "flow_tp")
    figure.draw_without_rendering()
    *panels, load, velocity = figure.axes
    labels = [bar.get_xlabel() for bar in (load, velocity)]
    assert labels == ["Colour: load (kN)", "Colour: velocity (mm/s)"]
    for bar, above in ((load, panels[:3]), (velocity, panels[3:])):
        assert bar.get_position().y1 < min(axes.get_position().y0 for axes in above)
        assert bar.get_position().x1 <= max(axes.get_position().x1 for axes in above) + 0.01


def test_the_shape_is_every_window_of_the_map_in_the_units_of_its_axes(unknown):
    velocity = shape_figure(unknown, "flow_tp").axes[0]
    across, up = velocity.collections[-1].get_offsets().T
    side = unknown.residuals_before
    np.testing.assert_allclose(across, 1e3 * side.v_m_s)
    value = side.value[:, side.names.index("flow_tp")]
    low, high = velocity.get_ylim()
    np.testing.assert_allclose(up, np.clip(value, low, high))


def test_before_and_after_share_one_scale(named):
    for figure in (shape_figure(named, "flow_tp"), maps_figure(named)):
        above, below = figure.axes[0], [a for a in figure.axes if a.get_xlabel()][0]
        assert above is not below
        assert above.get_ylim() == below.get_ylim()
    colours = [axes.collections[0].norm for axes in maps_figure(named).axes[:4]]
    assert {(one.vmin, one.vmax) for one in colours} == {(-colours[0].vmax, colours[0].vmax)}
