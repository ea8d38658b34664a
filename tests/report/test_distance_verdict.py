"""The verdict of a run-in and of an endurance campaign begins with the change over the distance."""

from dataclasses import replace

from hbench.records import DistanceTrend, Motions, Series
from hbench.report.campaign.distance_verdict import endurance_words, run_in_words
from hbench.report.campaign.page import report_document
from hbench.report.headline import headline_words
from tests.support.report.made_page import summarized

CYCLES = DistanceTrend(
    *("friction_n", Series("run-in", 0.0, 1e6), None, 0.06, None, (1.0, 3.0, 5.0, 7.0, 9.0)),
    *((420.0, 410.0, 403.0, 401.0, 400.0), -2.0, 3.6, 421.5, 0.2, 0.4),
    *(5.0, 403.5, -3.7, 6.6, "settled", "triangle"),
)
FASTER = replace(
    CYCLES, v_m_s=0.15, distance_m=(10.0, 12.0, 14.0, 16.0, 18.0), last_from_m=14.0,
    last_mean=450.0, last_change=-40.0, last_change_ci95=5.0, verdict="changing",
)  # fmt: skip
STEADY = replace(
    CYCLES, series=Series("measurement", 0.0, 5e5), direction="extend", kind="steady", v_m_s=0.05
)


def made(small, *trends, steady=True):
    """The small campaign with trends."""
    curves = small.curves if steady else ()
    efficiency = small.efficiency if steady else ()
    motions = Motions(over_distance=trends)
    return summarized(replace(small, curves=curves, efficiency=efficiency, motions=motions))


def test_a_run_in_states_whether_friction_has_settled_and_what_to_do(small):
    results = made(small, CYCLES, steady=False)
    assert run_in_words(results).startswith(
        "Friction has settled in cycles up to 60 mm/s (404 N, change −3.7 ± 6.6 N over the last "
        "4.0 m). The intervals are"
    )
    words = run_in_words(made(small, CYCLES, FASTER, steady=False))
    assert "has settled in cycles up to 60 mm/s (404 N" in words
    assert "and still changed in cycles up to 150 mm/s (450 N, change −40.0 ± 5.0 N" in words
    assert "Repeat the cycles until it has settled." in words
    # The speed that settled last decides, and other series are named.
    other = replace(FASTER, series=Series("", 500.0, 1e6), verdict="settled")
    words = run_in_words(made(small, replace(CYCLES, verdict="not determined"), other))
    assert "may still have changed in run-in, 0 N, cycles up to 60 mm/s" in words
    assert "Repeat" not in words


def test_the_page_of_a_run_in_begins_with_its_friction(small):
    results = made(small, CYCLES, steady=False)
    assert headline_words(results) == run_in_words(results)
    assert report_document(results, ()).verdict.startswith("Friction has settled")


def test_a_page_of_cycles_alone_has_no_section_that_only_lacks_steady_runs(small):
    def of_cycles(each):
        return replace(each, run=replace(each.run, plan=replace(each.run.plan, kind="triangle")))

    results = made(small, CYCLES, steady=False)
    results = replace(results, runs=tuple(map(of_cycles, small.runs)))
    assert "Friction" not in [each.title for each in report_document(results, ()).sections]


def test_endurance_states_changes_that_are_significant_beside_the_friction(small):
    results = made(small, CYCLES, STEADY)
    assert endurance_words(results) == "No change of friction over 9 m of travel is significant."
    assert headline_words(results).endswith(endurance_words(results))
    assert headline_words(results).startswith("Friction at")
    leak = replace(
        STEADY, quantity="leakage_m3_s", v_m_s=None, direction=None, kind="hold", slope=1e-9 / 6,
        slope_ci95=2e-10 / 6, p_holm=1e-4,
    )  # fmt: skip
    words = endurance_words(made(small, CYCLES, STEADY, leak))
    assert words == (
        "1 of 3 trends over 9 m of travel is significant: leakage (measurement, 0 N) "
        "+0.080 ± 0.016 ml/min."
    )


def test_steady_trials_without_cycles_are_no_endurance(small):
    assert endurance_words(made(small, STEADY)) == endurance_words(made(small)) == ""
    assert endurance_words(made(small, CYCLES)) == ""  # that conditions the seals before a test


def test_two_checks_are_both(small):
    quality = small.quality
    good = [replace(check, grade="good") for check in quality.checks[:2]]
    results = made(small, CYCLES, steady=False)
    results = replace(results, quality=replace(quality, grade="good", checks=tuple(good)))
    assert "both checks of its quality pass" in report_document(results, ()).verdict
