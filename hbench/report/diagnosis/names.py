"""Display names and units of balances, signals and axes."""

from typing import Any, NamedTuple

from hbench.records import Diagnosis, FitParameter, Gap
from hbench.report.render.numbers import number, significant, with_ends
from hbench.units import from_si


class Words(NamedTuple):
    """Display name of a quantity, and the unit its numbers are shown in."""

    says: str
    unit: str


BALANCES = {
    "flow_tp": Words("oil into chamber Tp", "l/min"),
    "flow_tr": Words("oil into chamber Tr", "l/min"),
    "flow_lp": Words("oil into chamber Lp", "l/min"),
    "flow_lr": Words("oil into chamber Lr", "l/min"),
    "force_test": Words("force, test side", "N"),
    "force_load": Words("force, load side", "N"),
    "kinematics": Words("position against velocity", "mm/s"),
    "supply": Words("supply pressure", "bar"),
}
SIGNALS = {
    "x": Words("position", "mm"),
    "v": Words("velocity", "mm/s"),
    "p_tp": Words("P_Tp", "bar"),
    "p_tr": Words("P_Tr", "bar"),
    "p_lp": Words("P_Lp", "bar"),
    "p_lr": Words("P_Lr", "bar"),
    "p_s": Words("supply pressure", "bar"),
    "f_applied": Words("load cell's force", "N"),
    "u_t": Words("valve T", "V"),
    "u_l1": Words("valve L1", "V"),
    "u_l2": Words("valve L2", "V"),
    "friction": Words("friction", "N"),
}
# Axes of regions and maps, by the records' names.
AXES = {
    "direction": Words("direction", ""),
    "speed_m_s": Words("speed", "mm/s"),
    "v_m_s": Words("velocity", "mm/s"),
    "load_n": Words("load", "kN"),
    "position_m": Words("position", "mm"),
    "x_m": Words("position", "mm"),
    "time_s": Words("time in the run", "s"),
    "t_s": Words("time in the run", "s"),
}
# Fields of BeforeAfter.
STEPS = {
    "before": "as given",
    "refitted": "refitted",
    "after": "with the effects",
    "floor": "floor",
}
# Metering edge of each chamber while the piston extends, and while it retracts.
EDGES = {
    "flow_tp": ("supply", "tank"),
    "flow_tr": ("tank", "supply"),
    "flow_lp": ("tank", "supply"),
    "flow_lr": ("supply", "tank"),
}

_FINE = 1e-5  # a narrower interval is not written with fixed decimals


def balance(name: str) -> Words:
    """Return the display name of a balance, by default its key."""
    return BALANCES.get(name, Words(name.replace("_", " "), ""))


def signal(name: str) -> Words:
    """Return the display name of a signal, by default its key."""
    return SIGNALS.get(name, Words(name.replace("_", " "), ""))


def steps_of(diagnosis: Diagnosis) -> dict[str, str]:
    """Return the fields of ``BeforeAfter`` that differ from each other, and their display names."""
    return {step: title for step, title in STEPS.items() if diagnosis.effects or step != "after"}


def scatter_words(gap: Gap) -> str:
    """Write the trials' scatter in a balance."""
    words = balance(gap.name)
    return f"{significant(shown(gap.scatter, words), 2)} {words.unit}".strip()


def share(value: float) -> str:
    """Write a share in whole per cent, and all shares below −100 % alike."""
    if value < -1:
        return "< −100 %"
    return f"{number(round(100 * value) + 0.0, 0)} %"


def drawn(symbol: str) -> str:
    """Write ``P_Tp`` for a figure, its index below the line."""
    head, index = symbol.partition("_")[::2]
    return f"${head}_{{{index}}}$" if index else symbol


def shown(si: Any, words: Words) -> Any:
    """Convert a number or an array in SI to the unit it is shown in."""
    return from_si(si, words.unit) if words.unit else si


def quantity(parameter: FitParameter) -> str:
    """Write a value with its 95 % interval and its unit, or why there is no interval."""
    texts = [_with_interval(parameter)]
    if parameter.unit != "1":
        texts.append(parameter.unit)
    if parameter.at_bound:
        texts.append(f"(at its {parameter.at_bound} bound)")
    elif parameter.ci95 is None:
        texts.append("(not determined)")
    return " ".join(texts)


def _with_interval(parameter: FitParameter) -> str:
    value = significant(parameter.value, 3)
    if parameter.ci95 is None:
        return value
    low, high = parameter.ci95
    if high - low > _FINE:
        return with_ends(parameter.value, low, high)
    return f"{value} ({significant(low, 3)} to {significant(high, 3)})"
