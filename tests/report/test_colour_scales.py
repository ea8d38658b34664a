"""Contrast of the points of a diagnosis's figures with the page."""

import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgb

import hbench.report.render
from hbench.report.diagnosis.figures.colour_scales import PLACES, VELOCITIES

CSS = (Path(hbench.report.render.__file__).parent / "page.css").read_text()
CARDS = sorted(set(map(to_rgb, re.findall(r"--card: (#\w+)", CSS))))  # dark, light and print
LEAST = 3.0  # WCAG 2.2, 1.4.11: graphical objects


def luminance(rgb):
    """Relative luminance of sRGB (WCAG 2.2)."""
    rgb = np.asarray(rgb)
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return linear @ [0.2126, 0.7152, 0.0722]


@pytest.mark.parametrize("scale", [PLACES, VELOCITIES], ids=lambda scale: scale.name)
@pytest.mark.parametrize("card", CARDS, ids=("dark", "light"))
def test_each_colour_of_a_point_is_seen_on_the_light_and_on_the_dark_page(scale, card):
    page = luminance(card)
    points = luminance(scale(np.linspace(0, 1, 64))[:, :3])
    light, dark = np.maximum(points, page), np.minimum(points, page)
    assert ((light + 0.05) / (dark + 0.05)).min() >= LEAST
