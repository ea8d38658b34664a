"""Unexplained flows: sensors, the metering edge of a valve, and what several valves share."""

from dataclasses import replace

from hbench.records import Region
from hbench.report.diagnosis.summary import answers
from hbench.report.diagnosis.verdict import verdict_words
from tests.support.report.spaces import ordinary_spaces
from tests.support.report.summarised import NAN, summary

FIVE_LINES = 550  # letters of the headline of a page 1440 px wide


def test_an_unknown_deviation_states_whether_the_sensors_may_cause_it(compared):
    (rest,) = compared.rest  # 40 N, of which tolerances allow 113 N

    def sensors(**changes):
        gap = replace(rest, **{k: v for k, v in changes.items() if k != "refused"})
        found = replace(compared, rest=(gap,), refit_refused=changes.get("refused", ""))
        return ordinary_spaces(dict(answers(found)).get("Sensors", ""))

    assert sensors() == (
        "Sensor errors within the tolerances do not explain this, since the refit includes "
        "them; a sensor beyond its tolerance may."
    )
    assert sensors(allowed=39.0) == "Sensor errors within the tolerances cannot cause as much."
    may = "may cause as much in the force of the test cylinder: check these first."
    assert may in sensors(refused="The refit is refused.")
    assert sensors(allowed=NAN) == ""


def test_valves_that_deviate_at_the_same_edge_are_listed_together_with_the_line_they_share(
    compared,
):
    """The flow in l/min decides the order: repeatabilities differ from chamber to chamber."""
    scatters = {"flow_lp": 0.0037 / 6e4, "flow_tp": 0.0092 / 6e4}  # m³/s
    gaps = {"flow_lp": (11.9, 3.3), "flow_tp": (2.8, 7.6)}  # extending, retracting
    flows = tuple(
        replace(compared.where[0], name=name, scatter=scatter, deviation=5e-7, material=4e-7)
        for name, scatter in scatters.items()
    )

    def found(**changed):
        sizes = gaps | changed
        directions = tuple(
            Region("direction", way, NAN, NAN, 9, {name: pair[i] for name, pair in sizes.items()})
            for i, way in enumerate(("extend", "retract"))
        )
        speeds = tuple(
            Region("speed_m_s", "", low, low + 0.05, 9, dict(zip(gaps, values, strict=True)))
            for low, values in ((0.05, (2.0, 2.0)), (0.1, (14.0, 10.0)))
        )
        return replace(compared, where=flows, rest=flows, regions=(*directions, *speeds))

    lead = ordinary_spaces(verdict_words(found()))
    assert lead.startswith(
        "The flows to the load piston side and the test piston side deviate from the model by 0.030"
    )
    assert len(lead) <= FIVE_LINES
    assert (
        "First inspect the test valve and load valve L2 at their metering edges to tank, and the "
        "return line that they share. To narrow"
    ) in lead
    text = ordinary_spaces(summary(found()))
    reason = (  # 7.6 times 0.0092 l/min, 11.9 times 0.0037 l/min
        "The flows of the test valve and load valve L2 deviate most while these edges meter them, "
        "the flow to the test piston side by 0.070 l/min RMS and the flow to the load piston side "
        "by 0.044 l/min RMS over all speeds, so that a common cause is likely."
    )
    assert reason in text and reason in ordinary_spaces(summary(found()))
    assert (
        "If nothing is found at the valves and their common line, inspect the piston side of the "
        "test cylinder and the transducer of P_Tp; then the piston side of the load cylinder and "
        "the transducer of P_Lp."
    ) in text
    assert (
        "At a speed of 100 to 150 mm/s, the flow to the load piston side deviates by 0.052 l/min "
        "RMS and the flow to the test piston side by 0.092 l/min RMS."
    ) in text
    other_edge = verdict_words(found(flow_tp=(7.6, 2.8)))
    assert "they share" not in other_edge
    assert "First inspect load valve L2, at its edge" in other_edge
    same_valve = replace(flows[1], name="flow_tr"), flows[1]  # tank while extending, retracting
    regions = found(flow_tr=(9.0, 2.0)).regions
    one = replace(compared, where=same_valve, rest=same_valve, regions=regions)
    assert "they share" not in verdict_words(one)
    assert "First inspect the test valve" in verdict_words(one)


def test_a_flow_that_is_wrong_at_one_metering_edge_has_that_edge_inspected_first(compared):
    def of_flow(extending, retracting):
        gaps = {"extend": extending, "retract": retracting}
        regions = tuple(
            Region("direction", way, NAN, NAN, 9, {"flow_tr": gap}) for way, gap in gaps.items()
        )
        gap = replace(compared.where[0], name="flow_tr")
        gap = replace(gap, scatter=1e-3 / 6e4)  # 0.001 l/min
        found = replace(compared, where=(gap,), rest=(gap,), regions=regions)
        return ordinary_spaces(f"{verdict_words(found)} {summary(found)}")

    one_edge = of_flow(17.8, 8.6)  # while the piston extends, oil leaves the rod side
    assert "First inspect the test valve, at its edge to tank. To narrow" in one_edge
    assert (
        "The flow to the test rod side deviates by about 0.018 l/min RMS while the edge of the "
        "test valve to tank meters it, and by 0.0086 l/min RMS while the edge to supply does."
    ) in one_edge
    assert "First inspect the test valve." in of_flow(8.6, 8.0)


def test_a_flow_that_depends_on_the_position_has_the_bore_inspected_first(compared):
    gap = replace(compared.where[0], name="flow_lr")
    regions = tuple(
        Region("position_m", "", low, low + 0.1, 99, {"flow_lr": value})
        for low, value in ((0.05, 2.0), (0.2, 8.0))
    ) + tuple(
        Region("direction", way, NAN, NAN, 9, {"flow_lr": value})
        for way, value in (("extend", 7.0), ("retract", 2.0))
    )
    bore = replace(compared, where=(gap,), rest=(gap,), regions=regions)
    text = ordinary_spaces(verdict_words(bore))
    assert "First inspect the bore and the piston seal of the load cylinder. To narrow" in text
    assert "RMS), and a valve does not depend on the position." in summary(bore)
    assert "of the load cylinder, inspect load valve L1, the rod side" in summary(bore)
