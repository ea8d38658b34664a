"""Plausibility of pressures and forces: absolute ones by name, and values that can't be measured.

Pressures of a cylinder are those above the atmosphere: it acts on the rod, so that F_T of absolute
pressures would be too large by p_atm (A_p - A_r).
"""

import re
from collections.abc import Iterator, Mapping

import numpy as np

from hbench.channels import CHANNELS
from hbench.config.import_layout import ImportedCylinder
from hbench.config.import_map import ImportMap
from hbench.store.importing.file_notes import FileNote
from hbench.units import from_si, to_si

ATMOSPHERE = "1.013 bar"  # at sea level
_NOISE = 0.02  # of a channel's range in the file
_OVERRANGE = 1.1  # of the full scale, which sensors can show
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


def beyond_full_scale(
    name: str, channels: Mapping[str, np.ndarray], rules: ImportMap
) -> Iterator[FileNote]:
    """Yield a note for each measured channel of the file ``name`` with values beyond 110 %."""
    if rules.instruments is None:
        return
    ranges = {
        "p_tp_pa": (rules.instruments.pressure.full_scale, "bar"),
        "p_tr_pa": (rules.instruments.pressure.full_scale, "bar"),
        "f_applied_n": (rules.instruments.force.full_scale, rules.unit("f_applied_n")),
    }
    for channel, (full_scale, unit) in ranges.items():
        if channel not in rules.columns:
            continue
        size = np.abs(channels[channel])
        beyond = size > _OVERRANGE * full_scale
        if beyond.any():
            text = (
                f"{channel}: up to {{high}} {unit} in size, beyond the instrument's full scale "
                f"({from_si(full_scale, unit):g} {unit}) in {{count}} of {{samples}} samples: "
                "check its unit and scale, and full_scale in the map"
            )
            numbers = {
                "high": from_si(float(np.nanmax(size)), unit),
                "count": beyond.sum(),
                "samples": len(size),
            }
            yield FileNote(name, text, numbers)


def forgotten_rod(name: str, cylinder: ImportedCylinder, rules: ImportMap) -> Iterator[FileNote]:
    """Yield a note on a cylinder whose map states no rod, but a pressure on the rod side."""
    is_stated = {"rod_diameter", "rod_area", "displacement"} & cylinder.model_fields_set
    if cylinder.known and not is_stated and "p_tr_pa" in rules.columns:
        acts = "the whole piston area" if cylinder.area_rod_m2 else "no area"
        key = "rod_diameter" if cylinder.area_rod_m2 else "rod_area"
        zero = "0 mm" if cylinder.area_rod_m2 else "0 mm^2"
        text = (
            f"the map states no {key}, so that p_tr_pa acts on {acts}: enter {key}, or write "
            f"'{key}: {zero}' if this is so"
        )
        yield FileNote(name, text)
