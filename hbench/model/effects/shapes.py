"""Shapes that the effects' textbook laws can take."""

from math import sqrt

from hbench.model.compiled import inlined


@inlined
def power_law(y: float, reference: float, exponent: float) -> float:
    """Return r (y / r)^n of y >= 0: y itself, to the bit, for n = 1, and at y = r for any n."""
    if exponent == 1.0 or y <= 0.0:
        return y
    return reference * (y / reference) ** exponent


@inlined
def soft_edge(y: float, softness: float) -> float:
    """Return max(y, 0), or a hyperbola that nears it over about ``softness``, in the unit of y."""
    if softness == 0.0:
        return max(y, 0.0)
    return 0.5 * (y + sqrt(y * y + softness * softness))
