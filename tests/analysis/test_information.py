"""Identifiability from the Fisher information, against what adding the named point does."""

import re

import numpy as np
import pytest

from hbench.analysis.fitting.fit import fit_law
from hbench.analysis.fitting.information import (
    Information,
    covariance_of_all,
    identification_messages,
    undetermined,
)
from hbench.analysis.fitting.tustin import TUSTIN_LAW, tustin_friction, tustin_jacobian
from hbench.config.fitting import Fitting
from hbench.config.setup import Reach
from tests.support.analysis.fits import fit_tustin

TRUTH = np.array([250.0, 500.0, 0.07, 1500.0])


def seen(speeds, p=TRUTH, sigma=1.0):
    inputs = np.array([speeds, np.full(len(speeds), 5e6), np.full(len(speeds), 2e6)])
    scale = np.array([500.0, 500.0, 0.2, 500.0 / speeds.max()])
    return Information(TUSTIN_LAW, p, tustin_jacobian(speeds, p), sigma**2, scale, inputs)


def messages_of(info):
    return identification_messages(info, undetermined(info, 2.2))


def test_low_speeds_alone_lack_those_above():
    (message,) = [
        one
        for one in messages_of(seen(np.linspace(0.005, 0.05, 15), sigma=3.0))
        if "b_viscous" in one
    ]
    assert re.search(r" needs? \w+ above 50 mm/s\b", message)


def test_high_speeds_alone_lack_those_below():
    messages = messages_of(seen(np.linspace(0.1, 0.2, 15), sigma=3.0))
    (message,) = [one for one in messages if "f_stiction_n" in one]
    assert re.search(r" needs? \w+ below 100 mm/s\b", message)


def test_speeds_over_the_whole_curve_lack_nothing():
    assert messages_of(seen(np.linspace(0.005, 0.2, 15))) == []


def test_a_point_beyond_the_reach_of_the_bench_is_not_recommended():
    slow = seen(np.linspace(0.005, 0.05, 15), sigma=3.0)
    free, limited = (messages_of(slow._replace(reach=Reach(at))) for at in (np.inf, 0.08))
    speeds = [
        [float(at) for at in re.findall(r"a point at (\S+) mm/s", " ".join(messages))]
        for messages in (free, limited)
    ]
    assert max(speeds[0]) > 80 and max(speeds[1]) == 80
    caveat = "whether the bench reaches this speed is not known"
    assert caveat in " ".join(free) and caveat not in " ".join(limited)


def test_without_a_stribeck_part_no_velocity_tells_its_speed():
    flat = np.array([300.0, 300.0, 0.1, 1000.0])
    messages = messages_of(seen(np.linspace(0.005, 0.2, 15), flat))
    (message,) = [one for one in messages if "v_stribeck" in one]
    assert " m/s" not in message


def test_the_point_that_is_named_narrows_the_interval_as_is_told():
    """Against the information matrix with that point's row in it."""
    speeds = np.linspace(0.005, 0.05, 15)
    one = seen(speeds, sigma=3.0)
    (message,) = [m for m in messages_of(one) if "b_viscous" in m]
    at, left = re.search(r" at (\S+) mm/s\b.* (\d+) %", message).groups()
    more = seen(np.append(speeds, 1e-3 * float(at)), sigma=3.0)._replace(scale=one.scale)
    ratio = np.sqrt(covariance_of_all(more)[3, 3] / covariance_of_all(one)[3, 3])
    assert 100 * ratio == pytest.approx(float(left), abs=1.0)


def test_speeds_that_are_named_as_missing_determine_the_parameter_when_added(make_curve):
    rng = np.random.default_rng(1)

    def fitted(speeds):
        friction = tustin_friction(speeds, TRUTH) + 3 * rng.standard_normal(len(speeds))
        wide = {"v_stribeck_m_s": (0.01, 1.0), "b_viscous_n_s_m": (-1e5, 1e5)}
        return fit_tustin(make_curve(speeds, friction), wide)

    slow = np.linspace(0.005, 0.05, 15)
    missing = re.compile(r"\bb_viscous_n_s_m\b[^;]* above \S+ mm/s\b")
    assert missing.search(fitted(slow).message)
    more = fitted(np.append(slow, np.linspace(0.06, 0.2, 6)))
    assert not missing.search(more.message)


def test_friction_that_is_badly_known_beyond_the_highest_speed_is_warned_of(make_curve):
    speeds = np.linspace(0.005, 0.05, 15)
    rest = np.random.default_rng(3).standard_normal(15)
    noisy = fit_law(
        TUSTIN_LAW, [make_curve(speeds, tustin_friction(speeds, TRUTH) + 10 * rest)], Fitting()
    )
    assert "extrapolate" in noisy.message and "60 mm/s" in noisy.message
    exact = fit_law(
        TUSTIN_LAW, [make_curve(speeds, tustin_friction(speeds, TRUTH) + 0.1 * rest)], Fitting()
    )
    assert "extrapolate" not in exact.message
