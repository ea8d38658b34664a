"""Runs of one session end to end: each has the values that it has alone."""

from dataclasses import fields, replace

import numpy as np
import pytest
from scipy.signal import savgol_filter

from hbench.config.bench import parse_plant
from hbench.errors import DataError
from hbench.model.plant import initial_state
from hbench.motion.standstill import standstill
from hbench.reconcile.measured.balances import (
    BALANCES,
    balance_model,
    balance_values,
    operating_conditions,
    residuals,
)
from hbench.reconcile.measured.comparable_runs import log_remarks
from hbench.reconcile.measured.session import averaged, sessions
from hbench.records import Run
from tests.support.reconcile.exact_logs import logged, smooth_strokes

EFFECTS = {
    "tank_back_pressure": {"resistance": "0.05 bar min^2/l^2"},
    "friction_lag": {"time": "60 ms"},
}

ROUNDING = np.array([*[1e-14] * 4, 1e-6, 1e-6, 1e-10, 1e-3])


@pytest.fixture(scope="module")
def model(bench_data):
    """With effects, so that something goes on along a log; residuals of another plant's logs."""
    return balance_model(None, parse_plant(bench_data, {"effects": EFFECTS}, ""))


@pytest.fixture(scope="module")
def runs(bench_data):
    """Four runs of different lengths, with noise."""
    par = balance_model(None, parse_plant(bench_data, {}, "")).par
    rng, made = np.random.default_rng(0), []
    for number, seconds in enumerate((2.6, 1.3, 3.0, 2.0)):
        start = initial_state(par, 0.12 + 0.03 * number, 15e5, (18 + number) * 1e5)
        log, _ = logged(f"{number:04d}", par, start, smooth_strokes(seconds), trial=number)
        noisy = log.p_tp_pa + 1e4 * rng.standard_normal(len(log.t_s))
        supply = log.p_s_pa + 10 * rng.standard_normal(len(log.t_s))
        made.append(replace(log, p_tp_pa=noisy, p_s_pa=supply, t_s=log.t_s + 7.0 * number))
    return tuple(made)


def same(values, others):
    """But for the rounding of sums, which is another one in longer matrices."""
    assert values.shape == others.shape
    np.testing.assert_allclose(values / ROUNDING, others / ROUNDING, rtol=0, atol=1)


def halved(run):
    """The run with means over two records."""
    arrays = {
        name: value.reshape(-1, 2).mean(axis=1)
        for name, value in vars(run).items()
        if isinstance(value, np.ndarray) and value.shape == run.t_s.shape
    }
    return replace(run, **arrays)


def test_values_of_several_runs_are_those_of_single_runs(model, runs):
    (together,) = sessions(runs)
    values = balance_values(together, model)
    edges = np.cumsum([0, *together.counts])
    assert len(values) == edges[-1] and np.array_equal(together.counts, [31, 15, 36, 24])
    for number, run in enumerate(runs):
        own = slice(edges[number], edges[number + 1])
        (alone,) = sessions([run])
        same(values[own], balance_values(alone, model))
        same(values[own], residuals(run, model).values)
        assert np.all(together.run_of_window[own] == number)
        for both, single in zip(
            operating_conditions(together, model), operating_conditions(alone, model), strict=True
        ):
            assert both[own] == pytest.approx(single, rel=1e-12)
    assert np.isfinite(values[:, BALANCES.index("flow_tp")]).all()


def test_no_window_reaches_over_the_end_of_a_run(model, runs):
    """Another run beside it changes no window, however different it is."""
    strange = replace(runs[1], p_tp_pa=3 * runs[1].p_tp_pa, x_m=0.3 - runs[1].x_m)
    (one,), (other,) = sessions(runs[:2]), sessions([runs[0], strange])
    first = slice(0, one.counts[0])
    values = [balance_values(each, model) for each in (one, other)]
    same(values[0][first], values[1][first])
    assert np.abs(values[0] - values[1])[one.counts[0] :, 0].max() > 1e-6


