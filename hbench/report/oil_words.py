"""The oil's temperature in words, for the page and the terminal."""

from hbench.records import KINDS, OilTemperature, Results
from hbench.report.render.numbers import number
from hbench.units import from_si

PLACES = {
    "temp_seal_k": "at the test cylinder's seal",
    "temp_port_k": "at a port of the test cylinder",
    "temp_tank_k": "in the tank",
}


def celsius(temp_k: float, decimals: int = 1) -> str:
    """Write a temperature without its unit."""
    return number(from_si(temp_k, "degC"), decimals)


def range_words(oil: OilTemperature | None) -> str:
    """Write mean, range and place of a campaign's oil temperature."""
    if oil is None:
        return "not measured"
    low, high = celsius(oil.low_k), celsius(oil.high_k)
    ends = "" if low == high else f" ({low} to {high} °C)"
    return f"{celsius(oil.mean_k)} °C{ends} {PLACES[oil.sensor]}"


def temperature_words(results: Results) -> str:
    """Return the oil temperature of the steady runs in a sentence; empty without such runs."""
    if not any(KINDS[curve.kind].has_constant_speed for curve in results.curves):
        return ""
    oil = results.oil_temperature
    if oil is None:
        return "The oil temperature was not measured."
    low, high = celsius(oil.low_k), celsius(oil.high_k)
    return f"Oil temperature {PLACES[oil.sensor]}: {low} to {high} °C."
