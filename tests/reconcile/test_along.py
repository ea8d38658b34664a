"""Laws along a log: against the plant that made the log, and against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.config.bench import parse_plant
from hbench.model.cylinders import extending_volumes
from hbench.model.plant import initial_state
from hbench.reconcile.measured import along as measured_along
from hbench.reconcile.measured.along import STEP_S, along, single_start
from hbench.reconcile.measured.balances import (
    BALANCES,
    FLOWS,
    balance_model,
    balance_values,
    channels_missing,
)
from hbench.reconcile.measured.integration import Starts, integrate_logs
from hbench.reconcile.measured.session import sessions
from tests.support.pump import PUMP
from tests.support.reconcile.exact_logs import RECORD_S, logged, record_means, smooth_strokes

BAR = 1e5
FORCES = ("force_test", "force_load")
# Flows are up to 1e-4 m^3/s, dry friction 100 N, and the supply has 150 bar.
LIMITS = {**dict.fromkeys(FLOWS, 2e-8), **dict.fromkeys(FORCES, 0.5), "supply": 200.0}

# Residuals that the model without the effect has, at least: 20 limits. A state that is late by
# half a step of 1 ms would leave a tenth of that of a lag of 5 ms: two limits.
CASES = [
    ({"valve_lag": {"time": "5 ms"}}, FLOWS),
    ({"valve_hysteresis": {"test": "0.1 V", "load": "0.1 V"}}, FLOWS),
    ({"tank_back_pressure": {"resistance": "0.05 bar min^2/l^2"}}, FLOWS),
    ({"presliding": {"force": "100 N", "length": "2 mm"}}, ("force_test",)),
    ({"friction_lag": {"time": "60 ms"}}, FORCES),
    ({"supply_droop": {"slope": "1 bar min/l"}}, ("supply",)),
    ({"added_mass": {"test": "40 kg"}}, ("force_test",)),
    ({"internal_leakage": {"test": "3e-3 l/min/bar"}}, ("flow_tp", "flow_tr")),
    ({"entrained_air": {"fraction": "5 %"}}, ("flow_lr",)),
    ({"valve_trim": {"gain_test": "5 %", "null_load_1": "0.05 V", "null_load_2": "0.1 V"}}, FLOWS),
    ({"valve_trim": {"exponent": "0.05 1", "curvature": "0.02 1/V"}}, FLOWS),
    ({"valve_trim": {"ports": "2 %", "inlets": "-4 %"}}, ("flow_tp", "flow_tr")),
    ({"valve_trim": {"hose": "0.2 bar min/l"}}, FLOWS),
    ({"valve_trim": {"small": "10 %"}}, FLOWS),
    ({"valve_trim": {"leak": "0.1 V"}}, FLOWS),
    ({"valve_trim": {"null_leak": "0.1 V"}}, FLOWS),
]


@pytest.fixture(scope="module")
def plant_with(bench_data):
    """Return a plant with some effects, as balances' model that reads ideal sensors."""
    return lambda effects: balance_model(None, parse_plant(bench_data, {"effects": effects}, ""))


def strokes(model, count=1):
    """Logs of one stroke out and back after the other."""
    state, logs = initial_state(model.par, 0.15, 15 * BAR, 20 * BAR), []
    for number in range(count):
        log, made = logged(f"{number:04d}", model.par, state, smooth_strokes())
        state = made.state[-1]
        logs.append(log)
    return logs


def largest(logs, model, after_s=0.0):
    """Largest residual of each balance from ``after_s`` after each log's start, by name."""
    (session,) = sessions(logs)
    values = balance_values(session, model)
    start = session.channels["t_s"][session.edges[:-1]][session.run_of_window]
    values = values[session.mean(session.channels["t_s"]) - start > after_s]
    found = np.abs(values).max(axis=0)
    return {name: found[BALANCES.index(name)] for name in LIMITS}


