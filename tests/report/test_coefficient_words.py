"""Coefficients of effects in words: units of the reader, parts and limits."""

from dataclasses import replace

from hbench.records import (
    Change,
    FitParameter,
)
from hbench.report.diagnosis.page import diagnosis_page
from hbench.report.diagnosis.tables.change_tables import changes_tables
from hbench.report.diagnosis.terminal import diagnosis_text
from hbench.report.diagnosis.verdict import verdict_words
from hbench.report.diagnosis.words.coefficient import alike_words, coefficients_words
from tests.support.report.spaces import ordinary_spaces
from tests.support.report.summarised import LEAK, added, summary


def test_an_effect_that_is_present_but_too_small_to_matter_is_reported_as_such(named):

    def verdict(largest):
        changes = (Change("force_test", "N", 0.0, None, largest, largest),)
        effect = replace(LEAK, changes=changes)
        return ordinary_spaces(verdict_words(replace(named, practice=(effect,))))

    words = "too small to matter (limit for the force of the test cylinder: 12 N)."
    assert f"by up to 4.0 N (in 95 % of the motion). That is {words}" in verdict(4.0)
    nothing = "Nothing needs to be inspected or repaired for an effect of this size"
    assert nothing in verdict(4.0) and "Next, inspect" not in verdict(4.0)
    assert "too small" not in verdict(12.5) and nothing not in verdict(12.5)
    changes = (Change("force_test", "N", 0.0, None, 4.0, 4.0),)
    small = replace(named, practice=(replace(LEAK, changes=changes),))
    assert "nspect" not in summary(small)  # the verdict has that nothing needs to be inspected


def test_the_law_of_an_effect_is_printed_with_raised_exponents(named):
    law = "dp/dt = R Q_0^2 (Q / Q_0)^n - p"
    lawful = replace(named, effects=(replace(named.effects[0], law=law),))
    page = ordinary_spaces(diagnosis_page(lawful, ()))
    assert "Q<sub>0</sub>² (Q / Q<sub>0</sub>)ⁿ − p." in page


def test_friction_that_is_larger_in_one_direction_has_the_direction(named):
    def words(test, load):
        parameters = {
            name: FitParameter(value, 1.0, (value - 2, value + 2), None, "%")
            for name, value in (("test", test), ("load", load))
        }
        effect = replace(
            named.effects[0], name="direction_asymmetry", parameters=parameters,
            description="dry friction is larger in one direction",
        )  # fmt: skip
        return verdict_words(replace(named, effects=(effect,)))

    mean = "than the mean of both directions (test cylinder"
    assert f"dry friction is larger while extending {mean} 12.0 ± 2.0 %" in words(12.0, 8.0)
    assert f"dry friction is larger while retracting {mean} −12.0 ± 2.0 %" in words(-12.0, -8.0)
    assert "larger while extending than" in words(12.0, 1.0)  # one of them may be 0
    assert "dry friction is larger in one direction (test" in words(12.0, -8.0)


def test_an_effect_with_nothing_to_inspect_has_what_to_do_in_the_verdict(named):
    lag = replace(LEAK, inspect="", repair="Keep it in the model.")
    assert verdict_words(replace(named, practice=(lag,))).endswith("Keep it in the model.")


def test_two_effects_that_are_both_present_are_both_inspected(named):
    other = added("tank_back_pressure", 50.0)
    line = replace(LEAK, name="tank_back_pressure", inspect="the return line", lookalikes=())
    both = replace(named, effects=(*named.effects, other), practice=(LEAK, line))
    text = ordinary_spaces(verdict_words(both))
    assert "Inspect first the piston seal, then the return line." in text
    assert text.startswith(
        "The model does not contain internal leakage (test cylinder) and tank back pressure (test "
        "cylinder). "
    )
    assert "less oil enters the piston side of the test cylinder (Tp) due to tank back" in text
    still = replace(line, changes=())
    brief = verdict_words(replace(both, practice=(LEAK, still)))
    assert "l/min), and tank back pressure changes nothing. With both" in brief
    more = replace(line, inspect="the return filter, and the bore: its size")
    brief = verdict_words(replace(both, practice=(LEAK, more)))
    assert "Inspect first the piston seal, then the return filter." in brief  # the rest is below
    assert "Inspect the return filter, and the bore: its size." in summary(
        replace(both, practice=(LEAK, more))
    )


