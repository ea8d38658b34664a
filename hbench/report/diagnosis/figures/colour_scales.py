"""Colour scales that fade into the page where a value is at its best, in the light and the dark.

A scale of opaque colours is white or black at one value: on a page of the other brightness, that
value is the most visible one, and the largest ones vanish.
"""

from matplotlib.colors import LinearSegmentedColormap, to_rgba

_BLUE, _RED = "#1a6fc4", "#d6402f"  # seen on white and on a dark page
_NONE = (to_rgba(_BLUE, 0.0), to_rgba(_RED, 0.0))

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
