"""Colour scales that fade into the page where a value is at its best, in the light and the dark.

A scale of opaque colours is white or black at one value: on a page of the other brightness, that
value is the most visible one, and the largest ones vanish.
"""

from matplotlib.colors import LinearSegmentedColormap, to_rgba

_BLUE, _RED = "#1a6fc4", "#d6402f"  # seen on white and on a dark page
_NONE = (to_rgba(_BLUE, 0.0), to_rgba(_RED, 0.0))

GAPS = LinearSegmentedColormap.from_list("gaps", [_NONE[0], to_rgba(_BLUE)])
RESIDUALS = LinearSegmentedColormap.from_list(
    "residuals",
    [(0.0, to_rgba(_BLUE)), (0.5, _NONE[0]), (0.5, _NONE[1]), (1.0, to_rgba(_RED))],
)