def test_the_sides_of_a_cylinder_are_named_together(named):
    def words(*sides):
        parameters = {side: FitParameter(0.5, 0.05, (0.4, 0.6), None, "N/bar") for side in sides}
        seals = replace(added("seal_pressure_friction", 50.0), parameters=parameters)
        return verdict_words(replace(named, effects=(*named.effects, seals), practice=()))

    seals, every = "seal pressure friction", ("test_piston", "test_rod", "load_piston", "load_rod")
    assert f"{seals} (both cylinders)" in words(*every)
    assert f"{seals} (both sides of load cylinder)" in words(*every[2:])
    assert f"{seals} (both sides of load cylinder and rod side of test cylinder)" in words(
        *every[1:]
    )
    assert f"{seals} (piston side of test cylinder and rod side of load cylinder)" in words(
        every[0], every[3]
    )


def test_a_coefficient_of_a_power_law_has_the_value_where_its_unit_holds(named):
    """A leak is a flow there; of other laws the coefficient's unit applies there alone."""
    (effect,) = named.effects
    law = "Q = G p_0 (|P| / p_0)^n, n = exponent, p_0 = 50 bar"
    power = {**effect.parameters, "exponent": FitParameter(0.7, 0.07, (0.56, 0.84), None, "1")}
    curved = replace(effect, law=law, parameters=power)
    assert coefficients_words(curved) == (
        "test cylinder 0.150 ± 0.010 l/min at 50 bar, exponent 0.70 ± 0.14"
    )
    # 0.003 l/min/bar times 24 bar are no flow of this law, so they are not written.
    page = ordinary_spaces(diagnosis_page(replace(named, effects=(curved,)), ()))
    assert "0.150 ± 0.010 l/min at 50 bar" in page and "l/min/bar" not in page
    own = "0.150 ± 0.010 l/min at 50 bar, i.e. 0.00300 l/min/bar"  # that of model.yaml
    laminar = replace(effect, law=law)
    assert own in ordinary_spaces(diagnosis_page(replace(named, effects=(laminar,)), ()))
    share = {"test": FitParameter(0.5, 0.1, (0.3, 0.7), None, "N/bar")}
    seal = replace(effect, law="k P_0 (P / P_0)^n, P_0 = 50 bar", parameters=share)
    assert coefficients_words(seal) == "test cylinder 0.50 ± 0.20 N/bar"
    curved = replace(seal, parameters=share | {"exponent": power["exponent"]})
    assert coefficients_words(curved).startswith("test cylinder 0.50 ± 0.20 N/bar at 50 bar")


def test_the_exponent_of_a_leak_states_the_kind_of_gap_where_its_interval_decides(named):
    (effect,) = named.effects

    def texts(value, half, name="internal_leakage"):
        exponent = FitParameter(value, half / 2, (value - half, value + half), None, "1")
        leak = replace(effect, name=name, parameters={**effect.parameters, "exponent": exponent})
        found = replace(named, effects=(leak,), practice=(replace(LEAK, name=name),))
        return ordinary_spaces(verdict_words(found)), ordinary_spaces(summary(found))

    lead, action = texts(0.535, 0.074)
    assert "oil leaks, as through an orifice (test cylinder" in lead
    assert (
        "Inspect the piston seal. The exponent, 0.535 ± 0.074, is that of an orifice (0.5), such "
        "as a damaged seal or a score in the bore, and not that of a laminar gap (1), such as a "
        "worn seal. Replace it."
    ) in action
    lead, action = texts(0.95, 0.1, "external_leakage")
    assert "as through a laminar gap" in lead and "and not that of an orifice (0.5)" in action
    for undecided in (texts(0.75, 0.1), texts(0.75, 0.3)):
        assert "orifice" not in "".join(undecided) and "The exponent" not in "".join(undecided)


