"""Absolute pressures, by the names of columns.

Pressures of a cylinder are those above the atmosphere: it acts on the rod, so that F_T of absolute
pressures would be too large by p_atm (A_p - A_r).
"""

import re

from hbench.channels import CHANNELS

ATMOSPHERE = "1.013 bar"  # at sea level
# After a unit: bara, bar(a), psia, kPa abs. A blank or a capital A may be the port: bar A.
_BEHIND_UNIT = re.compile(
    r"(?:bar|psi|Pa)(?:a|\(a\)|[\s_]*[(\[]?abs(?:olute?)?\.?[)\]]?)(?![^\W_])"
)
_WORD = re.compile(r"(?<![^\W_])abs(?:olut\w*)?(?![^\W_])|absolutdruck", re.IGNORECASE)


def is_absolute_pressure(channel: str, *names: str) -> bool:
    """Return whether the ``names`` of a channel's column and unit state an absolute pressure."""
    return CHANNELS[channel].unit == "Pa" and any(
        pattern.search(name) for name in names for pattern in (_BEHIND_UNIT, _WORD)
    )