@pytest.mark.parametrize(("effects", "touched"), CASES, ids=lambda case: "-".join(case))
def test_a_simulated_log_fits_its_own_effect_and_no_other_model(plant_with, effects, touched):
    """From 0.6 s on: with a leak the piston creeps from the start, and its bristles with it."""
    right = plant_with(effects)
    logs = strokes(right)
    found = largest(logs, right, 0.6)
    assert {name: value for name, value in found.items() if value > LIMITS[name]} == {}
    plain = largest(logs, plant_with({}), 0.6)
    assert {name for name in touched if plain[name] < 20 * LIMITS[name]} == set()


def test_a_log_of_the_plant_without_effects_fits_from_its_start_on(plant_with):
    model = plant_with({})
    found = largest(strokes(model), model)
    assert {name: value for name, value in found.items() if value > LIMITS[name]} == {}


def test_a_log_that_begins_as_the_piston_starts_has_the_friction_of_rest(plant_with):
    """A line through the first two means would go beyond it: by 2.8 N over a millimetre."""
    model = plant_with({})
    _, before = logged("0001", model.par, initial_state(model.par, 0.15, 15 * BAR, 20 * BAR),
                       smooth_strokes())  # fmt: skip
    rising = np.minimum(np.arange(8000) / 300, 1.0)  # 30 ms of 0.8 s
    log, _ = logged("0002", model.par, before.state[-1], rising[:, None] * [0.15, 0.06, -0.3])
    found = largest([log], model)
    assert {name: found[name] for name in FORCES if found[name] > LIMITS[name]} == {}


def test_warmth_goes_on_from_log_to_log(plant_with):
    """Each log alone would begin with cold oil, the third one 25 K too cold."""
    effects = {"oil_warming": {"pump": "30 K", "time": "5 s"}}
    model = plant_with(effects | {"internal_leakage": {"test": "3e-3 l/min/bar"}})
    logs = strokes(model, 3)
    found = largest(logs, model, 0.6)
    assert {name: value for name, value in found.items() if value > LIMITS[name]} == {}
    alone = largest(logs[2:], model, 0.6)
    assert alone["flow_tp"] > 20 * LIMITS["flow_tp"]
    assert alone["force_test"] > 20 * LIMITS["force_test"]


