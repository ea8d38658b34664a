"""Absolute pressures: columns that state one by their names, and values below a vacuum.

Pressures of a cylinder are those above the atmosphere: it acts on the rod, so that F_T of absolute
pressures would be too large by p_atm (A_p - A_r).
"""

import re
from collections.abc import Iterator, Mapping

import numpy as np

from hbench.channels import CHANNELS
from hbench.store.importing.file_notes import FileNote
from hbench.units import from_si, to_si

ATMOSPHERE = "1.013 bar"  # at sea level
_NOISE = 0.02  # of a channel's range in the file
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


def below_vacuum(name: str, channels: Mapping[str, np.ndarray]) -> Iterator[FileNote]:
    """Yield a note for each pressure [Pa] of the file ``name`` that is below a vacuum."""
    for channel, values in channels.items():
        if not channel.endswith("_pa") or not np.isfinite(values).any():
            continue
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        below = values < -to_si(ATMOSPHERE, "Pa") - _NOISE * (high - low)
        if below.any():
            text = (
                f"{channel}: down to {{low}} bar, below a vacuum (-{ATMOSPHERE}) in {{count}} of "
                "{samples} samples: check its zero, sign, unit and offset"
            )
            numbers = {"low": from_si(low, "bar"), "count": below.sum(), "samples": len(values)}
            yield FileNote(name, text, numbers)
