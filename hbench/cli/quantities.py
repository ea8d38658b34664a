"""Values of options that are quantities, such as ``--speed '100 mm/s'``."""

from hbench.errors import ConfigError
from hbench.units import to_si


def si_of(option: str, text: str, unit: str) -> float:
    """Return a value in SI. Raises ``ConfigError``, whose message begins with ``option``."""
    try:
        return to_si(text, unit)
    except ValueError as error:
        raise ConfigError(f"{option} {text!r} {error}") from None


def working_speed_m_s(text: str | None) -> float | None:
    """Return the value of ``--speed``; None without. Raises ``ConfigError``."""
    if text is None:
        return None
    speed = si_of("--speed:", text, "mm/s")
    if not speed > 0:
        raise ConfigError(f"--speed: is {text!r}; limit 0 mm/s", "Give a positive speed.")
    return speed
