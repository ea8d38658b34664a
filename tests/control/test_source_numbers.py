"""Every number of chapter 4 that can be reproduced, and the contradictions beside them."""

import pytest

from hbench.studies.source_design import OPERATING_POINT, reproduce

# Quantity: printed in the source, and the tolerance.
PRINTED = {
    "P_Lp,ref at 10 kN, 15 bar": (88.7, 0.001),
    "P_Lp,ref at 1 kN, 75 bar": (53.7, 0.001),
    "K_T": (7.43e-7, 0.001),
    "C_ffLr": (5.7205, 0.001),
    "C_ffLp": (34.0682, 0.001),
    "open pole, Lr": (-1.76, 0.001),
    "open pole, Lp": (-7.32, 0.001),
    "controller zero, Lr": (-3.03, 0.001),
    "bandwidth, T": (378.0, 0.01),
    "bandwidth, Lr": (151.0, 0.01),
    "bandwidth, Lp": (87.0, 0.01),
    "ramp error, linear": (1.67, 0.01),
}
# What the printed numbers can't be at once: printed, and what the rest of them leads to.
CONTRADICTIONS = {
    "closed pole, Lr": (-110.76, -148.4, "113.4"),
    "lowest bandwidth ratio": (1.77, 151 / 87, "1.736"),
    "K_c,Lr for 151 rad/s": (1.25e-4, 1.25e-5, "13.7 V"),
}


@pytest.fixture(scope="module")
def numbers(par):
    return {number.quantity: number for number in reproduce(par)}


@pytest.mark.parametrize("quantity", PRINTED)
def test_a_reproducible_number_comes_out_as_printed(numbers, quantity):
    printed, tolerance = PRINTED[quantity]
    assert numbers[quantity].obtained == pytest.approx(printed, rel=tolerance)
    assert numbers[quantity].agrees
    assert float(numbers[quantity].printed) == pytest.approx(printed, rel=1e-6)


@pytest.mark.parametrize("quantity", CONTRADICTIONS)
def test_a_contradiction_of_the_source_stands_beside_the_number(numbers, quantity):
    printed, consistent, words = CONTRADICTIONS[quantity]
    number = numbers[quantity]
    assert not number.agrees and "contradiction" in number.note and words in number.note
    assert number.obtained == pytest.approx(consistent, rel=2e-3)
    assert number.error == pytest.approx(consistent / printed - 1, abs=2e-3)


def test_overshoot_and_settling_are_as_the_figures_show(numbers):
    assert 0.6 < numbers["overshoot, Lr"].obtained < 1.0  # "approximately 1 %"
    assert numbers["overshoot, Lp"].obtained < 0.01
    assert numbers["overshoot, T"].obtained < 0.01
    assert 0.15 < numbers["settling to 2 %, T"].obtained < 0.4


def ramp_error(numbers, case):
    (number,) = (one for quantity, one in numbers.items() if quantity.endswith(f" {case}"))
    return number


@pytest.mark.parametrize("case", ["+50 mm/s, 6.9 kN", "+50 mm/s, 7.4 kN", "-50 mm/s, 0.5 kN"])
def test_the_nonlinear_ramp_error_lies_in_the_printed_interval(numbers, case):
    assert 1.5 <= ramp_error(numbers, case).obtained <= 1.7


@pytest.mark.parametrize(
    ("case", "simulated"),  # by a nonlinear model made without this code
    [
        ("+50 mm/s, 5 kN", 1.52),
        ("+50 mm/s, 6.9 kN", 1.65),
        ("+50 mm/s, 7.4 kN", 1.69),
        ("-50 mm/s, 0.5 kN", 1.66),
        ("-50 mm/s, 2 kN", 1.55),
    ],
)
def test_the_nonlinear_ramp_error_grows_with_the_load_as_another_model_has_it(
    numbers, case, simulated
):
    assert ramp_error(numbers, case).obtained == pytest.approx(simulated, rel=0.03)


def test_each_number_of_the_source_is_listed_once(par, numbers):
    assert len(numbers) == len(reproduce(par))
    assert set(PRINTED) | set(CONTRADICTIONS) < set(numbers)


def test_the_source_points_are_those_of_the_printed_gains(source):
    """K_uLr and K_uLp follow from the printed C_ff and the areas of 40 and 25 mm."""
    assert source.ku_lr == pytest.approx(7.65763e-4 / 5.7205, rel=1e-3)
    assert source.ku_lp == pytest.approx(1.25664e-3 / 34.0682, rel=1e-3)
    assert OPERATING_POINT.u_l2_v < 0  # the load's piston side empties as the test cylinder extends
