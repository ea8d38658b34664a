"""Balance over the load and equality of both directions, on curves whose truth is known."""

from types import SimpleNamespace

import numpy as np
import pytest

from hbench.analysis.summary.force_checks import (
    direction_notes,
    equal_directions,
    load_balance,
    load_share,
)

SPEEDS = np.geomspace(5e-3, 0.2, 40)  # steps of a tenth
CLOSE = np.arange(0.1, 0.2, 0.004)  # steps within 5 % of each other


def curves(loads_n, speeds=SPEEDS, middle=lambda load: 0.0, ci95_n=0.5, u95_n=None):
    """Curves of both directions with 300 N + 500 N s/m, measured at slightly different speeds."""
    made = []
    for load in loads_n:
        for direction, sign, off in (("extend", 1, 1.0), ("retract", -1, 1.001)):
            points = tuple(
                SimpleNamespace(
                    v_m_s=sign * v * off,
                    f_applied_n=load + sign * 20 * v,
                    friction_n=sign * (300 + 500 * v) + middle(load),
                    ci95_n=ci95_n,
                    u95_n=u95_n,
                )
                for v in speeds
            )
            series = dict(kind="steady", label="", factors=(), specimen=None, a_ref_m_s2=None)
            made.append(
                SimpleNamespace(
                    **series, p_lr_ref_pa=None, f_load_n=load, direction=direction, points=points
                )
            )
    return made


@pytest.mark.parametrize("speeds", [SPEEDS, CLOSE])
def test_neighbouring_speeds_of_one_load_are_no_loads(speeds):
    assert not list(load_balance(curves([1000.0], speeds)))
    assert not list(equal_directions(curves([1000.0], speeds)))


@pytest.mark.parametrize("speeds", [SPEEDS, CLOSE])
def test_a_part_of_the_load_in_both_directions_is_found_whatever_the_steps_of_speed(speeds):
    right, wrong = curves([500.0, 4000.0], speeds), curves([500.0, 4000.0], speeds, lambda f: f / 5)
    (balance,) = load_balance(right)
    assert balance.grade == "good" and balance.value < 0.1
    (balance,) = load_balance(wrong)
    assert balance.grade == "poor" and balance.value == pytest.approx(20, abs=0.1)


def test_a_change_that_is_small_beside_friction_does_not_matter():
    (balance,) = load_balance(curves([0.0, 50.0], middle=lambda load: 7 * load / 50))
    assert balance.grade == "good" and balance.value == pytest.approx(14, abs=0.1)


@pytest.mark.parametrize("direction", ["extend", "retract"])
@pytest.mark.parametrize(
    ("share", "grade"), [(0.0, None), (0.3, None), (0.75, "with care"), (3.0, "poor")]
)
def test_friction_of_one_direction_that_takes_a_large_part_of_the_load_is_named(
    direction, share, grade
):
    """A bore that is twice as large adds three times the load to the friction."""
    both = curves([500.0, 4000.0], middle=lambda load: share * load)
    assert not list(load_share(both))  # load_balance shows it
    found = list(load_share(curve for curve in both if curve.direction == direction))
    assert [check.grade for check in found] == ([grade] if grade else [])
    assert all(check.value == pytest.approx(100 * share, abs=0.1) for check in found)


def test_friction_of_one_direction_under_one_load_has_no_such_check():
    alone = curves([1000.0], middle=lambda load: 3 * load)
    assert not list(load_share(curve for curve in alone if curve.direction == "extend"))


def test_a_difference_of_the_directions_within_the_instruments_uncertainty_is_none():
    uneven = {"loads_n": [1000.0], "middle": lambda load: 200.0}
    assert list(equal_directions(curves(**uneven)))
    assert not list(equal_directions(curves(**uneven, u95_n=150.0)))


def loop(offset_n):
    """Return a triangle's loop of 100 N of friction, with a constant force in both directions."""
    v = 0.1 * np.cos(np.linspace(0, 2 * np.pi, 100, endpoint=False))
    trace = np.column_stack([np.zeros(100), v, 100 * np.sign(v) + offset_n])
    return SimpleNamespace(series=SimpleNamespace(f_load_n=0.0), trace=trace)


@pytest.mark.parametrize(("offset_n", "grade"), [(50.0, "with care"), (-500.0, "poor")])
def test_a_constant_force_in_the_loops_of_triangles_is_found(offset_n, grade):
    (check,) = equal_directions((), [loop(offset_n), loop(offset_n)])
    assert (check.grade, check.count, check.of) == (grade, 2, 2)
    assert check.value == pytest.approx(abs(offset_n))
    assert not list(equal_directions((), [loop(20.0)]))


@pytest.mark.parametrize(("load_n", "beside"), [(4000.0, ""), (272.0, "1.3 times"), (0.0, "")])
def test_friction_of_one_direction_beyond_the_load_is_noted(load_n, beside):
    """Such as 272 kgf read as N; a test without load has no such note."""
    alone = [c for c in curves([load_n], speeds=[0.05, 0.1, 0.12]) if c.direction == "extend"]
    for curve in alone if not load_n else ():
        for point in curve.points:
            point.f_applied_n = 0.0
    (note,) = direction_notes(alone)
    assert ("times the applied force" in note) is bool(beside)
    assert beside in note


def test_directions_with_labels_of_their_own_are_not_compared_and_noted():
    """A weight of 250 N is then found by no check."""
    both = curves([1000.0, 4000.0], speeds=[0.05, 0.1, 0.12], middle=lambda load: 250.0, u95_n=20.0)
    (note,) = direction_notes(both)
    assert "250 N" in note
    for curve in both:
        curve.label = {"extend": "up", "retract": "down"}[curve.direction]
    assert not list(equal_directions(both))
    (note,) = direction_notes(both)
    assert "Give series such as 'up' and 'down' the same label" in note
    both[0].label = "down"  # this one has both directions
    (note,) = direction_notes(both)
    assert "250 N" in note