def test_states_that_do_not_build_up_begin_anew_with_each_log(plant_with):
    """A return line's pressure of a log that ends in full motion is not that of the next one."""
    model = plant_with({"tank_back_pressure": {"resistance": "0.05 bar min^2/l^2", "lag": "9 s"}})
    (log,) = strokes(model)
    both, once = (sessions(logs)[0] for logs in ([log, log], [log]))
    values = balance_values(both, model)
    assert values[: len(values) // 2] == pytest.approx(values[len(values) // 2 :], nan_ok=True)
    assert values[: len(values) // 2] == pytest.approx(balance_values(once, model), nan_ok=True)


@pytest.mark.parametrize(
    ("warming", "parts"), [({}, [2, 2, 1]), ({"oil_warming": {"pump": "30 K"}}, [5])]
)
def test_logs_are_integrated_in_parts_where_no_state_goes_from_one_to_the_next(
    plant_with, monkeypatch, warming, parts
):
    """To the bit; with oil that warms, they are not divided."""
    model = plant_with({"friction_lag": {"time": "60 ms"}} | warming)
    (session,) = sessions(strokes(model, 5))
    divided, given = [], Starts.divided

    def recorded(starts, most):
        found = given(starts, most)
        divided.append([len(part.states) for part in found])
        return found

    monkeypatch.setattr(Starts, "divided", recorded)
    values = []
    for cores in (1, 3):
        monkeypatch.setattr(measured_along, "usable_cores", lambda cores=cores: cores)
        values.append(balance_values(session, model))
    assert np.array_equal(*values, equal_nan=True)
    assert divided == [[5], parts]


def test_a_pumps_flow_at_the_measured_pressure_is_what_the_valves_draw(bench_data):
    """In the unit of the band: the pressure sags by 2 bar, and a tenth of it would show."""
    model = balance_model(None, parse_plant(bench_data, {"supply": {"pump": PUMP}}, ""))
    logs = strokes(model)
    assert np.ptp(logs[0].p_s_pa) > 2 * BAR
    assert largest(logs, model)["supply"] < 0.1 * BAR
    other = {"supply": {"pump": PUMP | {"capacity": "1.2 cm^3/bar"}}}
    stiff = balance_model(None, parse_plant(bench_data, other, ""))
    assert largest(logs, stiff)["supply"] > 0.2 * BAR


# ---- closed forms


N, HZ, MEAN_V, SWING_V = 200, 4.0, 3.0, 1.0
DROP = 100 * BAR


def opening_along(model, u, dt=RECORD_S, step_s=STEP_S):
    """Openings [V] of the test valve that the flow into Tp at a constant drop corresponds to."""
    par = model.par
    signals = np.zeros((10, len(u)))
    signals[0] = 0.15
    signals[2:6] = 50 * BAR
    signals[6] = 50 * BAR + DROP
    signals[7] = u
    start = single_start(signals.shape[1], model.par)
    means = along(signals, dt, par, start, np.ones((2, 1)), step_s)
    volume, _ = extending_volumes(0.15, par.test)
    return means.per_volume[0] * volume / (par.valve.flow_gain * np.sqrt(DROP))


def harmonic(response, n=N, dt=RECORD_S):
    """Interval means of MEAN_V + SWING_V Im(response exp(i w t))."""
    w, edges = 2 * np.pi * HZ, np.arange(n + 1) * dt
    swing = np.diff(np.imag(response * np.exp(1j * w * edges) / (1j * w))) / dt
    return MEAN_V + SWING_V * swing


def spool_response(par):
    s = 2j * np.pi * HZ / par.valve.natural_frequency_rad_s
    return 1 / (1 + 2 * par.valve.damping * s + s**2)


@pytest.mark.parametrize("step_s", [STEP_S, 2.5e-3])
def test_the_spool_follows_a_harmonic_command_by_its_transfer_function(plant_with, step_s):
    model = plant_with({})
    found = opening_along(model, harmonic(1.0), step_s=step_s)
    expected = harmonic(spool_response(model.par))
    assert np.abs(found - expected)[40:-2].max() < 2e-3 * SWING_V
    assert np.abs(harmonic(1.0) - expected)[40:-2].max() > 0.05 * SWING_V


@pytest.mark.parametrize("time_ms", [0.1, 0.2, 0.5, 1, 5, 40])
@pytest.mark.parametrize("step_s", [STEP_S, 2.5e-3])
def test_a_first_order_lag_is_its_transfer_function_also_if_shorter_than_a_step(
    plant_with, time_ms, step_s
):
    model = plant_with({"valve_lag": {"time": f"{time_ms} ms"}})
    found = opening_along(model, harmonic(1.0), step_s=step_s)
    lag = 1 / (1 + 2j * np.pi * HZ * time_ms * 1e-3)
    expected = harmonic(spool_response(model.par) * lag)
    late = 2 * np.pi * HZ * step_s / 2 * SWING_V  # by half a step
    assert np.abs(found - expected)[60:-2].max() < 0.1 * late


@pytest.mark.parametrize("time_ms", [0.2, 3, 40])
def test_a_lag_in_two_parts_is_its_transfer_function(plant_with, time_ms):
    model = plant_with({"valve_lag": {"time": f"{time_ms} ms", "second": 0.3}})
    found = opening_along(model, harmonic(1.0), step_s=STEP_S)
    s = 2j * np.pi * HZ * time_ms * 1e-3
    expected = harmonic(spool_response(model.par) / ((1 + 0.7 * s) * (1 + 0.3 * s)))
    late = 2 * np.pi * HZ * STEP_S / 2 * SWING_V  # by half a step
    assert np.abs(found - expected)[60:-2].max() < 0.1 * late


def opening_with_play(plant_with, width_v=0.06, step_s=STEP_S, **others):
    """Openings under a noisy command, with which the play is taken up anywhere in a record."""
    noise = np.random.default_rng(1).normal(0.0, 0.02, N)
    effects = {"valve_hysteresis": {"test": f"{width_v} V"}} | others
    return opening_along(plant_with(effects), 0.1 * harmonic(1.0) + noise, step_s=step_s)


def test_a_change_of_a_plays_width_is_that_of_short_steps_in_long_ones_too(plant_with):
    def change(step_s):
        narrow, wide = (opening_with_play(plant_with, w, step_s) for w in (0.060, 0.063))
        return (wide - narrow) / 0.003

    found, expected = change(5 * STEP_S), change(STEP_S)
    assert np.std(found - expected) < 0.25 * np.sqrt(np.mean(expected**2))


@pytest.mark.parametrize("step_s", [STEP_S, 2.5 * STEP_S])
@pytest.mark.parametrize(
    "other",
    [
        {"valve_lag": {"time": "0.1 ms"}},
        {"tank_back_pressure": {"resistance": "1e-9 bar min^2/l^2"}},
    ],
    ids=lambda other: next(iter(other)),
)
def test_a_play_is_the_same_beside_another_state_that_changes_nothing(plant_with, other, step_s):
    alone, beside = (opening_with_play(plant_with, step_s=step_s, **each) for each in ({}, other))
    assert np.std(beside - alone) < 0.001  # V, of a play of 0.06 V


def test_the_commands_limit_is_that_of_the_valve(plant_with):
    model = plant_with({})
    limit = model.par.valve.limit_v
    found = opening_along(model, np.full(50, 1.5 * limit))
    assert found == pytest.approx(np.full(50, limit))


def test_spools_are_at_rest_at_their_first_command(plant_with):
    found = opening_along(plant_with({}), np.full(20, 2.0))
    assert found == pytest.approx(np.full(20, 2.0))


def test_a_return_line_behind_valves_that_nearly_close_stays_at_rest(plant_with):
    """Its pressure and the lag of the openings are states of their own, at steps of any length."""
    line = {"resistance": "0.004 bar min^2/l^2", "lag": "8 ms", "exponent": 1.7}
    par = plant_with({"tank_back_pressure": line, "valve_lag": {"time": "0.15 ms"}}).par
    signals = np.zeros((10, 200))
    signals[0] = 0.15
    signals[2:6] = 50 * BAR
    signals[6] = 120 * BAR
    signals[7:] = 0.5 * np.exp(-np.arange(200) * RECORD_S / 0.05) + 0.01
    made = [
        along(signals, RECORD_S, par, single_start(200, par), np.ones((2, 1)), step_s)
        for step_s in (STEP_S, STEP_S / 50)
    ]
    coarse, fine = (each.per_volume for each in made)
    assert coarse == pytest.approx(fine, rel=2e-3, abs=1e-6)


def test_compression_and_volume_are_their_integrals(plant_with):
    """Of a pressure that rises linearly: dP / beta, and the logarithm of the geometric volume."""
    model, n = plant_with({}), 50
    signals = np.zeros((10, n))
    t = (np.arange(n) + 0.5) * RECORD_S
    signals[0], signals[1], signals[6] = 0.1 + 0.05 * t, 0.05, 150 * BAR
    signals[2:6] = 40 * BAR + 20 * BAR * t
    start = single_start(signals.shape[1], model.par)
    means = along(signals, RECORD_S, model.par, start, np.ones((2, 1)))
    inner = slice(2, -2)
    slope = np.gradient(means.compression, RECORD_S, axis=1)[:, inner]
    assert slope == pytest.approx(np.full_like(slope, 20 * BAR / model.par.bulk_modulus_pa))
    log_volume = np.log(extending_volumes(0.1 + 0.05 * t, model.par.test)[0])
    assert means.log_volume[0, inner] == pytest.approx(log_volume[inner], abs=1e-6)


def test_levels_of_any_kind_of_array_need_no_further_compilation(plant_with):
    """A compilation takes some 20 s."""
    par, signals = plant_with({}).par, np.zeros((10, 4))
    start = single_start(4, par)
    along(signals, RECORD_S, par, start, np.ones((2, 1)))
    compiled = len(integrate_logs.signatures)
    read_only = np.ones((2, 4))
    read_only.flags.writeable = False
    for levels in (np.ones((2, 4)), np.ones((4, 2)).T, read_only):
        along(signals, RECORD_S, par, start, levels)
    assert len(integrate_logs.signatures) == compiled


@pytest.mark.parametrize("level", [0.8, 1.3])
def test_levels_scale_dry_friction_alone(plant_with, level):
    """In steady sliding: level times the dry part, and the viscous part as it is."""
    model, n = plant_with({}), 100
    signals = np.zeros((10, n))
    signals[0], signals[1], signals[6] = 0.1 + 0.05 * np.arange(n) * RECORD_S, 0.05, 150 * BAR
    signals[2:6] = 50 * BAR
    start = single_start(signals.shape[1], model.par)
    forces = {}
    for each in (1.0, level):
        means = along(signals, RECORD_S, model.par, start, np.array([[each], [1.0]]))
        forces[each] = means.friction_test[-1], means.friction_load[-1]
    viscous = model.par.test.friction.viscous * 0.05
    dry = forces[1.0][0] - viscous
    assert forces[level][0] == pytest.approx(viscous + level * dry, rel=1e-6)
    assert forces[level][1] == forces[1.0][1] and dry > 20.0


def test_bristles_begin_with_the_measured_friction(plant_with):
    """At rest they carry that force for as long as nothing moves."""
    model = plant_with({})
    signals = np.zeros((10, 20))
    signals[0], signals[2:7] = 0.1, 50 * BAR
    start = single_start(signals.shape[1], model.par)
    start = start._replace(friction_n=np.array([[40.0, -25.0]]))
    means = along(signals, RECORD_S, model.par, start, np.ones((2, 1)))
    assert means.friction_test == pytest.approx(np.full(20, 40.0))
    assert means.friction_load == pytest.approx(np.full(20, -25.0))


@pytest.mark.parametrize(
    ("effects", "limit"),
    [({}, 2.0), ({"presliding": {"force": "100 N", "length": "2 mm"}}, 6.0)],
    ids=["bristles", "presliding"],
)
def test_a_log_that_begins_with_the_friction_of_the_stroke_before_has_no_first_error(
    plant_with, effects, limit
):
    """The log begins as the stroke back does; friction then falls by 250 N in 50 ms."""
    model = plant_with(effects)
    (whole,) = strokes(model)
    later = {
        name: value[145:]
        for name, value in vars(whole).items()
        if isinstance(value, np.ndarray) and value.shape == whole.t_s.shape
    }
    (session,) = sessions([replace(whole, **later)])
    values = balance_values(session, model)[:, BALANCES.index("force_test")]
    assert np.abs(values[:4]).max() < limit


def test_friction_along_a_log_is_the_plants(plant_with):
    model = plant_with({})
    state = initial_state(model.par, 0.15, 15 * BAR, 20 * BAR)
    log, made = logged("0001", model.par, state, smooth_strokes())
    assert not channels_missing(log, "force_load")
    u = np.vstack([log.u_t_v, log.u_l1_v, log.u_l2_v])
    pressures = [log.p_tp_pa, log.p_tr_pa, log.p_lp_pa, log.p_lr_pa, log.p_s_pa]
    signals = np.vstack([log.x_m, log.v_m_s, *pressures, u])
    start = single_start(signals.shape[1], model.par)
    means = along(signals, RECORD_S, model.par, start, np.ones((2, 1)))
    for found, force in (
        (means.friction_test, made.friction_test_n),
        (means.friction_load, made.friction_load_n),
    ):
        assert np.abs(found - record_means(force)).max() < 0.5 < 0.01 * np.abs(force).max()
    assert np.abs(means.drawn - record_means(made.q_supply_m3_s)).max() < 1e-7