def test_the_resistance_of_a_line_is_a_pressure_at_the_flow_of_its_law(named):
    """0.014 bar min²/l² times the square of 10 l/min are 1.4 bar."""
    parameters = {"resistance": FitParameter(0.014, 0.001, (0.012, 0.016), None, "bar min^2/l^2")}
    law = "lag dp/dt = resistance Q_0^2 (Q / Q_0)^n - p, Q_0 = 10 l/min"
    line = replace(named.effects[0], law=law, parameters=parameters)
    words = "1.40 ± 0.20 bar at 10 l/min, i.e. 0.0140 bar min²/l²"
    assert coefficients_words(line) == "resistance 1.40 ± 0.20 bar at 10 l/min"
    found = replace(named, effects=(line,))
    assert words in ordinary_spaces(diagnosis_page(found, ()))
    assert diagnosis_text(found).isascii()


def test_coefficients_that_may_be_0_are_marked(named):
    masses = {
        "test": FitParameter(2.0, 2.5, (-2.9, 6.9), None, "kg"),
        "load": FitParameter(16.2, 2.6, (11.0, 21.4), None, "kg"),
    }
    heavy = replace(named.effects[0], name="added_mass", parameters=masses)
    assert coefficients_words(heavy) == (
        "load cylinder 16.2 ± 5.2 kg; not distinguishable from 0: test cylinder 2.0 ± 4.9 kg"
    )
    page = ordinary_spaces(diagnosis_page(replace(named, effects=(heavy,)), ()))
    assert "2.0 ± 4.9 kg (not distinguishable from 0)" in page
    lead = ordinary_spaces(verdict_words(replace(named, effects=(heavy,))))
    assert "oil leaks (load cylinder 16.2 ± 5.2 kg; 95 % interval)." in lead
    assert "5.2 kg (not" not in page


def test_the_cylinder_that_leaks_is_the_one_that_is_inspected(named):
    """The catalogue has one text for both; the coefficients state which."""
    leak = FitParameter(0.006, 1e-4, (0.0058, 0.0062), None, "l/min/bar")
    none = FitParameter(0.0, 1e-6, (0.0, 1e-5), "lower", "l/min/bar")
    seal = replace(LEAK, inspect="the piston seal of each leaking cylinder")

    def advice(**parameters):
        effect = replace(named.effects[0], parameters=parameters)
        found = replace(named, effects=(effect,), practice=(seal,))
        words = verdict_words(found).rpartition("inspect ")[2]
        assert words in summary(found).replace("Inspect ", "").replace("Then inspect ", "")
        return words

    assert advice(test=none, load=leak) == "the piston seal of the load cylinder."
    assert advice(test=leak, load=none) == "the piston seal of the test cylinder."
    assert advice(test=leak, load=leak) == "the piston seal of each cylinder."
    both = replace(named.effects[0], parameters={"test": leak, "load": leak})
    alike = verdict_words(replace(named, effects=(both,), practice=(seal,)))
    assert alike.endswith(
        "First check the valves, whose leakage may look the same; then inspect the piston seal of "
        "each cylinder."
    )
    told = summary(replace(named, effects=(both,), practice=(seal,)))
    assert "look the same in these runs. Then inspect the piston seal of each cylinder" in told
    assert advice(exponent=replace(leak, unit="1")) == "the piston seal of each leaking cylinder."
    other = replace(LEAK, name="tank_back_pressure", lookalikes=())
    effects = (replace(named.effects[0], parameters={"test": none, "load": leak}),
               added("tank_back_pressure", 50.0))  # fmt: skip
    both = replace(named, effects=effects, practice=(seal, other))
    assert "does not contain internal leakage (load cylinder) and tank" in verdict_words(both)


def test_a_change_of_exactly_0_has_no_interval(named):
    still = Change("flow_lr", "l/min", 0.0, (0.0, 0.0), 0.1, 0.2)
    (table,) = changes_tables(replace(named, practice=(replace(LEAK, changes=(still,)),)))
    assert table.rows[0][1] == "0 l/min"


def test_two_cylinders_that_leak_alike_have_a_common_cause_first(named):
    """Within their intervals; a cylinder that leaks clearly more is a seal's own fault."""

    def words(load):
        parameters = {
            name: FitParameter(value, 0.05, (value - 0.1, value + 0.1), None, "l/min/bar")
            for name, value in (("test", 1.0), ("load", load))
        }
        return alike_words(replace(named.effects[0], parameters=parameters))

    assert words(1.1).startswith(
        "First check the valves for leakage: both cylinders leak alike"
    ) and not words(2.0)