def test_each_sampling_is_a_session_of_its_own_and_runs_keep_their_order(model, runs):
    slow = [halved(run) for run in runs[:2]]
    found = sessions([runs[0], slow[0], runs[1], slow[1]])
    assert [[run.plan.run for run in one.runs] for one in found] == [["0000", "0001"]] * 2
    assert [one.window.dt_s for one in found] == pytest.approx([0.01, 0.02])
    assert [len(one.window.value) for one in found] == [16, 8]
    for one in found:
        values = balance_values(one, model)
        single = [residuals(run, model).values for run in one.runs]
        same(values, np.concatenate(single))


def test_a_missing_channel_is_missing_in_its_own_run_alone(model, runs):
    without = replace(runs[1], p_lp_pa=None)
    (found,) = sessions([runs[0], without, runs[2]])
    values = balance_values(found, model)
    compared = [np.isfinite(values[found.run_of_window == i]).all(axis=0) for i in range(3)]
    whole = np.array([name != "kinematics" for name in BALANCES])  # the board is unknown
    needs_none_of_it = np.isin(BALANCES, ("flow_tp", "flow_tr", "force_test", "supply"))
    assert np.array_equal(compared, [whole, needs_none_of_it, whole])
    load = operating_conditions(found, model)[3]
    assert np.array_equal(np.isnan(load), found.run_of_window == 1)


def test_a_run_that_is_shorter_than_a_window_has_none(model, runs):
    short = replace(
        runs[1],
        **{
            name: value[:5]
            for name, value in vars(runs[1]).items()
            if isinstance(value, np.ndarray) and value.shape == runs[1].t_s.shape
        },
    )
    (found,) = sessions([runs[0], short, runs[2]])
    assert list(found.counts) == [31, 0, 36]
    values = balance_values(found, model)
    same(values[:31], residuals(runs[0], model).values)
    same(values[31:], residuals(runs[2], model).values)
    (only,) = sessions([short])
    assert balance_values(only, model).shape == (0, len(BALANCES))


def test_velocity_is_the_derivative_of_the_position(runs):
    (found,) = sessions(runs[:2])
    assert found.velocity_m_s == pytest.approx(found.channels["v_m_s"], abs=2e-4)
    assert np.abs(found.velocity_m_s).max() > 0.05


def test_smoothed_pressures_keep_parabolas_and_lose_noise(runs):
    (found,) = sessions(runs)
    smooth = found.smoothed()
    own = slice(found.edges[1], found.edges[2])
    t = found.channels["t_s"][own] - found.channels["t_s"][own][0]
    parabola = 50e5 + 3e5 * t - 2e5 * t**2
    channels = {name: value.copy() for name, value in found.channels.items()}
    channels["p_tr_pa"][own] = parabola
    kept = replace(found, channels=channels).smoothed()
    assert kept.channels["p_tr_pa"][own] == pytest.approx(parabola, rel=1e-9)
    rough, soft = (
        np.diff(each.channels["p_tp_pa"][: found.edges[1]], 3).std() for each in (found, smooth)
    )
    assert soft < 0.5 * rough
    for name in ("x_m", "u_t_v", "f_applied_n"):
        assert smooth.channels[name] is found.channels[name]


def test_uneven_samples_and_a_single_one_are_refused(runs):
    t = runs[0].t_s.copy()
    t[50:] += 0.02
    with pytest.raises(DataError, match=r"run 0000: .*0\.01 to 0\.03 s"):
        sessions([runs[1], replace(runs[0], t_s=t)])
    with pytest.raises(DataError, match=r"run 0000: 1 samples"):
        sessions([Run(runs[0].plan, t_s=np.zeros(1), x_m=np.zeros(1))])


# ---- oscillations that a log does not resolve


def with_command(run, command):
    return replace(run, u_t_v=run.u_t_v + command)


