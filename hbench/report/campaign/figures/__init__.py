"""Figures of a campaign, one file a subject."""

FIGURE_NAMES = (  # of all_figures.FIGURES, for callers that do not draw
    "stribeck",
    "friction-pressure",
    "surface",
    "ramps",
    "differences",
    "hysteresis",
    "steps",
    "leakage",
    "breakaway",
    "over-distance",
    "friction-reduced",
    "friction-hersey",
    "efficiency",
    "efficiency-map",
    "rejected",
)
