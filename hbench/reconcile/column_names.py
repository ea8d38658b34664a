"""Names of the columns of a linearised model: one for each parameter that a search fits.

/valve.gain                                  factor on a value of the plant, by dotted path
internal_leakage.test                        coefficient of an effect
~p_tp, ~delay_f_applied, ~ripple_test.0      disturbance: drift, delay, mode of a ripple
#0.3                                         mode of a learned law: table and mode
"""

CoefficientKey = tuple[str, str]  # name of the effect, key of its coefficient

_DELAY, _RIPPLE = "~delay_", "~ripple_"


def factor_name(path: str) -> str:
    """Return the name of the column of a factor on the value at a dotted path."""
    return f"/{path}"


def factor_path(name: str) -> str:
    """Return the dotted path of the value that a factor multiplies; empty for another column."""
    return name[1:] if name.startswith("/") else ""


def coefficient_name(which: CoefficientKey) -> str:
    """Return the name of the column of a coefficient."""
    return ".".join(which)


def is_coefficient(name: str) -> bool:
    """Return whether a column is that of a coefficient of an effect."""
    return name[0] not in "/~#"


def coefficient_of(name: str) -> CoefficientKey:
    """Return the coefficient of a column for which ``is_coefficient`` is true."""
    effect, _, key = name.partition(".")
    return effect, key


def drift_name(channel: str) -> str:
    """Return the name of the column of a channel's drift."""
    return f"~{channel}"


def delay_name(channel: str) -> str:
    """Return the name of the column of a channel's delay."""
    return f"{_DELAY}{channel}"


def ripple_name(cylinder: str, mode: int) -> str:
    """Return the name of the column of a mode of a cylinder's ripple."""
    return f"{_RIPPLE}{cylinder}.{mode}"


def is_disturbance(name: str) -> bool:
    """Return whether a column is that of a disturbance."""
    return name.startswith("~")


def is_ripple(name: str) -> bool:
    """Return whether a column is that of a mode of a ripple."""
    return name.startswith(_RIPPLE)


def delayed_channel(name: str) -> str:
    """Return the channel whose delay a column is that of; empty for another column."""
    return name.removeprefix(_DELAY) if name.startswith(_DELAY) else ""


def mode_name(table: int, mode: int) -> str:
    """Return the name of the column of a mode of a learned law."""
    return f"#{table}.{mode}"


def is_mode(name: str) -> bool:
    """Return whether a column is that of a mode of a learned law."""
    return name.startswith("#")


def mode_of(name: str) -> tuple[int, int]:
    """Return table and mode of a column for which ``is_mode`` is true."""
    table, _, mode = name[1:].partition(".")
    return int(table), int(mode)