def test_a_sustained_oscillation_is_found_where_it_is_and_a_step_is_none(runs):
    """45 Hz in a log of 100 Hz for a second; noise everywhere; a step of 5 V in another run."""
    rng = np.random.default_rng(4)
    noisy = [with_command(run, 0.01 * rng.standard_normal(len(run.t_s))) for run in runs]
    t = noisy[2].t_s - noisy[2].t_s[0]
    fast = np.where((t > 1.0) & (t < 2.0), 0.5 * np.sin(2 * np.pi * 45.0 * t), 0.0)
    step = np.where(np.arange(len(noisy[0].t_s)) > 100, 5.0, 0.0)
    changed = [with_command(noisy[0], step), noisy[1], with_command(noisy[2], fast), noisy[3]]
    (session,) = sessions(changed)
    centre = session.mean(session.channels["t_s"]) - changed[2].t_s[0]
    inside = (session.run_of_window == 2) & (centre > 1.05) & (centre < 1.95)
    outside = (session.run_of_window != 2) | (centre < 0.9) | (centre > 2.1)
    assert session.oscillating[inside].all() and not session.oscillating[outside].any()


def test_a_log_almost_without_noise_has_no_oscillation_where_it_merely_moves(runs):
    """A command of 3 Hz for a second deviates from polynomials by far more than a constant one."""
    t = runs[2].t_s - runs[2].t_s[0]
    smooth = np.where((t > 1.0) & (t < 2.0), 2.0 * np.sin(6 * np.pi * (t - 1.0)) ** 2, 0.0)
    rounding = 1e-6 * np.random.default_rng(5).standard_normal(len(t))
    (session,) = sessions([replace(runs[2], u_t_v=smooth + rounding)])
    assert not session.oscillating.any()


def with_oscillating(session, windows):
    """Return a session of which these windows oscillate."""
    other = replace(session)
    vars(other)["oscillating"] = windows  # where a cached property keeps its value
    return other


def test_balances_with_laws_leave_oscillating_windows_out(runs, model):
    (session,) = sessions(runs)
    marked = with_oscillating(session, np.arange(session.counts.sum()) == 7)
    before, after = (balance_values(each, model) for each in (session, marked))
    assert np.isfinite(before[7, :6]).all() and np.isnan(after[7, :6]).all()
    np.testing.assert_array_equal(before[7, 6:], after[7, 6:])
    np.testing.assert_array_equal(np.delete(before, 7, axis=0), np.delete(after, 7, axis=0))


