"""Zero errors that U does not contain: tolerances of the reading, and zeros that nobody checked."""

from dataclasses import replace

import pytest

from hbench.records.motions import Zero, ZeroCheck
from hbench.report.campaign.page import report_document
from hbench.report.zero_words import zero_reserve

READING = {"tolerance": "1.0 %", "of": "reading", "full_scale": "12 kN"}
READING_BAR = {**READING, "full_scale": "250 bar"}
SCALE = {"tolerance": "0.8 %", "full_scale": "250 bar"}


def with_instruments(results, force, pressure, channels=()):
    settings = {
        **results.provenance.settings,
        "instruments": {"force": force, "pressure": pressure},
    }
    zeros = tuple(Zero(channel, 0.0, 1.0) for channel in channels)
    checks = (ZeroCheck("0001", 0.0, 0.0, 0.0, zeros),) if zeros else ()
    return replace(
        results,
        provenance=replace(results.provenance, settings=settings),
        motions=replace(results.motions, zero_checks=checks),
    )


@pytest.mark.parametrize(
    ("force", "pressure", "channels", "names"),
    [
        (
            READING,
            READING_BAR,
            (),
            "the load cell and the pressure transducers: their",
        ),
        (READING, READING_BAR, ("p_tp_pa",), "the load cell: its tolerance is"),
        (READING, SCALE, (), "the load cell: its tolerance is"),
        (READING, READING_BAR, ("p_tp_pa", "f_applied_n"), ""),
        (SCALE, SCALE, (), ""),
        ({**READING, "further": {"zero": {"tolerance": "0.1 %"}}}, SCALE, (), ""),
    ],
)
def test_sensors_whose_zero_errors_are_not_in_u_are_named(small, force, pressure, channels, names):
    results = with_instruments(small, force, pressure, channels)
    assert names in zero_reserve(results) and bool(names) == bool(zero_reserve(results))
    example = "12 N (the load cell, 12 kN)"
    assert (example in zero_reserve(results)) == names.startswith("the load cell")
    transducer = "31 N (the piston-side transducer, 250 bar)"
    assert (transducer in zero_reserve(results)) == ("and the pressure transducers" in names)
    curve = results.curves[0]
    points = tuple(replace(point, sigma_instruments_n=10.0) for point in curve.points)
    known = replace(results, curves=(replace(curve, points=points), *results.curves[1:]))
    document = report_document(known, ())
    facts = dict(document.sections[0].parts[0].facts)
    assert zero_reserve(results) in facts["Uncertainty"]
    later = [words for section in document.sections[1:] for words in section.paragraphs]
    assert not any("no zero error" in words for words in later)  # once on the page


def test_numbers_of_one_trial_which_have_no_u_have_no_reserve_of_it(small):
    results = with_instruments(small, READING, SCALE)
    names = ("friction_n", "breakaway_n", "efficiency")
    series = tuple(
        replace(
            each,
            **{
                name: replace(number, u95=None)
                for name in names
                if (number := getattr(each, name)) is not None
            },
        )
        for each in results.headline.series
    )
    single = replace(results, headline=replace(results.headline, series=series))
    summary = report_document(single, ()).sections[0]
    assert "no zero error" not in str(summary.facts)
    assert summary.tables[0].title == "Results of each direction and load"


def test_the_identity_states_what_the_tolerances_are_of(small):
    facts = dict(report_document(with_instruments(small, READING, SCALE), ()).identity)
    assert facts["Instruments"] == (
        "no calibration recorded; tolerances: force 1.0 % of reading, pressure 0.8 % of full scale"
    )
