"""The source's fits in closed loop with the firmware: which hold, and that the slope decides."""

from pathlib import Path

import numpy as np
import pytest

from hbench.config.bench import parse_bench
from hbench.config.files.loading import read_yaml
from hbench.model.build import plant_parameters
from hbench.studies.instability import FITS, fastest, least_slope, ripple, tried

DATA = read_yaml(Path(__file__).parents[2] / "configs" / "bench-aau.yaml")
BENCH = parse_bench(DATA, "bench")
PAR = plant_parameters(BENCH)
LOOPS = [
    (loop.gain, loop.time_constant)
    for loop in (
        BENCH.controllers.velocity,
        BENCH.controllers.rod_pressure,
        BENCH.controllers.piston_pressure,
    )
]


@pytest.mark.parametrize("name", FITS)
def test_no_fit_holds_50_mm_s_as_a_static_law(name):
    one = tried(DATA, FITS[name], "tustin", 0.05)
    assert one.fault
    assert ripple(one.run) > 0.05  # m/s
    assert fastest(PAR, FITS[name], 0.05, LOOPS).plant > 100.0


def test_table_6_5_steady_holds_197_mm_s_alone():
    for name, fit in FITS.items():
        assert (not tried(DATA, fit, "tustin", 0.197).fault) == (name == "6.5 steady")
        assert (fastest(PAR, fit, 0.197, LOOPS).loop < 0) == (name == "6.5 steady")


def test_a_tenth_of_the_gain_does_not_help():
    for fit in FITS.values():
        assert fastest(PAR, fit, 0.05, LOOPS).tenth > 80.0


@pytest.mark.parametrize("speed", [0.01, 0.05, 0.197])
@pytest.mark.parametrize("name", ["6.4 steady", "6.5 steady"])
def test_with_lugre_the_steady_fits_hold(name, speed):
    one = tried(DATA, FITS[name], "lugre", speed)
    assert not one.fault and ripple(one.run) < 1e-3
    assert fastest(PAR, FITS[name], speed, LOOPS).lugre < 0


@pytest.mark.parametrize("name", [name for name in FITS if name.endswith("steady")])
def test_the_way_back_at_150_mm_s_throws_6_2_and_6_3_off(name):
    """Eigenvalues judge small disturbances; this one is large."""
    fault = tried(DATA, FITS[name], "lugre", 0.05, start="50 mm").fault
    assert bool(fault) == (name in ("6.2 steady", "6.3 steady"))
    assert fastest(PAR, FITS[name], -0.15, LOOPS).lugre < 0


@pytest.mark.parametrize("name", [name for name in FITS if name.endswith("ramp")])
def test_with_lugre_the_ramp_fits_do_not_for_want_of_viscous_friction(name):
    assert tried(DATA, FITS[name], "lugre", 0.05).fault
    assert fastest(PAR, FITS[name], 0.05, LOOPS).lugre > 20.0
    assert 2 * FITS[name].viscous_n_s_m < least_slope(PAR, LOOPS, (0.0, 0.0))


def test_the_static_fit_holds_with_a_viscous_load_cylinder():
    assert not tried(DATA, FITS["6.2 steady"], "tustin", 0.05, 7000.0).fault
    assert not tried(DATA, FITS["6.5 steady"], "tustin", 0.05, 4662.0).fault
    assert tried(DATA, FITS["6.2 steady"], "tustin", 0.05, 2331.0).fault


def test_the_slope_that_the_loops_need_parts_what_holds_from_what_does_not():
    """On the board: a viscous bench on either side of it, in the nonlinear closed loop."""
    control = BENCH.controllers
    needed = least_slope(PAR, LOOPS, (control.velocity_filter, control.pressure_filter))
    assert needed == pytest.approx(least_slope(PAR, LOOPS, (0.0, 0.0)), rel=0.15)
    f_c = FITS["6.2 steady"]._replace(coulomb_n=50.0, stiction_n=50.0)
    for ratio, held in ((0.8, False), (1.2, True)):
        fit = f_c._replace(viscous_n_s_m=0.5 * ratio * needed)
        one = tried(DATA, fit, "tustin", 0.05)
        assert (not one.fault) == held
        assert np.isfinite(ripple(one.run))


def test_stiff_bristles_are_a_static_law_again(monkeypatch):
    from hbench.studies import instability

    assert fastest(PAR, FITS["6.2 steady"], 0.05, LOOPS).lugre < 0
    monkeypatch.setattr(instability, "SIGMA_0", 1e6)
    assert fastest(PAR, FITS["6.2 steady"], 0.05, LOOPS).lugre > 20.0