def test_the_diagnosis_says_in_which_runs_the_control_oscillates(runs):
    """A run is named from a quarter of its windows on."""
    (session,) = sessions(runs)
    first, third = (np.flatnonzero(session.run_of_window == i) for i in (0, 2))
    found = np.zeros(session.counts.sum(), bool)
    found[[*first[:2], *third[: len(third) // 2]]] = True
    (remark,) = log_remarks((with_oscillating(session, found),))
    assert f"(run {runs[2].plan.run})" in remark and runs[0].plan.run not in remark
    assert log_remarks((session,)) == ()
    assert "Faster logs do not help" in remark and "records of 10 ms" in remark
    (slower,) = sessions([replace(run, t_s=2.0 * run.t_s) for run in runs])
    found = np.zeros(slower.counts.sum(), bool)
    found[slower.run_of_window == 2] = True
    (remark,) = log_remarks((with_oscillating(slower, found),))
    assert remark.endswith("Log faster, or lower the gains of the loops.") and "20 ms" in remark


def test_the_flow_of_a_cavitating_chamber_is_left_out_and_the_diagnosis_says_so(runs, model):
    """The load piston's chamber, for three records of the third run."""
    p_lp = runs[2].p_lp_pa.copy()
    p_lp[100:103] = -0.6e5
    (session,) = sessions([*runs[:2], replace(runs[2], p_lp_pa=p_lp), *runs[3:]])
    values, lp = balance_values(session, model), BALANCES.index("flow_lp")
    low = np.flatnonzero(session.cavitating.any(axis=1))
    assert len(low) and np.all(session.run_of_window[low] == 2)
    others = np.setdiff1d(np.arange(6), lp)
    assert np.isnan(values[low, lp]).all() and np.isfinite(values[np.ix_(low, others)]).all()
    assert np.isfinite(np.delete(values[:, lp], low)).all()
    np.testing.assert_array_equal(session.smoothed().cavitating, session.cavitating)
    (remark,) = log_remarks((session,))
    assert f"below -0.3 bar (run {runs[2].plan.run})" in remark
    assert log_remarks(sessions(runs)) == ()


def test_a_supply_pressure_that_is_a_constant_of_the_map_is_remarked(runs):
    stated = [replace(run, p_s_pa=np.full(len(run.t_s), 140e5)) for run in runs]
    (remark,) = log_remarks(sessions(stated))
    assert "supply pressure is a constant" in remark and "measure P_S" in remark
    assert log_remarks(sessions([replace(run, p_s_pa=None) for run in runs])) == ()


def test_smoothed_logs_oscillate_where_the_logs_do(runs):
    (session,) = sessions(runs)
    marked = with_oscillating(session, np.arange(session.counts.sum()) % 2 == 0)
    np.testing.assert_array_equal(marked.smoothed().oscillating, marked.oscillating)


@pytest.mark.parametrize(("rate_hz", "count"), [(50, 1), (100, 1), (125, 1), (250, 2), (1000, 10)])
@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_fast_and_uneven_logs_become_means_over_10_ms(runs, rate_hz, count, jitter):
    """Against the integrals of the straight lines through the samples, in 1000 parts."""
    rng = np.random.default_rng(1)
    t = (np.arange(1003) + jitter * rng.uniform(-1, 1, 1003)) / rate_hz
    p = rng.standard_normal(len(t))
    found = averaged(Run(runs[0].plan, t_s=t, x_m=0.1 * t, p_tp_pa=p))
    if count == 1 and not jitter:
        assert found.p_tp_pa is p
        return
    width = np.diff(found.t_s)
    expected = max(0.01, 1 / rate_hz) if jitter else count / rate_hz
    np.testing.assert_allclose(width, expected, rtol=1e-9)
    assert found.f_applied_n is None
    np.testing.assert_allclose(found.x_m, 0.1 * found.t_s, atol=1e-9)
    for k in (0, 17, len(found.t_s) - 1):
        inside = found.t_s[k] + width[0] * (np.arange(1000) - 499.5) / 1000
        assert found.p_tp_pa[k] == pytest.approx(np.interp(inside, t, p).mean(), abs=1e-2)


def test_a_gap_in_a_log_is_not_bridged(runs):
    """Its records are marked, and no balance of a window with one of them is compared."""
    t = np.delete(0.004 * np.arange(500), slice(200, 210))
    run = averaged(Run(runs[0].plan, t_s=t, x_m=t))
    inside = (run.t_s > t[199] - 0.005) & (run.t_s < t[200] + 0.005)
    np.testing.assert_array_equal(run.in_gap, inside)
    short = np.delete(0.004 * np.arange(500), slice(200, 206))
    assert averaged(Run(runs[0].plan, t_s=short, x_m=short)).in_gap is None


def test_balances_leave_the_windows_of_a_gap_out(model, runs):
    """The flows of the others are those of the whole log, but for a spool's memory of the gap."""
    fine = 0.002 * np.arange(1200)
    channels = {
        field.name: np.interp(fine, runs[2].t_s - runs[2].t_s[0], value)
        for field in fields(Run)
        if isinstance(value := getattr(runs[2], field.name), np.ndarray) and value.dtype == float
    }
    whole = replace(runs[2], **channels | {"t_s": fine})
    kept = np.delete(np.arange(1200), slice(500, 530))
    cut = replace(
        runs[2], **{name: value[kept] for name, value in (channels | {"t_s": fine}).items()}
    )
    (expected,) = (balance_values(*sessions([averaged(each)]), model) for each in [whole])
    (session,) = sessions([averaged(cut)])
    found = balance_values(session, model)
    assert session.with_gaps.any() and np.isnan(found[session.with_gaps]).all()
    flows = BALANCES.index("flow_lr") + 1
    others = ~session.with_gaps
    error = np.abs(found - expected)[others, :flows]
    assert np.isfinite(error).all()
    assert np.all(error.max(axis=0) < 0.05 * np.abs(expected[:, :flows]).max(axis=0))
    assert any("Samples are missing" in each for each in log_remarks([session]))


def test_a_log_that_is_mostly_gaps_is_left_out(runs):
    t = np.concatenate([0.004 * np.arange(100), 5.0 + 0.004 * np.arange(100)])
    with pytest.raises(DataError, match=r"gaps of up to 4.6 s .* make up 86 % .*limit: 50 %"):
        averaged(Run(runs[0].plan, t_s=t, x_m=t))


@pytest.mark.parametrize("speed", [0.0, 2e-5, 5e-4, 0.02])
def test_noise_at_rest_is_hardly_a_velocity(runs, speed):
    """2 um of noise on a position that stays for 2 s, creeps or moves, then goes on at 50 mm/s."""
    t = 0.01 * np.arange(400)
    noise = 2e-6 * np.random.default_rng(1).standard_normal(400)
    x = 0.1 + speed * np.minimum(t, 2.0) + 0.05 * np.maximum(t - 2.0, 0.0) + noise
    (session,) = sessions([Run(runs[0].plan, t_s=t, x_m=x)])
    v = session.velocity_m_s
    still = speed < 1e-4
    assert np.abs(v[:180] - speed).mean() < (1e-5 if still else 3e-4)
    assert np.mean(v[:180]) == pytest.approx(speed, abs=1e-5)
    np.testing.assert_allclose(v[220:380], 0.05, atol=1e-3)
    fine = savgol_filter(x, 5, 4, deriv=1, delta=0.01)
    assert np.abs(fine[:180] - speed).mean() > 1e-4


def test_each_run_is_filtered_as_scipy_does(runs):
    (found,) = sessions(runs)
    smooth, velocity = found.smooth("p_tp_pa", 2), found.velocity_m_s
    for run, start in zip(runs, found.edges, strict=False):
        own = slice(start, start + len(run.t_s))
        expected = savgol_filter(run.p_tp_pa, 7, 2)
        np.testing.assert_allclose(smooth[own], expected, rtol=1e-12)
        expected = savgol_filter(run.x_m, 5, 4, deriv=1, delta=found.window.dt_s)
        at_rest, _ = standstill(run.x_m, found.window.dt_s)
        moving = velocity[own][~at_rest]
        np.testing.assert_allclose(moving, expected[~at_rest], atol=1e-9)
        assert np.abs(velocity[own][at_rest]).max(initial=0.0) < 1e-8


def test_a_piston_that_has_stopped_does_not_move_to_and_fro_by_the_noise(runs):
    """Of 5 um at 100 Hz; the path of 50 ms slopes in the 0.15 s after a stop is 55 um."""
    t = 0.01 * np.arange(220)
    s = np.clip((t - 0.6) / 0.5, 0, 1)
    way = 0.02 * np.where(s < 0.5, 2 * s**2, 1 - 2 * (1 - s) ** 2)
    rng = np.random.default_rng(3)
    stopped = [
        Run(runs[0].plan, t_s=t, x_m=0.1 + way + 5e-6 * rng.standard_normal(len(t)))
        for _ in range(20)
    ]
    (found,) = sessions(stopped)
    after = (t > 1.1) & (t < 1.25)
    paths = 0.01 * np.abs(found.velocity_m_s.reshape(20, -1)[:, after]).sum(axis=1)
    assert np.median(paths) < 16e-6
