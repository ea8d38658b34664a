"""Quantities are read with their units, and nothing else is taken for one."""

import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hbench.units import UNITS, from_si, to_si


@pytest.mark.parametrize(
    ("text", "unit", "si"),
    [
        ("150 bar", "bar", 1.5e7),
        ("40 mm", "mm", 0.04),
        ("40mm", "mm", 0.04),
        ("7.43e-7 m^2/V", "m^2/V", 7.43e-7),
        ("30 l/min", "m^3/s", 5e-4),
        ("1.25e-5 V/(Pa s)", "V/(Pa s)", 1.25e-5),
        ("1.25 V/(bar s)", "V/(Pa s)", 1.25e-5),
        ("1.25 V/bar/s", "V/(Pa s)", 1.25e-5),
        ("2331 N s/m", "N s/m", 2331.0),
        ("2331 kg/s", "N s/m", 2331.0),
        ("251.2 cm^3", "cm^3", 2.512e-4),
        ("-5 kN", "N", -5000.0),
        ("1 kip", "N", 4448.2216152605),  # 1000 lbf
        ("1000 lbf", "N", 4448.2216152605),  # 0.45359237 kg * 9.80665 m/s^2
        ("16 in", "mm", 0.4064),
        ("250 mbar", "bar", 25000.0),
        ("1 d", "s", 86400.0),
        ("2 h", "s", 7200.0),
        ("1.5 %", "%", 0.015),
        (0.25, "%", 0.25),
        ("100 mm/s^2", "m/s^2", 0.1),
        ("100 mm/s²", "m/s^2", 0.1),
        ("251.2 cm³", "cm^3", 2.512e-4),
        ("2331 N·s/m", "N s/m", 2331.0),
        ("1 psi", "bar", 6894.757293168361),
        ("40 degC", "degC", 313.15),
        ("-10 °C", "degC", 263.15),
        ("212 degF", "degC", 373.15),
        ("-40 °F", "degC", 233.15),
        ("300 K", "degC", 300.0),
        ("46 cSt", "mm^2/s", 46e-6),
        ("40 ℃", "degC", 313.15),  # one character, as in Chinese and Japanese files
        ("212 ℉", "degC", 373.15),
        ("25 µm", "mm", 25e-6),  # micro sign
        ("25 μm", "mm", 25e-6),  # Greek letter
        ("16 ㎫", "bar", 16e6),
        ("5 ｋＮ", "N", 5000.0),
        ("1.5 ％", "%", 0.015),
        ("100 mm·s⁻¹", "m/s", 0.1),
        ("100 mm∕s", "m/s", 0.1),
        ("2331 N⋅s∕m", "N s/m", 2331.0),
        ("\u22125 kN", "N", -5000.0),  # typographic minus sign
    ],
)
def test_a_quantity_is_stored_in_si(text, unit, si):
    assert to_si(text, unit) == pytest.approx(si, rel=1e-14)


@pytest.mark.parametrize(
    ("value", "unit", "message"),
    [
        (150, "bar", "unit.*'150 bar'"),
        ("150", "bar", "no unit"),
        ("150 mm", "bar", "wrong unit"),
        ("150 baar", "bar", "unit 'baar'"),
        ("2 inch", "mm", "unknown unit 'inch'; did you mean 'in'[?]"),
        ("2 PSI", "bar", "unknown unit 'PSI'; did you mean 'psi'[?]"),
        ("2 lbs", "N", "unknown unit 'lbs'; did you mean 'lbf'[?]"),
        ("2 barg", "bar", "unknown unit 'barg'; did you mean 'bar'[?]"),
        ("2 psia", "bar", "absolute pressure write 'psi' and offset: -1.013 bar$"),
        ("bar", "bar", "number"),
        ("1 2 bar", "bar", "can't read|unknown"),
        ("1 ㎨", "m/s^2", r"'m/s2': a power needs \^"),
        ("1½ bar", "bar", "can't read"),
        ("10² bar", "bar", "follows no unit"),
        ("1 m/s2", "m/s^2", r"'m/s2': a power needs \^"),
        ("1 V/(Pa s", "V/(Pa s)", "not closed"),
        ("1 Pa)", "Pa", "without"),
        ("nan bar", "bar", "number"),
        ("1e999 bar", "bar", "finite"),
        (True, "bar", "quantity"),
        ([1], "bar", "quantity"),
        (None, "bar", "quantity"),
        ("40 degC", "K", "a temperature, not a difference.*'1 K'"),
        ("0.03 1/degC", "1/K", "degC is not a factor; write K"),
        ("40 degC", "bar", "wrong unit"),
    ],
)
def test_what_is_no_quantity_of_the_kind_is_refused_with_the_reason(value, unit, message):
    with pytest.raises(ValueError, match=message):
        to_si(value, unit)


@given(st.floats(-1e9, 1e9), st.sampled_from(sorted(UNITS)))
def test_reading_and_converting_back_are_inverse(number, unit):
    assert from_si(to_si(f"{number!r} {unit}", unit), unit) == pytest.approx(number, rel=1e-12)


@pytest.mark.parametrize(
    "text",
    ["1 bar^999999999", "1 mm^-99999", "1 bar^999", "1 " + " " * 100_000 + "x", "9" * 100_000],
)
def test_a_quantity_that_no_one_means_is_refused_at_once(text):
    start = time.perf_counter()
    with pytest.raises(ValueError):
        to_si(text, "bar")
    assert time.perf_counter() - start < 1
