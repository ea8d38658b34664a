"""The report's section on the oil's temperature: what was reduced, and why something was not."""

from dataclasses import replace

import pytest

from hbench.records import OilTemperature, Reduction, ViscosityEffect
from hbench.report.campaign.sections.oil_temperature import temperature_section
from hbench.report.oil_words import temperature_words

EFFECT = ViscosityEffect(
    kind="steady",
    label="",
    direction="extend",
    dry_n=3.0,
    dry_ci95_n=12.0,
    viscous_n_s_m=2400.0,
    viscous_ci95_n_s_m=150.0,
    p=1e-9,
    points=12,
    trials=36,
    correction_n=-80.0,
    correction_ci95_n=6.0,
    speed_vif=1.1,
    reason="",
)
OIL = OilTemperature("temp_port_k", 312.15, 305.15, 318.65, 36, None, "no reason")


@pytest.fixture(scope="module")
def results(stribeck):
    return stribeck


def text_of(results):
    (section,) = temperature_section(results, ())
    return " ".join(section.paragraphs)


def test_without_a_sensor_the_summary_says_so_and_there_is_no_section(results):
    bare = replace(results, oil_temperature=None)
    assert temperature_words(bare) == "The oil temperature was not measured."
    assert temperature_section(bare, ()) == ()
    assert temperature_words(replace(bare, curves=())) == ""


def test_temperatures_are_in_degrees_celsius_with_their_place(results):
    known = replace(results, oil_temperature=OIL)
    words = "Oil temperature at a port of the test cylinder: 32.0 to 45.5 °C."
    assert temperature_words(known) == words
    assert "39.0 °C in the mean, from 32.0 to 45.5 °C" in text_of(known)
    assert "not reduced to a reference temperature, since no reason." in text_of(known)


def test_each_direction_that_is_not_reduced_has_its_reason_and_advice_is_given_once(results):
    reason = "the order of the runs does not separate temperature from speed"
    left = replace(EFFECT, speed_vif=50.0, reason=reason)
    effects = (left, replace(left, direction="retract"))
    reduction = Reduction(313.15, False, effects, (), None)
    text = text_of(replace(results, oil_temperature=replace(OIL, reduction=reduction)))
    for direction in ("Extending", "Retracting"):
        assert f"{direction}: friction is not reduced to 40.0 °C, since {reason}." in text
    assert text.count("order: random") == 1


def test_reduced_curves_are_counted_and_an_extrapolation_is_named(results):
    curves = tuple(replace(curve, fits=()) for curve in results.curves[:2])
    reduction = Reduction(313.15, True, (EFFECT,), curves, None)
    known = replace(results, oil_temperature=replace(OIL, reduction=reduction))
    text = text_of(known)
    assert "Friction of 2 curves is reduced to 40.0 °C" in text and "extrapolated" in text
    (section,) = temperature_section(known, ())
    effect = section.tables[1].rows[0]
    assert "2400 ± 150" in [cell.text for cell in effect]
    points = section.parts[-1].tables[0]
    assert len(points.rows) == sum(len(curve.points) for curve in curves)
