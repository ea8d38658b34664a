"""Colour scales that can be read on a light and on a dark page.

Gaps and residuals fade into the page where a value is at its best: a scale that is white or black
there would make that value the most visible one on a page of the other brightness. Points have
colours of about the same brightness, none of which is grey.
"""

from matplotlib.colors import LinearSegmentedColormap, to_rgba

_BLUE, _RED = "#1a6fc4", "#d6402f"  # seen on white and on a dark page
_NONE = (to_rgba(_BLUE, 0.0), to_rgba(_RED, 0.0))

PLACES = LinearSegmentedColormap.from_list("places", ["#2b7bd4", "#b8589a", "#c8641a"])
VELOCITIES = LinearSegmentedColormap.from_list("velocities", ["#8a63d2", "#2f86a6", "#5a8a1f"])
GAPS = LinearSegmentedColormap.from_list("gaps", [_NONE[0], to_rgba(_BLUE)])
# Half as strong at a quarter of the largest residual, so that the map shows the smaller ones too.
RESIDUALS = LinearSegmentedColormap.from_list(
    "residuals",
    [
        (0.0, to_rgba(_BLUE)),
        (0.375, to_rgba(_BLUE, 0.5)),
        (0.5, _NONE[0]),
        (0.5, _NONE[1]),
        (0.625, to_rgba(_RED, 0.5)),
        (1.0, to_rgba(_RED)),
    ],
)
